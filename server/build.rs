//! Compiles the crate again when the bundle of the pages or the manual changed: a release build holds both.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    if std::env::var("PROFILE").is_ok_and(|profile| profile == "release") {
        println!("cargo:rerun-if-changed=../web/dist");
        println!("cargo:rerun-if-changed=../docs");
    }
}
