//! Frames to bytes.

use super::{
    Batch, ChartDigest, ChartOffer, ChartPart, ChartReport, Frame, MAX_TEXT_BYTES, NO_WAY, Stamp, Verdict,
};
use crate::ways::{MOST_WAY_NAME_BYTES, MOST_WAYS, WaysReport};
use crate::wire::put_text;
use bytes::Bytes;

/// Appends a frame to a message. Longer texts than [`MAX_TEXT_BYTES`] are cut.
pub fn encode(frame: &Frame, out: &mut Vec<u8>) {
    let start = out.len();
    out.push(number(frame));
    out.extend_from_slice(&[0; 4]);
    body(frame, out);
    // A message has at most 1 MiB.
    let length = (out.len() - start - 5) as u32;
    out[start + 1..start + 5].copy_from_slice(&length.to_le_bytes());
}

/// A message of one frame.
pub fn message(frame: &Frame) -> Bytes {
    let mut out = Vec::new();
    encode(frame, &mut out);
    out.into()
}

fn number(frame: &Frame) -> u8 {
    match frame {
        Frame::Hello(_) => 1,
        Frame::Welcome(_) => 2,
        Frame::Records(_) => 3,
        Frame::Live(_) => 4,
        Frame::Gap(_) => 5,
        Frame::Ack(_) => 6,
        Frame::Command(command) if command.order > 0 => 17,
        Frame::Command(_) => 7,
        Frame::Receipt(_) => 8,
        Frame::Heartbeat(_) => 9,
        Frame::Bye(_) => 10,
        Frame::Lease(_) => 11,
        Frame::Chart(_) => 12,
        Frame::ChartRequest(_) => 13,
        Frame::ChartPart(_) => 14,
        Frame::ChartReport(_) => 15,
        Frame::Ways(_) => 16,
    }
}

fn body(frame: &Frame, out: &mut Vec<u8>) {
    match frame {
        Frame::Hello(hello) => {
            out.extend_from_slice(b"LLNK");
            out.extend_from_slice(&hello.version.to_le_bytes());
            out.extend_from_slice(&hello.oldest_version.to_le_bytes());
            out.extend_from_slice(&hello.capabilities.0.to_le_bytes());
            out.extend_from_slice(&hello.address.to_le_bytes());
            put_u64s(out, &[hello.incarnation, hello.attempt, hello.stream, hello.first, hello.next]);
            put_stamp(out, &hello.stamp);
            put_text(out, &hello.name, MAX_TEXT_BYTES);
            put_text(out, &hello.software, MAX_TEXT_BYTES);
            if let Some(way) = &hello.way {
                out.extend_from_slice(&[way.index, u8::from(way.metered)]);
                put_text(out, &way.name, MOST_WAY_NAME_BYTES);
            }
        }
        Frame::Welcome(welcome) => {
            out.extend_from_slice(&welcome.version.to_le_bytes());
            out.extend_from_slice(&welcome.capabilities.0.to_le_bytes());
            put_u64s(out, &[welcome.resume]);
            out.extend_from_slice(&welcome.window_bytes.to_le_bytes());
            put_stamp(out, &welcome.stamp);
            out.extend(welcome.run.iter().flat_map(|run| run.to_le_bytes()));
        }
        Frame::Records(batch) | Frame::Live(batch) => put_batch(out, batch),
        Frame::Gap(gap) => {
            put_u64s(out, &[gap.from, gap.to]);
            out.extend_from_slice(&gap.since.micros().to_le_bytes());
            out.extend_from_slice(&gap.until.micros().to_le_bytes());
            out.push(gap.reason.code());
        }
        Frame::Ack(ack) => put_u64s(out, &[ack.received, ack.durable, ack.bytes]),
        Frame::Command(command) => {
            put_u64s(out, &[command.id, command.sent.micros()]);
            out.extend_from_slice(&command.ttl_ms.to_le_bytes());
            put_u64s(out, &[command.lease]);
            if command.order > 0 {
                put_u64s(out, &[command.order]);
            }
            out.extend_from_slice(&command.packet);
        }
        Frame::Receipt(receipt) => {
            put_u64s(out, &[receipt.id]);
            out.push(match receipt.verdict {
                Verdict::Received => 1,
                Verdict::Expired => 2,
                Verdict::Refused => 3,
            });
            put_text(out, &receipt.text, MAX_TEXT_BYTES);
            if receipt.order > 0 {
                put_u64s(out, &[receipt.order]);
            }
        }
        Frame::Heartbeat(beat) => {
            put_stamp(out, &beat.stamp);
            put_u64s(out, &[beat.bytes, beat.next, beat.durable, beat.waiting_us, beat.kept_us]);
        }
        Frame::Lease(lease) => {
            put_u64s(out, &[lease.epoch]);
            out.extend_from_slice(&lease.ttl_ms.to_le_bytes());
            put_text(out, &lease.holder, MAX_TEXT_BYTES);
            if lease.number > 0 {
                put_u64s(out, &[lease.number]);
            }
        }
        Frame::Bye(bye) => {
            out.push(bye.code.code());
            put_text(out, &bye.text, MAX_TEXT_BYTES);
        }
        Frame::Chart(offer) => put_offer(out, offer),
        Frame::ChartRequest(ask) => {
            put_place(out, &ask.digest, ask.offset);
            out.extend_from_slice(&ask.length.to_le_bytes());
        }
        Frame::ChartPart(part) => put_part(out, part),
        Frame::ChartReport(report) => put_report(out, report),
        Frame::Ways(report) => put_ways(out, report),
    }
}

