//! Dependency cycles of modules within a crate: two modules that use each other can only be understood together.
//!
//! Read from the `use` lines and the paths in the text. A parent and its children may use each other; a name that a parent
//! re-exports from a child counts as the parent's.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// A module by its path within the crate.
type Module = Vec<String>;

/// The modules of `src` with their text, tests left out.
fn modules(src: &Path) -> BTreeMap<Module, String> {
    let mut all = BTreeMap::new();
    let mut folders = vec![src.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                let name = path.strip_prefix(src).unwrap().with_extension("");
                let mut module: Module = name.iter().map(|part| part.to_str().unwrap().to_owned()).collect();
                module.retain(|part| !["mod", "lib", "main"].contains(&part.as_str()));
                if !module.iter().any(|part| part == "bin" || part.ends_with("tests")) {
                    all.insert(module, outside_tests(&fs::read_to_string(&path).unwrap()));
                }
            }
        }
    }
    all
}

/// The text without comments and without the tests at its end.
fn outside_tests(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// The paths that begin with `crate` or `super`, those in braces one by one.
fn paths(text: &str) -> Vec<String> {
    let mut all = Vec::new();
    for begin in ["crate::", "super::"] {
        for (at, _) in text.match_indices(begin) {
            let before = text[..at].chars().next_back();
            if !before.is_some_and(|letter| letter.is_alphanumeric() || letter == '_' || letter == ':') {
                expand(&path_at(&text[at..]), &mut all);
            }
        }
    }
    all
}

/// The path at the beginning of a text, with its braces, without blanks.
fn path_at(text: &str) -> String {
    let mut depth = 0;
    let part_of = |letter: &char| {
        depth += i32::from(*letter == '{') - i32::from(*letter == '}');
        let inner = depth > 0 || *letter == '}';
        inner || letter.is_alphanumeric() || ['_', ':', '{'].contains(letter)
    };
    text.chars().take_while(part_of).filter(|letter| !letter.is_whitespace()).collect()
}

fn expand(path: &str, all: &mut Vec<String>) {
    let Some((before, inner)) = path.split_once('{') else {
        all.push(path.to_owned());
        return;
    };
    let inner = inner.strip_suffix('}').unwrap_or(inner);
    let (mut depth, mut begin) = (0, 0);
    for (at, letter) in inner.char_indices().chain([(inner.len(), ',')]) {
        depth += i32::from(letter == '{') - i32::from(letter == '}');
        if letter == ',' && depth == 0 {
            expand(&format!("{before}{}", &inner[begin..at]), all);
            begin = at + 1;
        }
    }
}

/// The module that a path in `from` leads to; `None` for itself, its parents and its children.
fn target(from: &Module, path: &str, all: &BTreeMap<Module, String>) -> Option<Module> {
    let mut base = from.clone();
    for part in path.split("::") {
        match part {
            "crate" => base.clear(),
            "super" => drop(base.pop()),
            "self" => {}
            other => base.push(other.to_owned()),
        }
    }
    while !all.contains_key(&base) {
        base.pop()?;
    }
    let kin = from.starts_with(&base) || base.starts_with(from);
    (!kin).then_some(base)
}

/// All that can be reached from a module.
fn reached<'a>(from: &'a Module, uses: &'a BTreeMap<Module, BTreeSet<Module>>) -> BTreeSet<&'a Module> {
    let (mut seen, mut open) = (BTreeSet::new(), vec![from]);
    while let Some(module) = open.pop() {
        open.extend(uses[module].iter().filter(|next| seen.insert(*next)));
    }
    seen
}

/// The modules of a crate that are in a dependency cycle.
pub(crate) fn in_circles(src: &Path) -> Vec<String> {
    let all = modules(src);
    let uses: BTreeMap<Module, BTreeSet<Module>> = all
        .iter()
        .map(|(from, text)| {
            let to = paths(text).into_iter().filter_map(|path| target(from, &path, &all));
            (from.clone(), to.collect())
        })
        .collect();
    let circular = uses.keys().filter(|module| reached(module, &uses).contains(module));
    circular.map(|module| module.join("::")).collect()
}

#[test]
fn paths_are_read_from_use_lines_and_from_the_text() {
    let text = "use crate::a::{B, c::{D, E}};\nfn f() { super::g::h(); mycrate::no(); }";
    assert_eq!(paths(text), ["crate::a::B", "crate::a::c::D", "crate::a::c::E", "super::g::h"]);
}
