//! Recordings of a real DUNE vehicle: whole in the archive, whole in the history, once.

use crate::support::{OTTER, START_US, accept, archived, dump, utc};
use imc::lsf::{LogItem, LogReader};
use imc::{Address, PacketView};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use store::{Beginning, LogImport, Page, Reader, Source, Store, TimeRange, Transport};

/// Later than everything in the recordings.
const NOW_US: i64 = START_US + 86_400_000_000;

fn packets(path: &Path) -> Vec<Vec<u8>> {
    let mut log = LogReader::open(path).unwrap();
    let mut found = Vec::new();
    while let Some(item) = log.next_item().unwrap() {
        match item {
            LogItem::Packet { view, .. } => found.push(view.bytes().to_vec()),
            other => panic!("{other:?}"),
        }
    }
    found
}

/// The messages that the history keeps once.
type Key = (u16, Address, u8, u64, Vec<u8>);

fn key(packet: &[u8]) -> Key {
    let view = PacketView::new(packet).unwrap();
    (view.id(), view.src(), view.src_ent(), view.timestamp().to_bits(), view.payload().to_vec())
}

fn of_system(packets: &[Vec<u8>], system: Address) -> Vec<u8> {
    packets
        .iter()
        .filter(|packet| PacketView::new(packet).unwrap().src() == system)
        .flatten()
        .copied()
        .collect()
}

/// Samples per message and system.
fn counts(folder: &Path) -> BTreeMap<(u16, u16), u64> {
    let mut counts = BTreeMap::new();
    for series in Reader::open(folder).unwrap().series(None).unwrap() {
        *counts.entry((series.group.id, series.group.src)).or_default() += series.extent.count;
    }
    counts
}

fn expected_counts(packets: &[Vec<u8>]) -> BTreeMap<(u16, u16), u64> {
    let distinct: BTreeSet<Key> = packets.iter().map(|packet| key(packet)).collect();
    let mut counts = BTreeMap::new();
    for (id, src, ..) in distinct {
        *counts.entry((id, src.0)).or_default() += 1;
    }
    counts
}

fn recordings() -> Option<[PathBuf; 3]> {
    let folder = testkit::shared("data/imc")?;
    Some(
        ["dune_log_a/Data.lsf.gz", "dune_capture_a.imc.gz", "dune_capture_a_udp.imc.gz"]
            .map(|name| folder.join(name)),
    )
}

#[test]
fn an_imported_recording_is_whole_and_importing_it_again_adds_nothing() {
    let Some(recordings) = recordings() else { return };
    for recording in recordings {
        let folder = tempfile::tempdir().unwrap();
        let source = packets(&recording);
        let mut store = Store::open(folder.path()).unwrap();
        let paths = [recording.clone()];
        let imported = store.import(&paths, utc(NOW_US), &mut |_| true).unwrap();
        assert_eq!((imported.packets, imported.added), (source.len() as u64, source.len() as u64));
        assert_eq!(imported.problems, Vec::<String>::new());

        let systems: BTreeSet<Address> =
            source.iter().map(|one| PacketView::new(one).unwrap().src()).collect();
        for system in systems {
            assert!(archived(folder.path(), system) == of_system(&source, system), "{system} differs");
        }
        assert_eq!(counts(folder.path()), expected_counts(&source));

        let before = dump(folder.path());
        // The same time by the clock: an import must not be fooled by it.
        let again = store.import(&paths, utc(NOW_US), &mut |_| true).unwrap();
        assert_eq!((again.packets, again.added), (source.len() as u64, 0));
        assert!(dump(folder.path()) == before, "importing again changed the history");
        assert!(archived(folder.path(), OTTER) == of_system(&source, OTTER));
    }
}

#[test]
fn port_and_starboard_in_one_millisecond_are_both_kept() {
    let Some([_, capture, _]) = recordings() else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    store.import(&[capture], utc(NOW_US), &mut |_| true).unwrap();
    let thrust = counts(folder.path())[&(301, OTTER.0)];
    assert_eq!(thrust, 4_030, "the recording's notes give 4030, in 2022 milliseconds of an entity");
    assert_eq!(counts(folder.path())[&(350, OTTER.0)], 2_600);
}

