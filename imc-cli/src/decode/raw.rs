//! Packets back to back.

use crate::input::{CHUNK, Input};
use crate::outcome::Outcome;
use crate::output::Output;
use crate::record::{self, Place};
use anyhow::Context as _;
use imc::{Deframer, ShortPayload};
use std::io::{self, Read as _, Write as _};

/// Prints each packet as soon as its last byte was read.
pub(super) fn decode(input: &mut Input, out: &mut Output, short: ShortPayload) -> anyhow::Result<Outcome> {
    let mut stream = Stream { deframer: Deframer::new(), short, damaged: false, lines: Vec::new() };
    let mut chunk = vec![0; CHUNK];
    let mut at = 0;
    let unpack_error = loop {
        match input.read(&mut chunk) {
            Ok(0) => break None,
            Ok(count) => {
                at += count as u64;
                stream.deframer.push(&chunk[..count]);
                stream.print(out)?;
                out.flush()?;
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) if input.is_damage(&error) => break Some(error),
            Err(error) => {
                return Err(error).with_context(|| format!("cannot read {} at byte {at}", input.name()));
            }
        }
    };
    stream.deframer.finish();
    stream.print(out)?;
    if let Some(error) = unpack_error {
        stream.damaged = true;
        stream.lines.clear();
        record::bad_gzip(&mut stream.lines, at, None, &error.to_string());
        out.write_all(&stream.lines)?;
    }
    Ok(Outcome::damaged_if(stream.damaged))
}

struct Stream {
    deframer: Deframer,
    short: ShortPayload,
    damaged: bool,
    /// Reused from packet to packet.
    lines: Vec<u8>,
}

impl Stream {
    /// Prints all complete packets.
    fn print(&mut self, out: &mut Output) -> io::Result<()> {
        while let Some(frame) = self.deframer.next_frame() {
            self.lines.clear();
            self.damaged |= !record::frame(&mut self.lines, &frame, Place::default(), self.short);
            out.write_all(&self.lines)?;
        }
        Ok(())
    }
}
