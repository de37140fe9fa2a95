//! Logs written, cut, damaged and read.

use flate2::{Compression, write::GzEncoder};
use imc::lsf::{LogItem, LogOptions, LogReader, LogWriter, definitions_xml, folder_name};
use imc::messages::{LoggingControl, LoggingControlOp, Rpm};
use imc::{Address, Frame, Frames, Header, Packet};
use std::io::Write as _;
use std::path::Path;
use units::UtcTime;

fn packet(at: u16) -> Vec<u8> {
    let header = Header { timestamp: f64::from(at), src: Address(0x2810), ..Header::default() };
    Packet::new(header, Rpm { value: at as i16 }).encode().unwrap()
}

fn start() -> UtcTime {
    UtcTime::from_micros(1_763_711_007_000_000)
}

fn options(compress: bool) -> LogOptions {
    let config = "[General]\nVehicle = ntnu-otter-01\n".to_owned();
    LogOptions { system: Address(0x2810), entity: 61, compress, config }
}

/// Packets' bytes, and what else there was by name.
fn read(path: &Path) -> (Vec<u8>, Vec<String>) {
    let mut reader = LogReader::open(path).unwrap();
    let (mut bytes, mut rest) = (Vec::new(), Vec::new());
    while let Some(item) = reader.next_item().unwrap() {
        match item {
            LogItem::Packet { view, .. } => bytes.extend_from_slice(view.bytes()),
            LogItem::Damage(damage) => rest.push(damage.error.class().to_owned()),
            LogItem::Cut { offset, .. } => rest.push(format!("cut at {offset}")),
        }
    }
    (bytes, rest)
}

#[test]
fn a_log_explains_itself() {
    for (compress, file) in [(false, "Data.lsf"), (true, "Data.lsf.gz")] {
        let base = tempfile::tempdir().unwrap();
        let mut log = LogWriter::create(base.path(), start(), "survey 1", options(compress)).unwrap();
        assert_eq!(log.name(), "20251121/074327_survey_1");
        let folder = log.folder().to_owned();
        log.write(&packet(1)).unwrap();
        log.write_line("[2025/11/21 07:43:27] - MSG [Lutra] >> hello").unwrap();
        log.finish(UtcTime::from_micros(start().micros() + 5_000_000)).unwrap();

        let (bytes, rest) = read(&folder.join(file));
        assert!(rest.is_empty(), "{rest:?}");
        let packets: Vec<Packet> = Frames::new(&bytes)
            .map(|frame| match frame {
                Frame::Packet { view, .. } => Packet::decode(view.bytes()).unwrap(),
                Frame::Damage(damage) => panic!("{damage:?}"),
            })
            .collect();
        let control = |at: usize| packets[at].get::<LoggingControl>().unwrap();
        assert_eq!(packets.len(), 3);
        assert_eq!(control(0).op, LoggingControlOp::Started);
        assert_eq!(control(0).name, "20251121/074327_survey_1");
        assert_eq!((packets[0].header.src, packets[0].header.src_ent), (Address(0x2810), 61));
        assert_eq!(control(2).op, LoggingControlOp::Stopped);
        assert!(std::fs::read_to_string(folder.join("Output.txt")).unwrap().ends_with("hello\n"));
        assert!(std::fs::read_to_string(folder.join("Config.ini")).unwrap().contains("ntnu-otter-01"));
        assert!(folder.join("IMC.xml.gz").is_file());
    }
}

#[test]
fn two_logs_of_one_second_do_not_mix() {
    let base = tempfile::tempdir().unwrap();
    let one = LogWriter::create(base.path(), start(), "", options(true)).unwrap();
    let two = LogWriter::create(base.path(), start(), "", options(true)).unwrap();
    assert_eq!((one.name(), two.name()), ("20251121/074327", "20251121/074327_2"));
}

#[test]
fn labels_cannot_leave_the_folder() {
    assert_eq!(folder_name(start(), "../../etc/passwd\n"), "20251121/074327_.._.._etc_passwd_");
    assert_eq!(folder_name(start(), &"ø".repeat(200)).len(), "20251121/074327_".len() + 100);
}

#[test]
fn what_was_flushed_is_read_after_a_crash() {
    for compress in [false, true] {
        let base = tempfile::tempdir().unwrap();
        let mut log = LogWriter::create(base.path(), start(), "", options(compress)).unwrap();
        let file = log.folder().join(if compress { "Data.lsf.gz" } else { "Data.lsf" });
        (0..1_000).for_each(|at| log.write(&packet(at)).unwrap());
        log.flush().unwrap();
        // As after kill -9: nothing is closed and no end is written.
        let copy = base.path().join("copy");
        std::fs::copy(&file, &copy).unwrap();
        let (bytes, rest) = read(&copy);
        assert!(bytes.ends_with(&packet(999)), "{compress}");
        assert_eq!(rest.len(), usize::from(compress), "{rest:?}");
        // A file that grew before its bytes reached the disk ends in zeros.
        for zeros in [1, 5, 4_096] {
            let mut log = std::fs::read(&file).unwrap();
            log.extend(std::iter::repeat_n(0, zeros));
            std::fs::write(&copy, log).unwrap();
            let (bytes, rest) = read(&copy);
            assert!(bytes.ends_with(&packet(999)) && !rest.is_empty(), "{compress} {zeros} {rest:?}");
        }
    }
}

