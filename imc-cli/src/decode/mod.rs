//! `imc decode`: packets to JSON.

mod hex;
mod raw;

use crate::input::Input;
use crate::outcome::Outcome;
use crate::output::Output;
use imc::ShortPayload;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  imc decode Data.lsf.gz                       a log; gzip is unpacked as it is read
  nc vehicle 6003 | imc decode                 packets as they come
  echo 54fe9600...7e16 | imc decode            hex text, one packet a line
  imc decode x.lsf | jq -c 'select(.abbrev == \"GpsFix\") | .fields'
  imc decode x.lsf | jq -c 'select(.error)'    only the damage

Each packet is one line:
  {\"abbrev\":\"Temperature\",\"id\":263,
   \"header\":{\"timestamp\":1590400000.5,\"src\":10256,\"src_ent\":5,\"dst\":65535,\"dst_ent\":255},
   \"fields\":{\"value\":7.5}}

Damage is one line in its place:
  {\"error\":\"bad_crc\",\"offset\":44,\"bytes\":22,\"message\":\"bad CRC 0x83b0, ...\"}
  bad_sync, bad_crc, truncated
                             no whole packet; the next one is found again
  unknown_id, field_overrun, nested_unknown_id, nested_too_deep
                             a whole packet that cannot be read: its id, header and all
                             its bytes (`packet`) are given, and encode takes them
  bad_hex, excess_bytes      on a line of hex text
  bad_gzip                   the packed file is cut or damaged from here on

`offset` and `bytes` tell the run of damaged bytes, counted in the unpacked stream, or on a hex line from \
the packet's first byte (with the line's number in `line`).

Exit status: 0 all packets were decoded, 1 anything was damaged, 2 misuse.";

/// Prints packets as JSON, one object a line.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Decode {
    /// Packets back to back, as in a log or capture, or hex text with one packet a line; gzip'd or not
    #[arg(value_name = "FILE", default_value = "-")]
    file: PathBuf,
    /// The input is hex text: every line gives exactly one line
    #[arg(long, conflicts_with = "raw")]
    hex: bool,
    /// The input is raw packets, even if it looks like hex text
    #[arg(long)]
    raw: bool,
    /// Accept payloads that end early, between two fields, as older senders wrote them
    #[arg(long)]
    lenient: bool,
}

impl Decode {
    pub(crate) fn run(&self, out: &mut Output) -> anyhow::Result<Outcome> {
        let mut input = Input::open(&self.file)?;
        let short = if self.lenient { ShortPayload::AnyBoundary } else { ShortPayload::KnownLayouts };
        let hex = self.hex || !self.raw && hex::looks_like_text(&mut input)?;
        let outcome =
            if hex { hex::decode(&mut input, out, short)? } else { raw::decode(&mut input, out, short)? };
        Ok(outcome)
    }
}
