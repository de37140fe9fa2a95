//! How fast a log is read: `cargo run --release -p imc --example read_speed -- Data.lsf[.gz]`.
//!
//! Reads the file from the page cache, five times each way, and prints the best: once by header with the
//! checksum of every packet checked, once decoding every message.

#![expect(clippy::disallowed_methods, reason = "this measures time")]

use imc::lsf::{LogItem, LogReader};
use imc::{Packet, PacketView, ShortPayload};
use std::path::Path;
use std::time::Instant;

fn best(path: &Path, what: &str, look: impl Fn(&PacketView<'_>) -> bool) -> std::io::Result<()> {
    let (mut best_s, mut packets, mut bytes) = (f64::INFINITY, 0, 0);
    for _ in 0..5 {
        let start = Instant::now();
        let mut reader = LogReader::open(path)?;
        packets = 0;
        while let Some(item) = reader.next_item()? {
            if let LogItem::Packet { view, .. } = item {
                packets += u32::from(look(&view));
            }
        }
        bytes = reader.unpacked_bytes();
        best_s = best_s.min(start.elapsed().as_secs_f64());
    }
    println!(
        "Lutra, {what}: {packets} packets, {:.0} packets/s, {:.1} MB/s",
        f64::from(packets) / best_s,
        bytes as f64 / best_s / 1e6
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("usage: read_speed Data.lsf[.gz]")?;
    let path = Path::new(&path);
    best(path, "by header", |view| view.id() != u16::MAX)?;
    best(path, "every message decoded", |view| Packet::from_view(view, ShortPayload::default()).is_ok())?;
    Ok(())
}
