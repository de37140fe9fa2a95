//! Repairs a day after a crash: both files end with the last whole packet again.
//!
//! A crash leaves packets without records, records without packets, half a packet or half a record, or zeros
//! at the end of a file. What is whole is kept, with a record of transport `recovered` where there was none.
//! Bytes at the end that are not a packet are cut off: they were never acknowledged. Damage further inside stays.

use super::arrival::{ARRIVAL_BYTES, Arrival, Record};
use super::day::Lengths;
use super::layout::{ARRIVALS, DATA, DayKey, PACKED_ARRIVALS, PACKING};
use super::packed::Packed;
use crate::error::{Named as _, Result};
use imc::lsf::{LogItem, LogReader};
use imc::{HEADER_BYTES, MAX_PACKET_BYTES, PacketView};
use link::Transport;
use std::fs::{self, File, OpenOptions};
use std::io;
use std::os::unix::fs::FileExt as _;
use std::path::Path;
use units::UtcTime;

/// The repairs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Mended {
    pub(crate) lengths: Lengths,
    /// Bytes of half packets cut off.
    pub(crate) cut_bytes: u64,
    /// Bytes of records cut off.
    pub(crate) cut_records: u64,
    /// Packets that got a record.
    pub(crate) recovered: u64,
}

/// Mends a day's files where they need it.
pub(crate) fn mend(archive: &Path, key: DayKey) -> Result<Mended> {
    let folder = key.folder(archive);
    let (data_path, arrivals_path) = (folder.join(DATA), folder.join(ARRIVALS));
    let open = |path: &Path| {
        OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path).named(path)
    };
    unpack_arrivals(archive, &folder)?;
    let (data, arrivals) = (open(&data_path)?, open(&arrivals_path)?);
    let data_bytes = data.metadata().named(&data_path)?.len();
    let arrival_bytes = arrivals.metadata().named(&arrivals_path)?.len();

    let last = last_whole(&data, data_bytes, &arrivals, arrival_bytes).named(&arrivals_path)?;
    let mut mended = Mended {
        lengths: Lengths { data: last.data_end, arrivals: last.arrivals_end },
        cut_records: arrival_bytes - last.arrivals_end,
        ..Mended::default()
    };
    let mut records = Vec::new();
    if last.data_end < data_bytes {
        let received = last.received.or_else(|| key.start()).unwrap_or_default();
        let mut log = LogReader::open_at(&data_path, last.data_end).named(&data_path)?;
        while let Some(item) = log.next_item().named(&data_path)? {
            if let LogItem::Packet { offset, view } = item {
                Record::Packet(Arrival {
                    offset,
                    received,
                    transport: Transport::Recovered,
                    link: None,
                    first: false,
                })
                .write(&mut records);
                mended.recovered += 1;
                mended.lengths.data = offset + view.bytes().len() as u64;
            }
        }
        mended.cut_bytes = data_bytes - mended.lengths.data;
    }
    if mended.cut_bytes > 0 {
        data.set_len(mended.lengths.data).named(&data_path)?;
    }
    if mended.cut_records > 0 {
        arrivals.set_len(last.arrivals_end).named(&arrivals_path)?;
    }
    if !records.is_empty() {
        arrivals.write_all_at(&records, last.arrivals_end).named(&arrivals_path)?;
        mended.lengths.arrivals += records.len() as u64;
    }
    if mended.cut_bytes + mended.cut_records + mended.recovered > 0 {
        data.sync_data().named(&data_path)?;
        arrivals.sync_data().named(&arrivals_path)?;
    }
    Ok(mended)
}

/// Makes plain records of compressed ones beside plain packets. A backup has both where the day was compressed while it
/// was copied. Damaged ones are left for the packets to be kept without.
fn unpack_arrivals(archive: &Path, folder: &Path) -> Result<()> {
    let (plain, packed) = (folder.join(ARRIVALS), folder.join(PACKED_ARRIVALS));
    if plain.exists() || !packed.exists() {
        return Ok(());
    }
    let part = archive.join(PACKING).join(ARRIVALS);
    let unpack = || -> io::Result<()> {
        let mut from = Packed::read(&packed)?;
        fs::create_dir_all(archive.join(PACKING))?;
        let mut to = File::create(&part)?;
        io::copy(&mut from, &mut to)?;
        to.sync_all()?;
        fs::rename(&part, &plain)?;
        File::open(folder)?.sync_all()
    };
    match unpack() {
        Err(error) if error.kind() == io::ErrorKind::InvalidData => Ok(()),
        other => other.named(&plain),
    }
}

struct Last {
    data_end: u64,
    arrivals_end: u64,
    received: Option<UtcTime>,
}

/// The last record whose packet is whole.
fn last_whole(data: &File, data_bytes: u64, arrivals: &File, arrival_bytes: u64) -> io::Result<Last> {
    let mut count = arrival_bytes / ARRIVAL_BYTES as u64;
    let mut packet = Vec::new();
    while count > 0 {
        let mut bytes = [0; ARRIVAL_BYTES];
        arrivals.read_exact_at(&mut bytes, (count - 1) * ARRIVAL_BYTES as u64)?;
        if let Some(Record::Packet(arrival)) = Record::read(&bytes)
            && let Some(end) = packet_end(data, data_bytes, arrival.offset, &mut packet)?
        {
            let arrivals_end = count * ARRIVAL_BYTES as u64;
            return Ok(Last { data_end: end, arrivals_end, received: Some(arrival.received) });
        }
        count -= 1;
    }
    Ok(Last { data_end: 0, arrivals_end: 0, received: None })
}

/// Where the packet at `offset` ends, when a whole one is there.
fn packet_end(data: &File, data_bytes: u64, offset: u64, packet: &mut Vec<u8>) -> io::Result<Option<u64>> {
    let left = data_bytes.saturating_sub(offset);
    if left < HEADER_BYTES as u64 {
        return Ok(None);
    }
    packet.resize(left.min(MAX_PACKET_BYTES as u64) as usize, 0);
    data.read_exact_at(packet, offset)?;
    Ok(PacketView::new(packet).ok().map(|view| offset + view.bytes().len() as u64))
}