#[test]
fn a_plain_log_is_read_from_the_middle() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("Data.lsf");
    std::fs::write(&path, (0..100).flat_map(packet).collect::<Vec<u8>>()).unwrap();
    let mut reader = LogReader::open_at(&path, 24 * 60).unwrap();
    let Some(LogItem::Packet { offset, view }) = reader.next_item().unwrap() else { panic!("no packet") };
    assert_eq!((offset, view.bytes()), (24 * 60, &packet(60)[..]));
    std::fs::write(&path, [0x1F, 0x8B, 8, 0, 0]).unwrap();
    assert!(LogReader::open_at(&path, 0).unwrap_err().to_string().contains("unpack it first"));
}

#[test]
fn only_packets_get_into_a_log() {
    let base = tempfile::tempdir().unwrap();
    let mut log = LogWriter::create(base.path(), start(), "", options(false)).unwrap();
    for wrong in [&b"garbage"[..], &packet(1)[..20], &[packet(1), packet(2)].concat(), b""] {
        assert_eq!(log.write(wrong).unwrap_err().kind(), std::io::ErrorKind::InvalidInput);
    }
    log.flush().unwrap();
    assert_eq!(read(&log.folder().join("Data.lsf")).1, Vec::<String>::new());
}

#[test]
fn a_log_cut_anywhere_gives_all_that_is_whole() {
    let whole: Vec<u8> = (0..50).flat_map(packet).collect();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("Data.lsf");
    for cut in (0..whole.len()).step_by(7) {
        std::fs::write(&path, &whole[..cut]).unwrap();
        let (bytes, rest) = read(&path);
        assert_eq!(bytes.len(), cut / 24 * 24);
        assert_eq!(rest.is_empty(), cut % 24 == 0);
    }
}

#[test]
fn members_of_gzip_follow_each_other_and_a_cut_one_is_reported() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("Data.lsf.gz");
    let member = |from: u16| {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
        (from..from + 100).for_each(|at| encoder.write_all(&packet(at)).unwrap());
        encoder.finish().unwrap()
    };
    let (first, second) = (member(0), member(100));
    std::fs::write(&path, [&first[..], &second].concat()).unwrap();
    assert_eq!(read(&path), ((0..200).flat_map(packet).collect(), vec![]));

    std::fs::write(&path, [&first[..], &second[..second.len() / 2]].concat()).unwrap();
    let (bytes, rest) = read(&path);
    assert!(bytes.len() >= 2_400 && rest[0].starts_with("cut at "), "{rest:?}");

    std::fs::write(&path, [&first[..], b"\x1f\x8b rubbish that is not gzip"].concat()).unwrap();
    let (bytes, rest) = read(&path);
    assert_eq!((bytes.len(), rest.len()), (2_400, 1));
}

#[test]
fn a_missing_log_is_an_error_and_an_empty_one_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("Data.lsf");
    let named = |error: std::io::Error| error.to_string().starts_with(&format!("{}: ", path.display()));
    let error = LogReader::open(&path).unwrap_err();
    assert_eq!(error.kind(), std::io::ErrorKind::NotFound);
    assert!(named(error));
    assert!(named(LogReader::open_at(&path, 5).unwrap_err()));
    std::fs::write(&path, b"").unwrap();
    assert_eq!(read(&path), (vec![], vec![]));
    let error = LogReader::open(folder.path()).unwrap_err();
    assert!(error.to_string().starts_with(&format!("{}: ", folder.path().display())), "{error}");
}

/// Message id to its layout: abbreviation, then each field's name and type.
fn layouts(xml: &str) -> std::collections::BTreeMap<u16, Vec<String>> {
    let attribute = |line: &str, name: &str| {
        let start = line.find(&format!(" {name}=\""))? + name.len() + 3;
        Some(line[start..start + line[start..].find('"')?].to_owned())
    };
    let (mut all, mut current) = (std::collections::BTreeMap::new(), None);
    for line in xml.lines().map(str::trim) {
        if line.starts_with("<message ") {
            current = attribute(line, "id").map(|id| id.parse::<u16>().unwrap());
            all.insert(current.unwrap(), vec![attribute(line, "abbrev").unwrap()]);
        } else if let (true, Some(id)) = (line.starts_with("<field "), current) {
            let field =
                format!("{} {}", attribute(line, "abbrev").unwrap(), attribute(line, "type").unwrap());
            all.get_mut(&id).unwrap().push(field);
        }
    }
    all
}

#[test]
fn the_definitions_beside_a_log_agree_with_dunes() {
    let ours = layouts(&definitions_xml());
    assert_eq!(ours.len(), 351);
    assert_eq!(ours[&2008].len(), 8);
    let Some(path) = testkit::shared("data/imc/dune_log_a/IMC.xml.gz") else { return };
    let mut text = String::new();
    let file = std::fs::File::open(path).unwrap();
    std::io::Read::read_to_string(&mut flate2::read::MultiGzDecoder::new(file), &mut text).unwrap();
    let theirs = layouts(&text);
    let differing: Vec<u16> =
        theirs.iter().filter(|(id, layout)| ours.get(id) != Some(layout)).map(|(id, _)| *id).collect();
    // Their AckMsg is not in the catalogue; packets of it are kept as they are.
    assert_eq!(differing, [2040]);
}