#[test]
fn what_comes_through_several_transports_is_in_the_history_once() {
    let Some([_, capture, _]) = recordings() else { return };
    let source = packets(&capture);
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    for (at, packet) in source.iter().enumerate() {
        accept(&mut store, packet, NOW_US + at as i64, Transport::Tcp);
        accept(&mut store, packet, NOW_US + at as i64 + 1, Transport::Proxy);
        if at % 10_000 == 0 {
            store.commit().unwrap();
        }
    }
    store.commit().unwrap();
    assert!(archived(folder.path(), OTTER) == of_system(&source, OTTER), "the relayed copies were archived");
    assert_eq!(counts(folder.path()), expected_counts(&source));
}

#[test]
fn the_track_is_the_recordings_true_positions() {
    let Some([_, capture, _]) = recordings() else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut expected: BTreeMap<i64, (f64, f64)> = BTreeMap::new();
    for packet in packets(&capture) {
        let view = PacketView::new(&packet).unwrap();
        if let Some(state) = imc::decode::<imc::messages::EstimatedState>(&view).unwrap() {
            let place = imc::position::place(&state).unwrap();
            expected.insert(view.header().time().unwrap().micros(), (place.lat_deg(), place.lon_deg()));
        }
    }
    let mut store = Store::open(folder.path()).unwrap();
    store.import(&[capture], utc(NOW_US), &mut |_| true).unwrap();
    let mut reader = Reader::open(folder.path()).unwrap();
    let track = reader.track(OTTER, TimeRange::ALL, 50_000, 0.0).unwrap();
    assert!(track.points.len() > 500, "{} points", track.points.len());
    for point in &track.points {
        let (lat, lon) = expected[&point.time.micros()];
        assert!((point.place.lat_deg() - lat).abs() < 1e-12 && (point.place.lon_deg() - lon).abs() < 1e-12);
    }
    // A rough one is made of the same positions.
    let rough = reader.track(OTTER, TimeRange::ALL, 20, 1.0).unwrap();
    assert!(rough.points.len() <= 21 && rough.points.len() > 2);
    assert!(rough.points.iter().all(|point| expected.contains_key(&point.time.micros())));
}

#[test]
fn entities_have_their_labels_and_systems_their_names() {
    let Some([_, capture, _]) = recordings() else { return };
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    store.import(&[capture], utc(NOW_US), &mut |_| true).unwrap();
    let mut reader = Reader::open(folder.path()).unwrap();
    let systems = reader.systems().unwrap();
    let otter = systems.iter().find(|system| system.address == OTTER).unwrap();
    assert_eq!(otter.name, "ntnu-otter-01");
    let labels = reader.entities(OTTER).unwrap();
    assert!(labels.len() > 20, "{labels:?}");
    let series = reader.series(Some(OTTER)).unwrap();
    let labelled = series.iter().filter(|series| series.label.is_some()).count();
    assert!(labelled * 10 > series.len() * 9, "{labelled} of {}", series.len());
    let source = Source { system: OTTER, entity: series[0].group.src_ent, message: "CpuUsage".to_owned() };
    assert!(
        reader
            .rows(&source, &["no_such"], TimeRange::ALL, Page::first(1))
            .unwrap_err()
            .to_string()
            .contains("value")
    );
}

