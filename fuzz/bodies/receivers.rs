//! What must hold for any bytes at the port of a GNSS compass or a hydrophone. The fuzz target calls this with bytes of its
//! own making, and `make test` with the committed seeds, everything that was ever found, and what proptest thinks of.

use devices::pattern::Pattern;
use devices::{Reading, nmea, tbr, vr2c};
use drivers::gnss::{Compass, CompassSettings};
use drivers::gpsd::{Gpsd, Watch};
use drivers::hydrophone::{Receiver, ReceiverSettings, Setting};
use drivers::line_receiver::{Language, LineReceiver, LineReceiverSettings};
use drivers::{Driver, Input, Output};
use units::{MonoTime, Now, UtcTime};

const GNSS_LINE: &[u8] = b"\r\n$GPHDT,81.01,T*3D\r\n";
const TAG_LINE: &[u8] = b"\r$000025,1487343577,721,S256,40,13,17,67,15790\r";
/// A receiver's line as a person may declare it.
const PATTERN: &str = "${serial},{unix_ms},{protocol},{id},{data?},{snr_db},{khz},{counter}*{xor8}";
const PATTERN_LINE: &[u8] = b"\r\n$77,1795000000250,R64K,1705,,21,69,8*3D\r\n";
const VR2C_LINE: &[u8] = b"\r\n450123,017,2026-09-21 12:43:17,A69-1303,12345,#D0\r\n";

/// Lines come out the same however the bytes are cut, no framer keeps more than its bound, and the line that follows is
/// read; drivers take the bytes in whatever state they are.
pub(crate) fn lines(data: &[u8]) {
    let (cut, data) =
        data.split_first().map_or((1, data), |(first, rest)| (usize::from(*first).max(1), rest));
    framed(data, cut);
    driven(data, cut);
    declared(data);
}

/// A pattern of whatever text is read or refused, and so is every line by one that was read.
fn declared(data: &[u8]) {
    let mut lines = data.split(|byte| *byte == b'\n');
    let text = String::from_utf8_lossy(lines.next().unwrap_or_default());
    for pattern in [Pattern::parse(&text), Pattern::parse(PATTERN)].into_iter().flatten() {
        for line in lines.clone() {
            if let Ok(tag) = pattern.read(line) {
                assert!(tag.raw.is_some(), "the raw line is kept");
            }
        }
    }
}

/// Feeds one framer in three ways, with a good line behind the bytes, and compares.
macro_rules! compare {
    ($framer:path, $longest:expr, $line:expr, $data:expr, $cut:expr) => {{
        let stream: Vec<u8> = [$data, $line].concat();
        let read = |cut: usize| {
            let mut framer = <$framer>::default();
            let mut found = Vec::new();
            for bytes in stream.chunks(cut) {
                framer.feed(bytes, |offset, read| found.push((offset, format!("{read:?}"), read.is_ok())));
                assert!(framer.kept() <= $longest);
            }
            framer.end(|offset, read| found.push((offset, format!("{read:?}"), read.is_ok())));
            found
        };
        let found = read(stream.len());
        assert_eq!(read($cut), found);
        assert_eq!(read(1), found);
        assert!(found.windows(2).all(|two| two[0].0 < two[1].0), "offsets grow");
        assert!(found.last().is_some_and(|(_, _, ok)| *ok), "the line that follows is read");
    }};
}

fn framed(data: &[u8], cut: usize) {
    compare!(nmea::Framer, nmea::LONGEST, GNSS_LINE, data, cut);
    compare!(tbr::Framer, tbr::LONGEST, TAG_LINE, data, cut);
    compare!(vr2c::Framer, vr2c::LONGEST, VR2C_LINE, data, cut);
}

fn driven(data: &[u8], cut: usize) {
    let settings: Vec<Setting> =
        ["FC=69", "FV?"].iter().filter_map(|text| Setting::parse(text).ok()).collect();
    let compass = CompassSettings { baud: Some(19_200), ..CompassSettings::default() };
    drive(&mut Compass::new(compass), data, cut, GNSS_LINE);
    drive(&mut Gpsd::new(Watch::Nmea, &CompassSettings::default()), data, cut, GNSS_LINE);
    drive(
        &mut Gpsd::new(Watch::Json, &CompassSettings::default()),
        data,
        cut,
        b"\n{\"class\":\"TPV\",\"mode\":1}\n",
    );
    drive(&mut Receiver::new(ReceiverSettings::default()), data, cut, TAG_LINE);
    drive(
        &mut Receiver::new(ReceiverSettings { settings, ..ReceiverSettings::default() }),
        data,
        cut,
        TAG_LINE,
    );
    let innovasea =
        LineReceiverSettings { language: Language::Innovasea, init: Vec::new(), longest_silence: None };
    drive(&mut LineReceiver::new(innovasea.clone()), data, cut, VR2C_LINE);
    if let Ok(pattern) = Pattern::parse(PATTERN) {
        let language = Language::Pattern(pattern);
        drive(
            &mut LineReceiver::new(LineReceiverSettings { language, ..innovasea }),
            data,
            cut,
            PATTERN_LINE,
        );
    }
}

/// A driver's life with these bytes: opened, fed with time going by, lost, opened again, and a good line, which is a reading.
fn drive(driver: &mut dyn Driver, data: &[u8], cut: usize, line: &[u8]) {
    let mut us = 0;
    let mut step = |driver: &mut dyn Driver, add_us: u64, input: Input<'_>| {
        us += add_us;
        let now = Now {
            mono: MonoTime::from_micros(us),
            utc: UtcTime::from_micros(1_795_000_000_000_000 + us as i64),
        };
        driver.handle(now, input);
        let mut readings = 0;
        while let Some(output) = driver.poll_output() {
            let about = matches!(output, Output::Reading { reading: Reading::Receiver(_), .. });
            readings += usize::from(matches!(output, Output::Reading { .. }) && !about);
        }
        readings
    };
    step(driver, 0, Input::Opened);
    for bytes in data.chunks(cut) {
        step(driver, 300_000, Input::Bytes(bytes));
        step(driver, 300_000, Input::Time);
    }
    step(driver, 10, Input::Lost);
    step(driver, 10, Input::Opened);
    let given = step(driver, 10, Input::Bytes(line)) + step(driver, 1_000_000, Input::Time);
    assert!(given >= 1, "a good line is a reading");
}
