//! A real DUNE vehicle's traffic through each transport: all of it is in the archive, byte for byte, and in the
//! history, message for message.

use crate::support::{Client, OTTER, PATIENCE, Shore, archived, odd_packets, packet, packets_of};
use bytes::Bytes;
use futures_util::SinkExt as _;
use imc::messages::{self, EstimatedState, SetThrusterActuation};
use imc::{Address, PacketView};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;
use store::{Page, Reader, Source, TimeRange};
use tokio::io::AsyncWriteExt as _;
use tokio::net::TcpListener;
use tokio_tungstenite::tungstenite::Message as Frame;

/// Sender of the end marker; no system in the recordings has this address.
const MARKER: Address = Address(0x4002);
/// More than fits into a packet, a segment or a buffer of the transport, and never the same twice in a row.
const ODD_CHUNKS: [usize; 7] = [1, 7, 1_449, 13, 65_537, 3, 20_011];

/// What makes two packets the same sample: message, source, entity, time and payload.
type Key = (u16, u16, u8, u64, Vec<u8>);

fn key(packet: &[u8]) -> Key {
    let view = PacketView::new(packet).unwrap();
    (view.id(), view.src().0, view.src_ent(), view.timestamp().to_bits(), view.payload().to_vec())
}

fn recording() -> Option<(PathBuf, Vec<Bytes>)> {
    let path = testkit::shared("data/imc/dune_capture_a.imc.gz")?;
    let packets = packets_of(&path);
    assert_eq!(packets.len(), 74_372, "the recording's notes give so many");
    Some((path, packets))
}

/// Source of a packet.
fn source(packet: &[u8]) -> Address {
    PacketView::new(packet).unwrap().src()
}

/// Checks that archive and history hold exactly what was sent: each source's bytes in order (`copies` tells whether
/// repeated samples count), each message, both propellers, every true position.
fn assert_whole(data: &Path, said: &[Bytes], copies: bool) {
    let mut expected: BTreeMap<Address, Vec<u8>> = BTreeMap::new();
    let mut samples = BTreeSet::new();
    for packet in said {
        let new = samples.insert(key(packet));
        if new || copies || PacketView::new(packet).unwrap().timestamp() == 0.0 {
            expected.entry(source(packet)).or_default().extend_from_slice(packet);
        }
    }
    for (system, bytes) in &expected {
        assert!(archived(data, *system) == *bytes, "the archive of {system} differs");
    }

    let mut rows: BTreeMap<(u16, u16), u64> = BTreeMap::new();
    for (id, system, ..) in &samples {
        *rows.entry((*id, *system)).or_default() += 1;
    }
    let mut reader = Reader::open(data).unwrap();
    let mut held: BTreeMap<(u16, u16), u64> = BTreeMap::new();
    for series in reader.series(None).unwrap().iter().filter(|series| series.group.src != MARKER.0) {
        *held.entry((series.group.id, series.group.src)).or_default() += series.extent.count;
    }
    assert_eq!(held, rows, "(message, system): samples");

    let (mut propellers, mut entities, mut places) = (BTreeMap::new(), BTreeSet::new(), BTreeMap::new());
    for packet in said {
        let view = PacketView::new(packet).unwrap();
        if let Some(thrust) = imc::decode::<SetThrusterActuation>(&view).unwrap() {
            entities.insert(view.src_ent());
            propellers.entry(thrust.id).or_insert_with(BTreeSet::new).insert(key(packet));
        } else if let Some(state) = imc::decode::<EstimatedState>(&view).unwrap() {
            let place = imc::position::place(&state).unwrap();
            places.insert(view.header().time().unwrap().micros(), (place.lat_deg(), place.lon_deg()));
        }
    }
    assert_eq!(propellers.len(), 2, "port and starboard");
    let mut read: BTreeMap<u8, usize> = BTreeMap::new();
    for entity in entities {
        let source = Source { system: OTTER, entity, message: "SetThrusterActuation".to_owned() };
        for row in reader.rows(&source, &["id"], TimeRange::ALL, Page::first(10_000)).unwrap().items {
            *read.entry(row.cells[0].as_f64().unwrap() as u8).or_default() += 1;
        }
    }
    assert_eq!(read, propellers.iter().map(|(id, keys)| (*id, keys.len())).collect());

    let track = reader.track(OTTER, TimeRange::ALL, 50_000, 0.0).unwrap();
    assert!(track.points.len() > 500, "{} points", track.points.len());
    for point in &track.points {
        let (lat, lon) = places[&point.time.micros()];
        // Rounding error of a double: 1e-12 degrees are 0.1 µm.
        assert!((point.place.lat_deg() - lat).abs() < 1e-12 && (point.place.lon_deg() - lon).abs() < 1e-12);
    }
}

