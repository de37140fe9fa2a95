//! Tables of detections of other receivers' programs and of portals, by the names of their columns.
//!
//! What a file does not tell stays unknown: the ratio of signal to noise where there is no column or no value of it, and the
//! carrier where neither the code space nor the protocol names it. The line as it came is kept with the detection.
//!
//! Names of columns are those that R packages read: ComPort, VUE and the ids and times of Fathom by actel, Fathom's other columns
//! and OTN by glatos, ETN by etn. Neither of them says whether ComPort's Unix time has decimals: both are read.

use super::own::{both, place};
use super::row::{Row, empty, shown};
use super::{Carriers, Wrong};
use api::{RegisterDeployment, say};
use detections::{
    Detection, Effort, Maker as ReceiverMaker, Origin, Pose, Protocol, ReceiverClock, SET_AFTER_S,
};
use imc::Address;
use units::UtcTime;

/// What a file of Fathom begins with: it has several tables.
pub(super) const LOG: &str = "VEMCO DATA LOG";
/// The first cell of the line that names the columns of detections there.
pub(super) const LOG_HEADER: &str = "DET_DESC";
/// The first cell of a detection there.
pub(super) const LOG_ROW: &str = "DET";

/// The entity of imported detections: IMC's for one that is not known.
const ENTITY: u8 = 255;
/// The receiver of rows that are releases of animals (OTN).
const RELEASE: &str = "release";
/// The unit of a sensor's count; others are of values that the maker's program has converted.
const COUNT: &str = "ADC";

/// Names of the columns of a table, in lower case; empty where it has none.
#[derive(Debug)]
pub(super) struct Maker {
    /// Columns that no other table has together.
    pub(super) known_by: &'static [&'static str],
    time: &'static str,
    /// Seconds to add to the time.
    correction: &'static str,
    /// Seconds since 1970 that say the same as the time, with decimals.
    unix: &'static str,
    /// Thousandths beside these.
    millis: &'static str,
    receiver: &'static str,
    /// The model of the receiver, where it has a column of its own.
    model: &'static str,
    /// Who made all receivers of such a table; else the model says it, which may stand before the serial number.
    made_by: Option<ReceiverMaker>,
    /// Code space and number, or the number alone where there is a protocol.
    tag: &'static str,
    protocol: &'static str,
    data: &'static str,
    unit: &'static str,
    snr: &'static str,
    signal: &'static str,
    noise: &'static str,
    lat: &'static str,
    lon: &'static str,
    /// The zone of the time.
    zone: &'static str,
}

const NOTHING: Maker = Maker {
    known_by: &[],
    time: "",
    correction: "",
    unix: "",
    millis: "",
    receiver: "receiver",
    model: "",
    made_by: None,
    tag: "",
    protocol: "",
    data: "",
    unit: "",
    snr: "",
    signal: "",
    noise: "",
    lat: "",
    lon: "",
    zone: "",
};

/// Rows `DET` of Innovasea's Fathom, of both versions.
pub(super) static FATHOM: Maker = Maker {
    time: "device time (utc)",
    correction: "time correction (s)",
    receiver: "serial number",
    model: "model",
    made_by: Some(ReceiverMaker::Innovasea),
    tag: "full id",
    data: "raw data",
    signal: "signal strength (db)",
    noise: "noise (db)",
    lat: "latitude",
    lon: "longitude",
    ..NOTHING
};

/// Thelma Biotel's ComPort (two), VUE, ETN, OTN since 2025 and before.
pub(super) static MAKERS: [Maker; 6] = [
    Maker {
        known_by: &["date and time utc", "tbr serial number", "unix timestamp utc", "codetype", "id"],
        time: "date and time utc",
        unix: "unix timestamp utc",
        millis: "millisecond",
        receiver: "tbr serial number",
        made_by: Some(ReceiverMaker::Thelma),
        tag: "id",
        protocol: "codetype",
        data: "data",
        snr: "signal to noise ratio",
        ..NOTHING
    },
    Maker {
        known_by: &["date and time (utc)", "unix timestamp (utc)", "id", "protocol", "receiver"],
        time: "date and time (utc)",
        unix: "unix timestamp (utc)",
        made_by: Some(ReceiverMaker::Thelma),
        tag: "id",
        protocol: "protocol",
        data: "data",
        snr: "snr",
        ..NOTHING
    },
    Maker {
        known_by: &["date and time (utc)", "receiver", "transmitter"],
        time: "date and time (utc)",
        tag: "transmitter",
        data: "sensor value",
        unit: "sensor unit",
        lat: "latitude",
        lon: "longitude",
        ..NOTHING
    },
    Maker {
        known_by: &["date_time", "acoustic_tag_id", "receiver_id"],
        time: "date_time",
        receiver: "receiver_id",
        tag: "acoustic_tag_id",
        data: "sensor_value",
        unit: "sensor_unit",
        snr: "signal_to_noise_ratio",
        lat: "deploy_latitude",
        lon: "deploy_longitude",
        ..NOTHING
    },
    Maker {
        known_by: &["datecollectedutc", "receiver", "tagname"],
        time: "datecollectedutc",
        tag: "tagname",
        data: "sensorraw",
        lat: "decimallatitude",
        lon: "decimallongitude",
        ..NOTHING
    },
    Maker {
        known_by: &["datecollected", "receiver", "tagname"],
        zone: "timezone",
        time: "datecollected",
        tag: "tagname",
        data: "sensorraw",
        lat: "latitude",
        lon: "longitude",
        ..NOTHING
    },
];

