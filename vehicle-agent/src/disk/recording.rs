//! Recording of a run: inputs and outputs of the brain, byte for byte, and its replay.
//!
//! The file begins with a line naming format and version, then records: a letter, a length (u32,
//! little-endian), the bytes. `C` configuration, `P` profile, `S` start (uid, steady time, UTC), `K` a stored plan, `F` who
//! deleted plans last, `U` the task under way, `I` an input, `O` an output.

use crate::setup;
use anyhow::{Context as _, bail};
use config::{Config, InMemory};
use mission::{Change, Kept, Record};
use onboard::record::{read_input, write_input, write_output};
use onboard::{Brain, Input, Output};
use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, BufRead as _, BufReader, BufWriter, Read as _, Write as _};
use std::path::Path;
use units::{MonoTime, Now, UtcTime};

const FORMAT: &str = concat!("lutra-recording 3 ", env!("CARGO_PKG_VERSION"));
/// No record is longer (bytes): a chart.
const LONGEST: u32 = 512 << 20;

/// Writes a recording.
#[derive(Debug)]
pub(crate) struct Recorder {
    file: BufWriter<File>,
}

/// The initial state of a run.
#[derive(Debug)]
pub(crate) struct Beginning {
    pub(crate) config: String,
    pub(crate) profile: String,
    pub(crate) uid: u64,
    pub(crate) now: Now,
    pub(crate) kept: Kept,
}

impl Recorder {
    /// Begins a recording.
    pub(crate) fn create(path: &Path, beginning: &Beginning) -> anyhow::Result<Self> {
        let file = File::create(path).with_context(|| format!("making {}", path.display()))?;
        let mut recorder = Self { file: BufWriter::new(file) };
        writeln!(recorder.file, "{FORMAT}")?;
        recorder.put(b'C', beginning.config.as_bytes())?;
        recorder.put(b'P', beginning.profile.as_bytes())?;
        let mut start = beginning.uid.to_le_bytes().to_vec();
        start.extend(beginning.now.mono.micros().to_le_bytes());
        start.extend(beginning.now.utc.micros().to_le_bytes());
        recorder.put(b'S', &start)?;
        for record in &beginning.kept.plans {
            recorder.put(b'K', &kept_bytes(record))?;
        }
        if let Some(under_way) = &beginning.kept.under_way {
            recorder.put(b'U', under_way)?;
        }
        if let Some(change) = &beginning.kept.forgotten {
            // A plan without a name or contents.
            let record = Record { change: change.clone(), ..Record::default() };
            recorder.put(b'F', &kept_bytes(&record))?;
        }
        Ok(recorder)
    }

    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }

    /// Appends a record of a kind.
    pub(crate) fn put(&mut self, kind: u8, bytes: &[u8]) -> io::Result<()> {
        self.file.write_all(&[kind])?;
        self.file.write_all(&(bytes.len() as u32).to_le_bytes())?;
        self.file.write_all(bytes)
    }
}

/// The record of an input of the brain.
pub(crate) fn input_record(now: Now, input: &Input) -> (u8, Vec<u8>) {
    let mut bytes = Vec::new();
    write_input(&mut bytes, now, input);
    (b'I', bytes)
}

/// The record of an output.
pub(crate) fn output_record(output: &Output) -> (u8, Vec<u8>) {
    let mut bytes = Vec::new();
    write_output(&mut bytes, output);
    (b'O', bytes)
}

/// Result of a replay.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Replayed {
    pub(crate) inputs: u64,
    pub(crate) outputs: u64,
    /// Whether the recording ends in the middle of a record, as after a power cut.
    pub(crate) cut: bool,
}

