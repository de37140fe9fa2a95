//! `lutra-agent sniff`: decodes a device's data into readable lines or JSON, from a port, a recording or standard input.
//!
//! A [`Decoder`] turns bytes into [`Found`] lines; `source` opens their source. Only the current line is kept, so a
//! recording may have any size. A decoder for another device is added in its own file and gets a row in
//! [`Device::decoder`].

mod gnss;
mod pattern;
mod source;
mod tbr;
mod torqeedo;
mod tq_bus;
mod vr2c;

use crate::clock::Clock;
use anyhow::Context as _;
use clap::{Args, ValueEnum};
use devices::pattern::Pattern;
use source::Source;
use std::io::{self, BufWriter, Write};
use std::path::PathBuf;

/// One line of output.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Found {
    /// As JSON with SI values: an object.
    pub(crate) json: serde_json::Value,
    /// For people.
    pub(crate) text: String,
}

impl Found {
    /// A damaged line: why, and the offset of its first byte in the stream.
    pub(crate) fn damaged(why: &impl std::fmt::Display, offset: u64) -> Self {
        let why = why.to_string();
        Self {
            text: format!("damaged at byte {offset}: {why}"),
            json: serde_json::json!({"error": why, "offset": offset}),
        }
    }
}

/// Decodes a device's bytes into lines. Damaged lines are reported in place, as `{"error": why, "offset": byte}` with the
/// offset of their first byte.
pub(crate) trait Decoder {
    /// Takes the next bytes.
    fn feed(&mut self, bytes: &[u8], found: &mut Vec<Found>);
    /// The end of the data: reports what is complete, or what the last bytes lack.
    fn end(&mut self, found: &mut Vec<Found>);
}

/// Help text about the JSON.
pub(crate) const HELP: &str = "JSON, one object a line; a key is absent where the device did not report it:

gnss, one for each epoch:
  {t, lat_deg, lon_deg, quality, sats, hdop, cog_rad, sog_mps, heading_rad, rot_rad_s, utc}
  t            from a port: arrival of the epoch's first sentence by this computer's clock;
               from a recording or standard input: the epoch's own time, its date carried on
               from an earlier epoch where it has none. ISO 8601 UTC
  utc          date and time as the epoch itself has both
  quality      GGA's number: 0 no position, 1 autonomous, 2 differential, 4 RTK fixed,
               5 RTK float, 6 estimated
  cog_rad      course over ground; heading_rad: true heading; from north, in [0, 2 pi)
  rot_rad_s    rate of turn, positive to starboard
tbr, one for each line:
  {kind: detection, serial, utc_s, ms, protocol, id, data, snr, freq_khz}
  {kind: sensor, serial, utc_s, temperature_c, noise_avg, noise_peak, freq_khz}
  {kind: reply, text}
  utc_s        the receiver's clock; below 1000000000 it is not set and counts from power-up
  data         null where the coding carries none
torqeedo, one for each CAN frame of candump logs, ID#DATA lines or an slcan adapter:
  {t, what, source, destination, ...}
  t            ISO 8601 UTC, of candump logs
  what         rail, outputs, output_set, uptime, motor_drive, motor_set, battery_status,
               motor_status, battery_control, id, text, ...; values with their unit in the
               key: voltage_v, current_a, power_w, temperature_c, motor_rpm, propeller_rpm,
               charge_percent, throttle_0 and throttle_1 of -1 to 1; an unknown one has data
  An adapter at a port must be open already, as slcand or its own program leaves it.
tq-bus, one for each frame of the motors' own RS-485 bus: {what, address, message, ...}
vr2c, rxlive, one for each line:
  a detection as of tbr, without snr where the receiver does not report it (signal less noise)
  {kind: status, serial, utc, text}
pattern, one for each line: a detection as of tbr, with {raw}, the line as it came
all: {error, offset}, a damaged line in its place; offset of its first byte in the stream";

/// Arguments of `lutra-agent sniff`.
#[derive(Debug, Args)]
pub(crate) struct SniffArguments {
    /// The kind of device.
    #[arg(long, value_enum)]
    device: Device,
    /// A serial port, a recording, or - for standard input.
    #[arg(value_name = "PORT|FILE|-")]
    from: PathBuf,
    /// One JSON object a line, in SI units.
    #[arg(long)]
    json: bool,
    /// Speed of a serial port (baud); usual for the device where it is not given.
    #[arg(long, value_name = "N")]
    baud: Option<u32>,
    /// The lines of the device `pattern`, as {serial},{utc},{protocol},{id},{data?},#{sum8}.
    ///
    /// Text is literal, fields are in braces; ? lets a field be empty. Fields: serial, counter, protocol, id, data, snr_db,
    /// skip; the time unix_s (with ms), unix_ms or utc; the carrier khz or hz; checksums sum8 and xor8, two hexadecimal
    /// digits over the line before the text in front of them, without a leading $.
    #[arg(long, value_name = "TEXT", required_if_eq("device", "pattern"), value_parser = Pattern::parse)]
    pattern: Option<Pattern>,
}

