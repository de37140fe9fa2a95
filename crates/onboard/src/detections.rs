//! Detections of tagged fish, with the place the vessel was at when it heard them.
//!
//! The place is interpolated between the vessel's own places of the last seconds, at the time of the detection
//! less the length of a tag's transmission. A receiver whose clock was never set counts seconds since
//! power-up: what it hears is kept as DevDataText, marked as without a time, so that nobody takes
//! seconds since power-up for those since 1970. So is a coding that IMC has no number for: its name stays.

use crate::bus::Bus;
use crate::entity::Entity;
use crate::output::Level;
use crate::states::{Condition, States};
use devices::{TagReading, WaterReading};
use imc::messages::{DevDataText, TBRFishTag, TBRFishTagTransProtocol, TBRSensor, Temperature};
use std::collections::VecDeque;
use units::{LatLon, UtcTime};

/// Places kept (µs).
const KEPT_US: i64 = 30_000_000;
/// A detection this much outside the places kept has no place (µs).
const SLACK_US: i64 = 2_000_000;
/// Receiver clocks below this were never set (s; September 2001).
const SET_AFTER_S: u32 = 1_000_000_000;
/// Length of a transmission (µs), "Transmission Time".
const TRANSMISSION_US: i64 = 3_000_000;
/// Longest word of a device that is repeated (characters).
const LONGEST_WORD: usize = 24;

/// The last places, and the count of lines.
#[derive(Debug, Clone, Default)]
pub(crate) struct Detections {
    places: VecDeque<(UtcTime, LatLon)>,
    last_counter: Option<u16>,
    lost_lines: u64,
    heard: u64,
    /// The receiver's clock is not set.
    unset: bool,
    /// Lines kept as text.
    as_text: u64,
}

impl Detections {
    /// Where the vessel is.
    pub(crate) fn at(&mut self, utc: UtcTime, place: LatLon) {
        if self.places.back().is_some_and(|(last, _)| utc <= *last) {
            // The clock was set back: what is kept has the old time.
            self.places.clear();
        }
        self.places.push_back((utc, place));
        while self.places.front().is_some_and(|(first, _)| utc - *first > KEPT_US) {
            self.places.pop_front();
        }
    }

    fn place_at(&self, utc: UtcTime) -> Option<LatLon> {
        let after = self.places.partition_point(|(time, _)| *time <= utc);
        let (before, next) = (after.checked_sub(1).and_then(|i| self.places.get(i)), self.places.get(after));
        match (before, next) {
            (Some((t0, p0)), Some((t1, p1))) => {
                let share = (utc - *t0) as f64 / (*t1 - *t0).max(1) as f64;
                let between = |a: f64, b: f64| a + share * (b - a);
                LatLon::from_rad(
                    between(p0.lat_rad(), p1.lat_rad()),
                    p0.lon_rad() + share * units::wrap_pi(p1.lon_rad() - p0.lon_rad()),
                )
                .ok()
            }
            (Some((time, place)), None) | (None, Some((time, place))) => {
                ((utc - *time).abs() <= SLACK_US).then_some(*place)
            }
            (None, None) => None,
        }
    }

    pub(crate) fn tag(&mut self, bus: &mut Bus, states: &mut States, tag: &TagReading) {
        self.count(bus, tag.counter);
        let is_set = self.clock(bus, tag.clock_s);
        let known = protocol(&tag.protocol);
        let (Some(trans_protocol), true) = (known, is_set) else {
            self.keep_as_text(bus, &tag_text(tag, is_set));
            states.set(bus, Entity::Hydrophone, self.condition(), self.text());
            return;
        };
        self.heard += 1;
        let us = i64::from(tag.clock_s) * 1_000_000 + i64::from(tag.millis) * 1_000;
        let place = self.place_at(UtcTime::from_micros(us - TRANSMISSION_US));
        let message = TBRFishTag {
            serial_no: tag.serial,
            unix_timestamp: tag.clock_s,
            millis: tag.millis,
            trans_protocol,
            trans_id: tag.tag_id,
            trans_data: tag.data.unwrap_or(0),
            snr: tag.snr_db,
            trans_freq: tag.frequency_khz,
            recv_mem_addr: tag.counter,
            lat: place.map(LatLon::lat_rad),
            lon: place.map(LatLon::lon_rad),
        };
        bus.send(Entity::Hydrophone, &message);
        states.set(bus, Entity::Hydrophone, self.condition(), self.text());
    }

    pub(crate) fn water(&mut self, bus: &mut Bus, states: &mut States, water: &WaterReading) {
        self.count(bus, water.counter);
        let temperature = if water.temperature_c.is_finite() { water.temperature_c as f32 } else { return };
        bus.send(Entity::Hydrophone, &Temperature { value: temperature });
        if !self.clock(bus, water.clock_s) {
            self.keep_as_text(bus, &water_text(water));
            states.set(bus, Entity::Hydrophone, self.condition(), self.text());
            return;
        }
        let message = TBRSensor {
            serial_no: water.serial,
            unix_timestamp: water.clock_s,
            temperature,
            avg_noise_level: water.noise_average,
            peak_noise_level: water.noise_peak,
            recv_listen_freq: water.frequency_khz,
            recv_mem_addr: water.counter,
        };
        bus.send(Entity::Hydrophone, &message);
        states.set(bus, Entity::Hydrophone, self.condition(), self.text());
    }