/// The command-line program on a data folder.
fn run(data: &Path, arguments: &[&str]) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lutra-server"));
    let output = command.args(arguments).arg("--data").arg(data).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Reads until the end marker arrives.
async fn until_through(mut console: Client) {
    let end = async { while source(&console.hear().await) != MARKER {} };
    tokio::time::timeout(10 * PATIENCE, end).await.unwrap();
}

/// Sends everything as an IMCProxy client, and the marker last.
async fn say_all(shore: &Shore, packets: &[Bytes]) {
    let mut vessel = Client::connect(shore.proxy()).await;
    let console = Client::connect(shore.proxy()).await;
    let heard = tokio::spawn(until_through(console));
    for packet in packets {
        vessel.0.feed(Frame::Binary(packet.clone())).await.unwrap();
    }
    vessel.say(&packet(MARKER, Address::NULL, 1.0, messages::Abort)).await;
    heard.await.unwrap();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn through_the_imcproxy_transport_it_is_whole_and_saying_it_again_adds_nothing() {
    let Some((path, packets)) = recording() else { return };
    let shore = Shore::start(|_| {}).await;
    let mut said = packets;
    said.extend(odd_packets(1.6e9));
    say_all(&shore, &said).await;
    shore.serving.stop().await;
    assert_whole(shore.data.path(), &said, false);
    // The vehicle's own log of what came by the transport adds nothing.
    let told = run(shore.data.path(), &["import", path.to_str().unwrap()]);
    assert_eq!(told, "1 log, 74372 packets, 0 new\n");
    assert_whole(shore.data.path(), &said, false);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn through_the_tcp_transport_in_odd_chunks_it_is_whole() {
    let Some((_, packets)) = recording() else { return };
    let node = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let at = node.local_addr().unwrap().to_string();
    let shore = Shore::start(|config| config.transports.tcp.connect = vec![at]).await;
    let console = Client::connect(shore.proxy()).await;
    let heard = tokio::spawn(until_through(console));
    let mut said = packets;
    said.extend(odd_packets(1.6e9));
    let mut stream = said.concat();
    stream.extend_from_slice(&packet(MARKER, Address::NULL, 1.0, messages::Abort));
    let (mut socket, _) = tokio::time::timeout(PATIENCE, node.accept()).await.unwrap().unwrap();
    let mut rest = &stream[..];
    for size in ODD_CHUNKS.iter().cycle() {
        let (chunk, after) = rest.split_at(rest.len().min(*size));
        tokio::time::timeout(PATIENCE, socket.write_all(chunk)).await.unwrap().unwrap();
        rest = after;
        if rest.is_empty() {
            break;
        }
    }
    heard.await.unwrap();
    shore.serving.stop().await;
    assert_whole(shore.data.path(), &said, false);
}

#[test]
fn by_import_it_is_whole_and_importing_it_again_adds_nothing() {
    let Some((path, mut said)) = recording() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = path.to_str().unwrap();
    assert_eq!(run(folder.path(), &["import", "--new", path]), "1 log, 74372 packets, 74372 new\n");
    assert_whole(folder.path(), &said, true);
    let before = archived(folder.path(), OTTER);
    assert_eq!(run(folder.path(), &["import", path]), "1 log, 74372 packets, 0 new\n");
    assert!(archived(folder.path(), OTTER) == before);
    assert_whole(folder.path(), &said, true);

    // Unknown packets are stored unchanged, too.
    let odd = odd_packets(1.6e9);
    let log = folder.path().join("odd.lsf");
    std::fs::write(&log, odd.concat()).unwrap();
    assert_eq!(run(folder.path(), &["import", log.to_str().unwrap()]), "1 log, 3 packets, 3 new\n");
    said.extend(odd);
    assert_whole(folder.path(), &said, true);
    let csv = run(folder.path(), &["export", "--message", "SetThrusterActuation", "--vessel", "0x2810"]);
    assert_eq!(csv.lines().count(), 4_031, "4030 rows and what they mean");
    assert!(csv.lines().next().unwrap().contains("value"), "{:?}", csv.lines().next());
}
