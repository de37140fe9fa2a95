//! The fuzz target's body over its committed seeds and over everything it ever found.

#[path = "../../../../fuzz/bodies/geofile.rs"]
mod bodies;

#[test]
fn seeds_hold() {
    let folder = testkit::repository().join("fuzz/seeds/geofile");
    let mut files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{} has no seeds", folder.display());
    for file in files {
        println!("{}", file.display());
        let bytes = std::fs::read(file).unwrap();
        bodies::file(&bytes);
        for cut in 0..bytes.len() {
            bodies::file(&bytes[..cut]);
        }
    }
}