    /// Whether the receiver's clock is set; tells when that changes.
    fn clock(&mut self, bus: &mut Bus, clock_s: u32) -> bool {
        let is_set = clock_s >= SET_AFTER_S;
        if is_set == self.unset {
            self.unset = !is_set;
            let (level, text) = if is_set {
                (Level::Info, "the receiver's clock is set: detections have a time again")
            } else {
                (
                    Level::Warning,
                    "the receiver's clock is not set: what it hears is kept as text, without a time",
                )
            };
            bus.entry(Entity::Hydrophone, level, text);
        }
        is_set
    }

    /// What would be taken for something that it is not, were it a message of its own.
    fn keep_as_text(&mut self, bus: &mut Bus, text: &str) {
        self.as_text += 1;
        let place = self.place_at(bus.utc()).map_or_else(String::new, |place| {
            format!(";lat_deg={:.6};lon_deg={:.6}", place.lat_deg(), place.lon_deg())
        });
        let arrived = bus.utc();
        let value = format!("{text};arrived_by_vessel_clock={arrived}{place}");
        bus.send(Entity::Hydrophone, &DevDataText { value: value.as_str().into() });
    }

    fn condition(&self) -> Condition {
        if self.unset { Condition::Fault } else { Condition::Normal }
    }

    fn text(&self) -> String {
        let as_text = match self.as_text {
            0 => String::new(),
            lines => format!(", {lines} lines kept as text"),
        };
        let clock = if self.unset { "; the receiver's clock is not set" } else { "" };
        format!("{} detections, {} lines lost{as_text}{clock}", self.heard, self.lost_lines)
    }

    /// Lines are numbered; a gap is lost lines.
    fn count(&mut self, bus: &mut Bus, counter: u16) {
        if let Some(last) = self.last_counter {
            let missing = counter.wrapping_sub(last).wrapping_sub(1);
            // A larger step is a receiver that started anew.
            if (1..1000).contains(&missing) {
                self.lost_lines += u64::from(missing);
                bus.entry(
                    Entity::Hydrophone,
                    Level::Warning,
                    format!("{missing} lines of the receiver lost"),
                );
            }
        }
        self.last_counter = Some(counter);
    }
}

/// A detection as tuples, the receiver's clock being marked as what it is.
fn tag_text(tag: &TagReading, is_set: bool) -> String {
    let TagReading { serial, clock_s, millis, tag_id, snr_db, frequency_khz, counter, .. } = tag;
    let clock = if is_set { "unix_s" } else { "clock=not set;since_power_up_s" };
    let data = tag.data.map_or_else(String::new, |data| format!(";data={data}"));
    let protocol = plain(&tag.protocol);
    format!(
        "{clock}={clock_s}.{millis:03};serial={serial};protocol={protocol};tag={tag_id}{data};snr_db={snr_db};\
         frequency_khz={frequency_khz};line={counter}"
    )
}

/// A regular report of a receiver whose clock is not set, likewise.
fn water_text(water: &WaterReading) -> String {
    let WaterReading { serial, clock_s, temperature_c, noise_average, noise_peak, frequency_khz, counter } =
        water;
    format!(
        "clock=not set;since_power_up_s={clock_s};serial={serial};temperature_c={temperature_c:.1};\
         noise_average={noise_average};noise_peak={noise_peak};frequency_khz={frequency_khz};line={counter}"
    )
}

/// A device's word without what would end it among tuples.
fn plain(word: &str) -> String {
    let keep = |c: char| if c.is_ascii_graphic() && !matches!(c, ';' | '=' | ',') { c } else { '_' };
    word.chars().take(LONGEST_WORD).map(keep).collect()
}

/// The protocols that IMC has a number for.
fn protocol(name: &str) -> Option<TBRFishTagTransProtocol> {
    Some(match name {
        "R256" => TBRFishTagTransProtocol::R256,
        "R04K" => TBRFishTagTransProtocol::R04K,
        "S64K" => TBRFishTagTransProtocol::S64K,
        "R64K" => TBRFishTagTransProtocol::R64K,
        "R01M" => TBRFishTagTransProtocol::R01M,
        "S256" => TBRFishTagTransProtocol::S256,
        "HS256" => TBRFishTagTransProtocol::Hs256,
        "DS256" => TBRFishTagTransProtocol::Ds256,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolates_between_places_and_knows_none_far_away() {
        let mut detections = Detections::default();
        let place = |lat_deg: f64| LatLon::from_deg(lat_deg, 10.0).unwrap();
        let second = |s: i64| UtcTime::from_micros(s * 1_000_000);
        detections.at(second(100), place(63.0));
        detections.at(second(102), place(63.2));
        assert!((detections.place_at(second(101)).unwrap().lat_deg() - 63.1).abs() < 1e-9);
        assert!((detections.place_at(second(103)).unwrap().lat_deg() - 63.2).abs() < 1e-9);
        assert_eq!(detections.place_at(second(110)), None);
        assert_eq!(detections.place_at(second(90)), None);
        detections.at(second(50), place(62.0));
        assert_eq!(detections.place_at(second(101)), None);
    }
}