impl Maker {
    /// The detection of a row; `None` for a release.
    pub(super) fn detection(
        &self,
        row: &Row<'_>,
        carriers: &Carriers<'_>,
    ) -> Result<Option<Detection>, Wrong> {
        let named = needed(row, self.receiver)?;
        if named.eq_ignore_ascii_case(RELEASE) {
            return Ok(None);
        }
        let receiver = self.serial(named)?;
        let maker = self.maker(row, named);
        let time = self.time(row)?;
        let (protocol, frequency_khz, tag_id) = self.code(row)?;
        let clock = self.clock(time)?;
        let deployment = carriers.study.deployed(receiver, maker, time.micros());
        let system = self.system(carriers, deployment, named, time)?;
        // Of another station than the one that was named the place is not this one's.
        let station = deployment.filter(|one| one.vessel == Some(system));
        Ok(Some(Detection {
            origin: Origin { system: Address(system), entity: ENTITY, reported: time, received: None },
            receiver,
            maker,
            clock,
            protocol,
            tag_id,
            data: self.data(row)?,
            snr_db: self.snr(row)?,
            frequency_khz,
            line: 0,
            pose: self.pose(row, station)?,
            effort: Effort::default(),
            raw: Some(row.raw.to_owned()),
        }))
    }

    /// `VR2W-109924`, or the number alone.
    fn serial(&self, text: &str) -> Result<u32, Wrong> {
        text.rsplit('-').next().and_then(|digits| digits.parse().ok()).ok_or_else(|| {
            let wrong = say("`{text}` is not a receiver such as VR2W-109924 or 109924");
            (self.receiver.to_owned(), wrong.with("text", shown(text)))
        })
    }

    /// By the table, by the column of the model, or by what stands before the serial number.
    fn maker(&self, row: &Row<'_>, named: &str) -> Option<ReceiverMaker> {
        let model = row.cell(self.model).or_else(|| named.rsplit_once('-').map(|(model, _)| model));
        self.made_by.or_else(|| ReceiverMaker::of(model?))
    }

    fn time(&self, row: &Row<'_>) -> Result<UtcTime, Wrong> {
        let Some(written) = row.time(self.time)? else { return Err(empty(self.time)) };
        if let Some(zone) = row.cell(self.zone)
            && !["UTC", "GMT", "Z"].iter().any(|utc| zone.eq_ignore_ascii_case(utc))
        {
            let wrong = say("`{zone}` is not UTC; export the file with times in UTC");
            return Err((self.zone.to_owned(), wrong.with("zone", shown(zone))));
        }
        let correction_s = row.real(self.correction)?.unwrap_or_default();
        let corrected = UtcTime::from_micros(written.micros() + (correction_s * 1e6).round() as i64);
        let Some(unix_s) = row.real(self.unix)? else { return Ok(corrected) };
        let millis: u16 = row.whole(self.millis)?.unwrap_or_default();
        let unix_us = (unix_s * 1e6).round() as i64 + i64::from(millis) * 1_000;
        let off_us = written.micros() - unix_us;
        if off_us.abs() >= 1_000_000 {
            let wrong = say(
                "is {off_s} s off the Unix time beside it, which another time zone or a spreadsheet does; take the file as the receiver's program wrote it",
            );
            return Err((self.time.to_owned(), wrong.with("off_s", off_us / 1_000_000)));
        }
        // Whole seconds beside a date with decimals say less than that.
        Ok(if unix_us % 1_000_000 == 0 { written } else { UtcTime::from_micros(unix_us) })
    }