/// A kind of device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Device {
    /// GNSS compass: NMEA 0183, 115200 baud.
    Gnss,
    /// Thelma Biotel hydrophone, TBR 700 or TB Live: 115200 baud.
    Tbr,
    /// Motors, batteries and power rails on the card's CAN bus: 115200 baud of an slcan adapter.
    Torqeedo,
    /// The motors' own RS-485 bus, for work at the bench: 19200 baud.
    TqBus,
    /// Innovasea VR2C: whole seconds, 9600 baud.
    Vr2c,
    /// Innovasea Rx-LIVE: thousandths of a second, signal and noise, 9600 baud.
    Rxlive,
    /// Any receiver with a line for each detection, which --pattern declares: 9600 baud.
    Pattern,
}

impl Device {
    /// Speed of its port on the boats (baud).
    const fn baud(self) -> u32 {
        match self {
            Self::TqBus => 19_200,
            Self::Gnss | Self::Tbr | Self::Torqeedo => 115_200,
            Self::Vr2c | Self::Rxlive | Self::Pattern => 9600,
        }
    }

    /// Its decoder. `arrivals` is the clock for times of arrival, if there are any.
    ///
    /// # Errors
    /// When the device needs a pattern and none is given.
    fn decoder(self, arrivals: Option<Clock>, pattern: Option<&Pattern>) -> anyhow::Result<Box<dyn Decoder>> {
        Ok(match self {
            Self::Gnss => Box::new(gnss::Gnss::new(arrivals)),
            Self::Tbr => Box::new(tbr::Tbr::default()),
            Self::Torqeedo => Box::new(torqeedo::Torqeedo::new()),
            Self::TqBus => Box::new(tq_bus::TqBus::new()),
            Self::Vr2c | Self::Rxlive => Box::new(vr2c::Vr2c::default()),
            Self::Pattern => {
                let declared = pattern.context("give the lines' --pattern")?;
                Box::new(pattern::Declared::new(declared.clone()))
            }
        })
    }
}

/// Prints a device's data until the end.
///
/// # Errors
/// When the source cannot be opened or read, or the output not written. A reader that has gone is no error.
pub(crate) fn sniff(arguments: &SniffArguments) -> anyhow::Result<()> {
    let SniffArguments { device, from, json, baud, pattern } = arguments;
    let mut source = Source::open(from, *baud, device.baud())?;
    let arrivals = source.is_port().then(Clock::system);
    let mut decoder = device.decoder(arrivals, pattern.as_ref())?;
    let mut out = BufWriter::new(io::stdout().lock());
    match copy(&mut source, decoder.as_mut(), &mut out, *json) {
        Err(Stopped::Unread) | Ok(()) => Ok(()),
        Err(Stopped::Write(error)) => Err(error).context("writing the outcome"),
        Err(Stopped::Read(error)) => {
            Err(error).with_context(|| format!("reading {}: {}", from.display(), source.remedy()))
        }
    }
}

/// Why it ended before the source did.
#[derive(Debug)]
enum Stopped {
    /// The reader of the output is gone.
    Unread,
    Write(io::Error),
    Read(io::Error),
}

impl Stopped {
    fn written(error: io::Error) -> Self {
        if error.kind() == io::ErrorKind::BrokenPipe { Self::Unread } else { Self::Write(error) }
    }
}

fn copy(
    source: &mut impl io::Read,
    decoder: &mut dyn Decoder,
    out: &mut impl Write,
    json: bool,
) -> Result<(), Stopped> {
    let mut bytes = [0; 4096];
    let mut found = Vec::new();
    loop {
        match source.read(&mut bytes) {
            Ok(0) => break,
            Ok(count) => decoder.feed(&bytes[..count], &mut found),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => {
                // Data from before the port was lost are valid.
                decoder.end(&mut found);
                print(&mut found, out, json).map_err(Stopped::written)?;
                return Err(Stopped::Read(error));
            }
        }
        print(&mut found, out, json).map_err(Stopped::written)?;
    }
    decoder.end(&mut found);
    print(&mut found, out, json).map_err(Stopped::written)
}

fn print(found: &mut Vec<Found>, out: &mut impl Write, json: bool) -> io::Result<()> {
    for Found { json: object, text } in found.drain(..) {
        if json {
            writeln!(out, "{object}")?;
        } else {
            writeln!(out, "{text}")?;
        }
    }
    out.flush()
}

#[cfg(test)]
mod tests;
