//! The fuzz targets' bodies over their committed seeds and over everything they ever found.

#[path = "../../../../fuzz/bodies/imc.rs"]
mod bodies;

fn replay(target: &str, body: fn(&[u8])) {
    let folder = testkit::repository().join("fuzz/seeds").join(target);
    let mut files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{} has no seeds", folder.display());
    for file in files {
        println!("{}", file.display());
        body(&std::fs::read(file).unwrap());
    }
}

#[test]
fn packet_seeds_hold() {
    replay("imc_packet", bodies::packet);
}

#[test]
fn deframer_seeds_hold() {
    replay("imc_deframer", bodies::deframer);
}

#[test]
fn json_seeds_hold() {
    replay("imc_json", bodies::json);
}

#[test]
fn lsf_seeds_hold() {
    replay("imc_lsf", bodies::lsf);
}