    /// Microseconds stay in the time of the report.
    fn clock(&self, time: UtcTime) -> Result<ReceiverClock, Wrong> {
        let (seconds, rest_us) = (time.micros().div_euclid(1_000_000), time.micros().rem_euclid(1_000_000));
        let seconds = u32::try_from(seconds).ok().filter(|seconds| *seconds >= SET_AFTER_S);
        let millis = u16::try_from(rest_us / 1_000).unwrap_or_default();
        seconds.map(|seconds| ReceiverClock::read(seconds, millis)).ok_or_else(|| {
            let wrong = say("`{time}` is not within 2001-09-09 to 2106: the receiver's clock was not set, or a column is shifted");
            (self.time.to_owned(), wrong.with("time", time))
        })
    }

    /// Protocol, carrier (kHz) where it is named, and number.
    fn code(&self, row: &Row<'_>) -> Result<(Protocol, Option<u8>, u32), Wrong> {
        let text = needed(row, self.tag)?;
        let wrong = || {
            let wrong = say(
                "`{text}` is not a tag such as A69-1303-63366, R64K-1234, or a number beside its protocol",
            );
            (self.tag.to_owned(), wrong.with("text", shown(text)))
        };
        if self.protocol.is_empty() {
            let (space, id) = text.rsplit_once('-').ok_or_else(wrong)?;
            let carrier = space.strip_prefix('A').and_then(|rest| rest.split_once('-'));
            let khz = carrier.and_then(|(khz, _)| khz.parse().ok());
            return Ok((Protocol::named(space), khz, id.parse().map_err(|_| wrong())?));
        }
        let id = text.parse().map_err(|_| wrong())?;
        // `R64K-69kHz`
        let coded = needed(row, self.protocol)?;
        let parts = coded.rsplit_once('-').and_then(|(name, carrier)| {
            Some((name, carrier.strip_suffix("kHz").or(carrier.strip_suffix("khz"))?.trim().parse().ok()?))
        });
        let (name, khz) = parts.map_or((coded, None), |(name, khz)| (name, Some(khz)));
        Ok((Protocol::named(name), khz, id))
    }

    /// The count of the tag's sensor. What the maker's program has converted stays in the line alone.
    fn data(&self, row: &Row<'_>) -> Result<Option<u16>, Wrong> {
        let is_count = row.cell(self.unit).is_none_or(|unit| unit.eq_ignore_ascii_case(COUNT));
        if !is_count {
            row.real(self.data)?;
            return Ok(None);
        }
        row.whole(self.data)
    }

    /// What is not a whole number of 1 to 255 dB, as a signal below the noise, stays in the line alone.
    fn snr(&self, row: &Row<'_>) -> Result<Option<u8>, Wrong> {
        let ratio = match row.real(self.snr)? {
            Some(snr) => snr,
            None => match row.real(self.signal)?.zip(row.real(self.noise)?) {
                Some((signal, noise)) => signal - noise,
                None => return Ok(None),
            },
        };
        if !(0.0..=255.0).contains(&ratio) && !self.snr.is_empty() {
            let wrong = say("{snr} dB is not within 0 to 255; look for a shifted column");
            return Err((self.snr.to_owned(), wrong.with("snr", ratio)));
        }
        let rounded = ratio.round();
        Ok((1.0..=255.0).contains(&rounded).then_some(rounded as u8))
    }

    /// The place of the file, else that of the fixed station.
    fn pose(&self, row: &Row<'_>, station: Option<&RegisterDeployment>) -> Result<Option<Pose>, Wrong> {
        // Programs write 0, 0 where a station has no place; no receiver hangs there.
        let is_place = |place: &(f64, f64)| place.0 != 0.0 || place.1 != 0.0;
        let of_file = both(row, self.lat, self.lon)?.filter(is_place);
        let of_station = || station.and_then(|one| one.lat_deg.zip(one.lon_deg));
        let Some((lat_deg, lon_deg)) = of_file.or_else(of_station) else { return Ok(None) };
        let place = place(lat_deg, lon_deg).map_err(|text| (self.lat.to_owned(), text))?;
        Ok(Some(Pose { place, age_s: None, sigma_m: None }))
    }

    fn system(
        &self,
        carriers: &Carriers<'_>,
        deployment: Option<&RegisterDeployment>,
        receiver: &str,
        time: UtcTime,
    ) -> Result<u16, Wrong> {
        carriers.system.or_else(|| deployment.and_then(|one| one.vessel)).ok_or_else(|| {
            let wrong = say("the register does not say where the receiver {receiver} was at {time}: add its deployment on a vessel or a fixed station, or name the vessel that all of the file is of");
            (self.receiver.to_owned(), wrong.with("receiver", shown(receiver)).with("time", time))
        })
    }
}

fn needed<'r>(row: &Row<'r>, name: &str) -> Result<&'r str, Wrong> {
    row.cell(name).ok_or_else(|| empty(name))
}
