//! Compiles the crate again when the schema of app.db changed: it holds the migrations.

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=../migrations");
}