/// Feeds the recorded inputs to a new brain and compares all outputs.
pub(crate) fn replay(path: &Path) -> anyhow::Result<Replayed> {
    let mut file = BufReader::new(File::open(path).with_context(|| format!("opening {}", path.display()))?);
    let mut first = String::new();
    file.read_line(&mut first)?;
    if first.trim_end() != FORMAT {
        bail!("`{}` is not a recording of this version ({FORMAT})", first.trim_end());
    }
    let mut beginning = Beginning {
        config: String::new(),
        profile: String::new(),
        uid: 0,
        now: Now { mono: MonoTime::default(), utc: UtcTime::default() },
        kept: Kept::default(),
    };
    let mut brain: Option<Brain> = None;
    let mut got: VecDeque<Vec<u8>> = VecDeque::new();
    let mut found = Replayed::default();
    loop {
        let (kind, bytes) = match next(&mut file)? {
            Next::End => break,
            Next::Cut => {
                found.cut = true;
                got.clear();
                break;
            }
            Next::Record(kind, bytes) => (kind, bytes),
        };
        match kind {
            b'C' => beginning.config = String::from_utf8(bytes)?,
            b'P' => beginning.profile = String::from_utf8(bytes)?,
            b'S' => start(&mut beginning, &bytes)?,
            b'K' => beginning.kept.plans.push(kept_record(&bytes).context("a kept plan is damaged")?),
            b'U' => beginning.kept.under_way = Some(bytes),
            b'F' => {
                let record = kept_record(&bytes).context("the last change of the plans is damaged")?;
                beginning.kept.forgotten = Some(record.change);
            }
            b'I' => {
                if let Some(extra) = got.front() {
                    bail!("input {}: an output of {} bytes was not recorded", found.inputs, extra.len());
                }
                let brain = match &mut brain {
                    Some(brain) => brain,
                    none => none.insert(begin(&beginning)?),
                };
                let (now, input) = read_input(&bytes)?;
                brain.handle(now, input);
                found.inputs += 1;
                while let Some(output) = brain.poll_output() {
                    let mut bytes = Vec::new();
                    write_output(&mut bytes, &output);
                    got.push_back(bytes);
                }
            }
            b'O' => {
                let same = got.pop_front().is_some_and(|output| output == bytes);
                if !same {
                    bail!("output {} (after input {}) differs", found.outputs, found.inputs);
                }
                found.outputs += 1;
            }
            other => bail!("a record of unknown kind {other}"),
        }
    }
    if !got.is_empty() {
        bail!("{} outputs after the last input were not recorded", got.len());
    }
    Ok(found)
}

fn begin(beginning: &Beginning) -> anyhow::Result<Brain> {
    let files = InMemory::new().with("recorded.ini", beginning.config.as_str());
    let config = Config::load(&files, "recorded.ini".as_ref(), &[&beginning.profile]);
    let (settings, _) = setup::settings(&config, beginning.uid)?;
    Ok(Brain::new(settings, beginning.now, beginning.kept.clone())?)
}

enum Next {
    Record(u8, Vec<u8>),
    Cut,
    End,
}

fn next(file: &mut impl io::Read) -> anyhow::Result<Next> {
    let mut head = [0; 5];
    let mut have = 0;
    while have < head.len() {
        match file.read(&mut head[have..])? {
            0 if have == 0 => return Ok(Next::End),
            0 => return Ok(Next::Cut),
            length => have += length,
        }
    }
    let length = u32::from_le_bytes([head[1], head[2], head[3], head[4]]);
    if length > LONGEST {
        bail!("a record of {length} bytes");
    }
    let mut bytes = Vec::new();
    file.take(length.into()).read_to_end(&mut bytes)?;
    Ok(if bytes.len() as u64 == u64::from(length) { Next::Record(head[0], bytes) } else { Next::Cut })
}

fn start(beginning: &mut Beginning, bytes: &[u8]) -> anyhow::Result<()> {
    let numbers: [u8; 24] = bytes.try_into().context("the start is damaged")?;
    let number = |at: usize| {
        let mut eight = [0; 8];
        eight.copy_from_slice(&numbers[at..at + 8]);
        u64::from_le_bytes(eight)
    };
    beginning.uid = number(0);
    // The same 64 bits that were written.
    beginning.now =
        Now { mono: MonoTime::from_micros(number(8)), utc: UtcTime::from_micros(number(16) as i64) };
    Ok(())
}

fn kept_bytes(record: &Record) -> Vec<u8> {
    let mut out = record.digest.to_vec();
    out.extend(record.change.at.micros().to_le_bytes());
    out.extend(record.change.system.to_le_bytes());
    for text in [record.plan_id.as_bytes(), record.change.name.as_bytes(), &record.bytes] {
        out.extend((text.len() as u32).to_le_bytes());
        out.extend(text);
    }
    out
}

fn kept_record(bytes: &[u8]) -> Option<Record> {
    let (digest, rest) = bytes.split_first_chunk::<16>()?;
    let (at, rest) = rest.split_first_chunk::<8>()?;
    let (system, mut rest) = rest.split_first_chunk::<2>()?;
    let mut text = || {
        let (length, after) = rest.split_first_chunk::<4>()?;
        let (text, after) = after.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        rest = after;
        Some(text.to_vec())
    };
    let (plan_id, name, bytes) = (text()?, text()?, text()?);
    Some(Record {
        plan_id: String::from_utf8(plan_id).ok()?,
        bytes,
        digest: *digest,
        change: Change {
            at: UtcTime::from_micros(i64::from_le_bytes(*at)),
            system: u16::from_le_bytes(*system),
            name: String::from_utf8(name).ok()?,
        },
    })
}