fn put_ways(out: &mut Vec<u8>, report: &WaysReport) {
    put_u64s(out, &[report.choice]);
    let ways = &report.ways[..report.ways.len().min(MOST_WAYS)];
    let place = |place: Option<u8>| place.unwrap_or(NO_WAY);
    let (live_why, records_why) = (report.live_why.code(), report.records_why.code());
    out.extend_from_slice(&[
        place(report.live),
        live_why,
        place(report.records),
        records_why,
        ways.len() as u8,
    ]);
    for way in ways {
        out.extend_from_slice(&[u8::from(way.metered), way.state as u8, way.thinning as u8]);
        out.extend_from_slice(&way.late_per_mille.to_le_bytes());
        for number in [way.round_trip_us, way.rate_bytes_per_s, way.failures] {
            out.extend_from_slice(&number.to_le_bytes());
        }
        put_u64s(out, &[way.today_bytes, way.daily_bytes]);
        put_text(out, &way.name, MOST_WAY_NAME_BYTES);
    }
}

fn put_offer(out: &mut Vec<u8>, offer: &ChartOffer) {
    put_place(out, &offer.digest, offer.bytes);
    put_text(out, &offer.edition, MAX_TEXT_BYTES);
}

fn put_part(out: &mut Vec<u8>, part: &ChartPart) {
    put_place(out, &part.digest, part.offset);
    out.extend_from_slice(&part.raw_bytes.to_le_bytes());
    out.push(u8::from(part.compressed));
    out.extend_from_slice(&part.data);
}

fn put_report(out: &mut Vec<u8>, report: &ChartReport) {
    out.extend_from_slice(&report.held);
    put_text(out, &report.edition, MAX_TEXT_BYTES);
    out.push(report.stage.code());
    put_u64s(out, &[report.have, report.of]);
    put_text(out, &report.text, MAX_TEXT_BYTES);
}

/// A chart, and a number of bytes of it.
fn put_place(out: &mut Vec<u8>, digest: &ChartDigest, bytes: u64) {
    out.extend_from_slice(digest);
    put_u64s(out, &[bytes]);
}

fn put_u64s(out: &mut Vec<u8>, numbers: &[u64]) {
    for number in numbers {
        out.extend_from_slice(&number.to_le_bytes());
    }
}

fn put_stamp(out: &mut Vec<u8>, stamp: &Stamp) {
    put_u64s(out, &[stamp.mono.micros()]);
    out.extend_from_slice(&stamp.utc.micros().to_le_bytes());
    put_u64s(out, &[stamp.echo.micros(), stamp.echo_received.micros()]);
}

fn put_batch(out: &mut Vec<u8>, batch: &Batch) {
    put_u64s(out, &[batch.first]);
    out.extend_from_slice(&batch.base.micros().to_le_bytes());
    out.extend_from_slice(&batch.count.to_le_bytes());
    out.extend_from_slice(&batch.raw_bytes.to_le_bytes());
    out.push(u8::from(batch.compressed));
    out.extend_from_slice(&batch.data);
}
