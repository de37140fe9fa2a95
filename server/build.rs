//! Compiles the crate again when the bundle of the pages or the manual changed: a release build holds both. Other builds read
//! the bundle from its folder, whose place is looked up when they are compiled: it must be there by then, be it empty.

fn main() -> std::io::Result<()> {
    println!("cargo:rerun-if-changed=build.rs");
    std::fs::create_dir_all("../web/dist")?;
    if std::env::var("PROFILE").is_ok_and(|profile| profile == "release") {
        println!("cargo:rerun-if-changed=../web/dist");
        println!("cargo:rerun-if-changed=../docs");
    }
    Ok(())
}