#[test]
fn a_log_comes_in_slices_between_which_vessels_are_heard() {
    let Some([recording, ..]) = recordings() else { return };
    let folder = tempfile::tempdir().unwrap();
    let source = packets(&recording);
    let mut store = Store::open(folder.path()).unwrap();
    let mut log = LogImport::begin(&mut store, &recording, utc(NOW_US)).unwrap();
    let (mut seq, mut told) = (0, None);
    loop {
        // Heard while the import is on its way: one that the log has not brought yet, and numbered records.
        accept(&mut store, &source[source.len() - 1 - seq as usize], NOW_US, Transport::Tcp);
        crate::support::accept_link(
            &mut store,
            &crate::support::temperature(START_US + seq as i64, 1.0),
            NOW_US,
            seq,
        );
        let before = log.imported().packets;
        let more = log.read_some(&mut store, 1_000, u64::MAX).unwrap();
        assert!(log.imported().packets <= before + 1_000);
        // What the slice made durable is reported by the next commit.
        let committed = store.commit().unwrap();
        told = committed.durable.iter().map(|link| link.seq).max().or(told);
        assert_eq!((told, store.durable(7)), (Some(seq), Some(seq)));
        seq += 1;
        if !more {
            break;
        }
    }
    assert!(seq > 3, "{seq} slices");
    assert_eq!(log.imported().packets, source.len() as u64);
    assert_eq!(log.imported().problems, Vec::<String>::new());
    store.settle().unwrap();
    let mut expected = expected_counts(&source);
    *expected.entry((263, crate::support::OTTER.0)).or_default() += seq;
    assert_eq!(counts(folder.path()), expected);
    let before = dump(folder.path());
    let again = store.import(std::slice::from_ref(&recording), utc(NOW_US + 1), &mut |_| true).unwrap();
    assert_eq!((again.added, again.packets), (0, source.len() as u64));
    assert!(dump(folder.path()) == before);
}

/// Plain, or packed by zstd or gzip: cut before its first packet is whole.
#[test]
fn a_log_that_is_cut_in_its_first_packet_has_no_whole_packet() {
    let folder = tempfile::tempdir().unwrap();
    let plain: Vec<u8> =
        (0..400).flat_map(|at| crate::support::temperature(START_US + at, at as f32)).collect();
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut gzip, &plain).unwrap();
    let packed = [zstd::encode_all(&plain[..], 1).unwrap(), gzip.finish().unwrap(), plain];
    let mut files = Vec::new();
    for (at, bytes) in packed.iter().enumerate() {
        let file = folder.path().join(format!("{at}.lsf"));
        std::fs::write(&file, &bytes[..21]).unwrap();
        assert_eq!(store::beginning(&file).unwrap(), Beginning::Cut { bytes: 21 }, "{at}");
        files.push(file);
    }
    let mut store = Store::open(&folder.path().join("shore")).unwrap();
    let imported = store.import(&files, utc(NOW_US), &mut |_| true).unwrap();
    assert_eq!((imported.files, imported.packets), (3, 0));
    let problems = imported.problems.join("\n");
    assert!(!problems.contains("is empty") && !problems.contains("is not an IMC log"), "{problems}");
    assert!(problems.contains("holds no whole packet: it ends at byte 21"), "{problems}");
}

#[test]
fn a_log_is_told_from_other_files() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    let mut first = vec![0; 5_000];
    first.extend(crate::support::temperature(START_US, 1.0));
    for (bytes, is) in [
        (crate::support::temperature(START_US, 1.0), Beginning::Log),
        (first, Beginning::Log),
        (Vec::new(), Beginning::Other),
        (b"PK\x03\x04 a zip".to_vec(), Beginning::Other),
        (vec![0; 3 << 20], Beginning::Other),
        (crate::support::temperature(START_US, 1.0)[..20].to_vec(), Beginning::Cut { bytes: 20 }),
    ] {
        std::fs::write(&file, bytes).unwrap();
        assert_eq!(store::beginning(&file).unwrap(), is);
    }
    let Some([recording, ..]) = recordings() else { return };
    let packed = std::fs::read(recording).unwrap();
    for length in [packed.len(), packed.len() / 2] {
        std::fs::write(&file, &packed[..length]).unwrap();
        let beginning = store::beginning(&file).unwrap();
        assert_eq!(beginning, Beginning::Log, "the first {length} bytes of a packed log");
    }
}
