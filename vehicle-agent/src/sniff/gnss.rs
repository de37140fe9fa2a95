//! A GNSS compass: one line for each epoch.

use super::{Decoder, Found};
use crate::clock::Clock;
use devices::nmea::{DamagedSentence, Epoch, Epochs, Framer, Report};
use serde_json::{Map, Value, json};
use units::UtcTime;

/// Reads NMEA sentences.
#[derive(Debug)]
pub(crate) struct Gnss {
    framer: Framer,
    gathering: Gathering,
}

#[derive(Debug)]
struct Gathering {
    epochs: Epochs,
    /// The clock for times of arrival, for a port.
    arrivals: Option<Clock>,
    /// When the first sentence of the current epoch arrived.
    begun: Option<UtcTime>,
}

impl Gnss {
    /// Epochs are stamped with their time of arrival if there is a clock, else with their own time.
    pub(crate) fn new(arrivals: Option<Clock>) -> Self {
        let gathering = Gathering { epochs: Epochs::default(), arrivals, begun: None };
        Self { framer: Framer::default(), gathering }
    }
}

impl Decoder for Gnss {
    fn feed(&mut self, bytes: &[u8], found: &mut Vec<Found>) {
        self.framer.feed(bytes, |offset, read| self.gathering.take(offset, read, found));
    }

    fn end(&mut self, found: &mut Vec<Found>) {
        self.framer.end(|offset, read| self.gathering.take(offset, read, found));
        if let Some(epoch) = self.gathering.epochs.close() {
            found.push(shown(&epoch, self.gathering.begun));
        }
    }
}

impl Gathering {
    fn take(&mut self, offset: u64, read: Result<Report, DamagedSentence>, found: &mut Vec<Found>) {
        match read {
            Ok(report) => {
                let over = self.epochs.take(&report);
                found.extend(over.map(|epoch| shown(&epoch, self.begun)));
                if self.epochs.kinds().len() == 1 {
                    self.begun = self.arrivals.as_ref().map(Clock::utc);
                }
            }
            Err(error) => found.push(Found::damaged(&error, offset)),
        }
    }
}

fn shown(epoch: &Epoch, arrival: Option<UtcTime>) -> Found {
    let at = arrival.or(epoch.carried_utc);
    let degrees = epoch.lat_lon_rad.map(|(lat, lon)| (lat.to_degrees(), lon.to_degrees()));
    let fields = [
        ("t", at.map(|time| json!(time.to_string()))),
        ("lat_deg", degrees.map(|(lat_deg, _)| json!(lat_deg))),
        ("lon_deg", degrees.map(|(_, lon_deg)| json!(lon_deg))),
        ("quality", epoch.quality.map(|quality| json!(quality))),
        ("sats", epoch.satellites.map(|count| json!(count))),
        ("hdop", epoch.hdop.map(|hdop| json!(hdop))),
        ("cog_rad", epoch.course_rad.map(|course| json!(course))),
        ("sog_mps", epoch.speed_mps.map(|speed| json!(speed))),
        ("heading_rad", epoch.heading_rad.map(|heading| json!(heading))),
        ("rot_rad_s", epoch.yaw_rate_rad_s.map(|rate| json!(rate))),
        ("utc", epoch.utc.map(|utc| json!(utc.to_string()))),
    ];
    let object: Map<String, Value> =
        fields.into_iter().filter_map(|(key, value)| Some((key.to_owned(), value?))).collect();
    Found { json: object.into(), text: words(epoch, at) }
}

fn words(epoch: &Epoch, at: Option<UtcTime>) -> String {
    let mut words = vec![at.map_or_else(|| "time not reported".to_owned(), |time| time.to_string())];
    words.push(match epoch.lat_lon_rad {
        Some((lat, lon)) => format!("{:.7}° {:.7}°", lat.to_degrees(), lon.to_degrees()),
        None => "no position".to_owned(),
    });
    let quality = match epoch.quality {
        None => "quality not reported",
        Some(0) => "no fix",
        Some(1 | 9) => "autonomous",
        Some(2) => "differential",
        Some(3) => "precise",
        Some(4) => "RTK fixed",
        Some(5) => "RTK float",
        Some(6) => "estimated",
        Some(7) => "entered by hand",
        Some(_) => "simulated",
    };
    words.push(quality.to_owned());
    words.extend(epoch.satellites.map(|count| format!("{count} satellites")));
    words.extend(epoch.hdop.map(|hdop| format!("HDOP {hdop:.1}")));
    let degrees = |name: &str, angle_rad: f64| format!("{name} {:.1}°", angle_rad.to_degrees());
    words.extend(epoch.course_rad.map(|course_rad| degrees("course", course_rad)));
    words.extend(epoch.speed_mps.map(|speed_mps| format!("{speed_mps:.2} m/s")));
    words.extend(epoch.heading_rad.map(|heading_rad| degrees("heading", heading_rad)));
    words.extend(epoch.yaw_rate_rad_s.map(|rate| format!("turning {:.1}°/s", rate.to_degrees())));
    words.join(", ")
}
