//! Reads a day of the archive: each packet with its transport and arrival time.

use super::arrival::{ARRIVAL_BYTES, Arrival, Record};
use super::bytes::{self, DayFile};
use super::day::Lengths;
use super::layout::{ARRIVALS, DATA, DayKey, packed_name};
use crate::error::{Named as _, Result, StoreError};
use imc::PacketView;
use imc::lsf::{LogItem, LogReader};
use link::Transport;
use std::io::{self, BufReader, Read as _};
use std::path::{Path, PathBuf};
use units::UtcTime;

/// The records of a day, in order. A stretch that is not a record gives `None`, as the end does; a caller stops there.
#[derive(Debug)]
pub(crate) struct Records {
    file: Option<BufReader<DayFile>>,
    path: PathBuf,
    at: u64,
}

impl Records {
    /// From byte `at` on; nothing when there is no file.
    pub(crate) fn open(folder: &Path, at: u64) -> Result<Self> {
        let path = folder.join(ARRIVALS);
        if !bytes::is_there(folder, ARRIVALS) {
            return Ok(Self { file: None, path, at });
        }
        let file = match DayFile::open(folder, ARRIVALS, at) {
            // As good as gone: the packets are kept without.
            Err(StoreError::Io { source, .. }) if source.kind() == io::ErrorKind::InvalidData => {
                return Ok(Self { file: None, path, at });
            }
            other => other?,
        };
        Ok(Self { file: Some(BufReader::with_capacity(1 << 15, file)), path, at })
    }

    pub(crate) fn next(&mut self) -> Result<Option<Record>> {
        let Some(file) = &mut self.file else { return Ok(None) };
        let mut bytes = [0; ARRIVAL_BYTES];
        match file.read_exact(&mut bytes) {
            Ok(()) => {
                self.at += ARRIVAL_BYTES as u64;
                Ok(Record::read(&bytes))
            }
            Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => Ok(None),
            Err(source) => Err(StoreError::Io { path: self.path.clone(), source }),
        }
    }
}

/// The packets of a day.
#[derive(Debug)]
pub struct DayReader {
    log: LogReader<DayFile>,
    /// Where the log was opened: its offsets count from there.
    log_at: u64,
    records: RecordsAhead,
    path: PathBuf,
    packet: Vec<u8>,
    damage: u64,
    /// Time for packets that have no record.
    fallback: UtcTime,
}

/// A packet of the archive.
#[derive(Debug)]
pub struct Archived<'a> {
    /// The packet.
    pub view: PacketView<'a>,
    /// How and when it came.
    pub arrival: Arrival,
    /// Where reading continues behind it.
    pub(crate) end: Lengths,
}

impl DayReader {
    /// The day's packets from byte `data_at` of `Data.lsf` and byte `records_at` of `Arrivals.idx` on.
    pub(crate) fn open(archive: &Path, key: DayKey, data_at: u64, records_at: u64) -> Result<Self> {
        let folder = key.folder(archive);
        let file = DayFile::open(&folder, DATA, data_at)?;
        let path = folder.join(if matches!(file, DayFile::Packed(_)) { packed_name(DATA) } else { DATA });
        Ok(Self {
            log: LogReader::new(file),
            log_at: data_at,
            records: RecordsAhead {
                records: Records::open(&folder, records_at)?,
                at: records_at,
                ahead: None,
            },
            path,
            packet: Vec::new(),
            damage: 0,
            fallback: key.start().unwrap_or_default(),
        })
    }

    /// The next packet. Bytes that are not valid are passed over and counted.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn next_packet(&mut self) -> Result<Option<Archived<'_>>> {
        let at = loop {
            match self.log.next_item().named(&self.path)? {
                Some(LogItem::Packet { offset, view }) => {
                    self.packet.clear();
                    self.packet.extend_from_slice(view.bytes());
                    break self.log_at + offset;
                }
                Some(LogItem::Damage(damage)) => self.damage += damage.bytes,
                Some(LogItem::Cut { .. }) => {}
                None => return Ok(None),
            }
        };
        let arrival = self.records.find(at, self.fallback)?;
        self.fallback = arrival.received;
        let end = Lengths { data: at + self.packet.len() as u64, arrivals: self.records.at };
        Ok(Some(Archived { view: PacketView::unchecked(&self.packet)?, arrival, end }))
    }

    /// Bytes passed over so far.
    pub fn damaged_bytes(&self) -> u64 {
        self.damage
    }
}

/// Records, read as far as the packets need.
#[derive(Debug)]
struct RecordsAhead {
    records: Records,
    /// Where the records of the packets that were asked for end.
    at: u64,
    ahead: Option<Arrival>,
}

impl RecordsAhead {
    /// The record of the packet at `offset`; a packet without one came at `fallback`.
    fn find(&mut self, offset: u64, fallback: UtcTime) -> Result<Arrival> {
        loop {
            match self.ahead {
                Some(found) if found.offset == offset => {
                    self.ahead = None;
                    self.at = self.records.at;
                    return Ok(found);
                }
                Some(arrival) if arrival.offset > offset => break,
                _ => {}
            }
            match self.records.next()? {
                Some(Record::Jump { .. }) => {}
                Some(Record::Packet(arrival)) => self.ahead = Some(arrival),
                None => break,
            }
        }
        Ok(Arrival { offset, received: fallback, transport: Transport::Recovered, link: None, first: false })
    }
}
