//! Lines of JSON to packets.

use crate::input::{CHUNK, Input};
use anyhow::Context as _;
use imc::catalogue::MESSAGES;
use imc::json::{self, ReadDefaults, ReadError};
use serde_json::{Map, Value};
use std::io::{self, BufRead as _, BufReader, Read as _};

/// Longest line read. The longest packet, all in the smallest nested messages, is about 2 MB of JSON.
const LINE_MAX: usize = 16 << 20;

/// The packets of a file of JSON lines.
pub(crate) struct JsonLines {
    name: String,
    reader: BufReader<Input>,
    number: u64,
    line: Vec<u8>,
}

/// A line that is not a packet; with the file, the line and the error.
#[derive(Debug)]
pub(crate) struct BadLine(pub(crate) String);

impl JsonLines {
    /// From the start of the input.
    pub(crate) fn new(input: Input) -> Self {
        let name = input.name().to_owned();
        Self { name, reader: BufReader::with_capacity(CHUNK, input), number: 0, line: Vec::new() }
    }

    /// The packet of the next line that is not blank; `None` at the end.
    ///
    /// # Errors
    /// When the input cannot be read on. A bad line is a value, since the next may be good.
    pub(crate) fn next(
        &mut self,
        packet: impl Fn(&mut Value) -> Result<Vec<u8>, String>,
    ) -> anyhow::Result<Option<Result<Vec<u8>, BadLine>>> {
        while self.read_line()? {
            if !self.line.trim_ascii().is_empty() {
                let packet = parse(&self.line).and_then(|mut value| packet(&mut value));
                let located = |problem| BadLine(format!("{}:{}: {problem}", self.name, self.number));
                return Ok(Some(packet.map_err(located)));
            }
        }
        Ok(None)
    }

    /// Whether another line is available without waiting.
    pub(crate) fn is_ready(&self) -> bool {
        self.reader.buffer().contains(&b'\n')
    }

    /// Reads a line; one that is too long is cut.
    fn read_line(&mut self) -> anyhow::Result<bool> {
        self.line.clear();
        self.number += 1;
        let place = || format!("cannot read {}:{}", self.name, self.number);
        let limit = LINE_MAX as u64 + 1;
        (&mut self.reader).take(limit).read_until(b'\n', &mut self.line).with_context(place)?;
        if self.line.len() > LINE_MAX && !self.line.ends_with(b"\n") {
            skip_line(&mut self.reader).with_context(place)?;
        }
        Ok(!self.line.is_empty())
    }
}

fn skip_line(reader: &mut BufReader<Input>) -> io::Result<()> {
    loop {
        let buffer = reader.fill_buf()?;
        let (count, end) = match buffer.iter().position(|&byte| byte == b'\n') {
            Some(at) => (at + 1, true),
            None => (buffer.len(), buffer.is_empty()),
        };
        reader.consume(count);
        if end {
            return Ok(());
        }
    }
}

fn parse(line: &[u8]) -> Result<Value, String> {
    if line.len() > LINE_MAX {
        return Err(format!("the line is longer than {} MiB: no packet is", LINE_MAX >> 20));
    }
    serde_json::from_slice(line.trim_ascii_end()).map_err(|error| {
        let problem = error.to_string();
        // The line number is known here; in the parser's text it is always 1.
        let problem = problem.rsplit_once(" at line ").map_or(problem.as_str(), |(problem, _)| problem);
        format!("no JSON from column {}: {problem}", error.column())
    })
}

/// The bytes of the packet that a line describes: as printed by `imc decode`, or damage that includes them.
///
/// # Errors
/// With the JSON path and what is wrong there.
pub(crate) fn packet(value: &Value, defaults: &ReadDefaults) -> Result<Vec<u8>, String> {
    if let Some(object) = value.as_object()
        && object.contains_key("error")
    {
        return kept(object);
    }
    let packet = json::read_packet(value, defaults).map_err(|error| explained(&error))?;
    packet.encode().map_err(|error| error.to_string())
}

/// The error, with a suggestion of what may have been meant.
fn explained(error: &ReadError) -> String {
    let text = error.to_string();
    let alike = match error {
        ReadError::Part { path, problem } if path.ends_with("abbrev") => {
            let name = problem.split('`').nth(1).unwrap_or_default();
            suggest::alike(name, MESSAGES.iter().map(|message| message.abbrev))
        }
        ReadError::Part { .. } | ReadError::Encode(_) => Vec::new(),
    };
    if alike.is_empty() { text } else { format!("{text}; did you mean {}?", alike.join(", ")) }
}

/// The bytes in a line of damage.
fn kept(object: &Map<String, Value>) -> Result<Vec<u8>, String> {
    let class = object.get("error").and_then(Value::as_str).unwrap_or("an error");
    let Some(packet) = object.get("packet") else {
        return Err(format!(
            "error: decode found {class} here and its bytes are not kept; remove the line, or take them \
             from the original"
        ));
    };
    let mut bytes = unhex(packet, "packet")?;
    if let Some(excess) = object.get("excess") {
        bytes.extend(unhex(excess, "excess")?);
    }
    Ok(bytes)
}

fn unhex(value: &Value, path: &str) -> Result<Vec<u8>, String> {
    value
        .as_str()
        .and_then(|text| hex::decode(text).ok())
        .ok_or_else(|| format!("{path}: expected bytes as pairs of hexadecimal digits"))
}
