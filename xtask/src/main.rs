//! Maintenance tasks of the repository. `cargo xtask codegen` regenerates the code, `cargo xtask fixtures` the data of this
//! version with which later ones are tested.

mod fixtures;
mod imc;

use anyhow::{Context as _, bail};
use std::path::Path;

const USAGE: &str = "usage: cargo xtask codegen [--check] | fixtures [DIR]

codegen    write the generated code again from the catalogues
--check    write nothing; fail when a generated file differs from its catalogue
fixtures   make the data of this version, by the programs in target/debug, in server/tests/fixtures/VERSION, or to try it
           in DIR, which must not be there yet";

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    match arguments.as_slice() {
        ["codegen"] => codegen(false),
        ["codegen", "--check"] => codegen(true),
        ["fixtures"] => fixtures::make(root, None),
        ["fixtures", to] => fixtures::make(root, Some(Path::new(to))),
        _ => bail!("{USAGE}"),
    }
}

fn codegen(check: bool) -> anyhow::Result<()> {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."));
    let mut stale = Vec::new();
    for file in imc::generate(root)? {
        let path = root.join(&file.path);
        if std::fs::read_to_string(&path).is_ok_and(|old| old == file.text) {
            continue;
        }
        if check {
            stale.push(file.path);
        } else {
            std::fs::create_dir_all(path.parent().context("a generated file has a folder")?)?;
            std::fs::write(&path, &file.text).with_context(|| format!("writing {}", path.display()))?;
            println!("wrote {}", file.path);
        }
    }
    if !stale.is_empty() {
        bail!("stale: {}; run `cargo xtask codegen`", stale.join(", "));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn generated_code_is_fresh() {
        super::codegen(true).unwrap();
    }
}
