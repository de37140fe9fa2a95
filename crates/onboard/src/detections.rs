//! Detections of tagged fish, with the place the vessel was at when it heard them.
//!
//! The place is interpolated between the vessel's own places of the last seconds, at the time of the detection
//! less the length of a tag's transmission. A receiver whose clock was never set counts seconds since
//! power-up: such detections have no time and are told to the console only (facts/onboard.md 2.3).

use crate::bus::Bus;
use crate::entity::Entity;
use crate::input::{TagReading, WaterReading};
use crate::output::Level;
use crate::states::{Condition, States};
use imc::messages::{TBRFishTag, TBRFishTagTransProtocol, TBRSensor, Temperature};
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

/// The last places, and the count of lines.
#[derive(Debug, Clone, Default)]
pub(crate) struct Detections {
    places: VecDeque<(UtcTime, LatLon)>,
    last_counter: Option<u16>,
    lost_lines: u64,
    heard: u64,
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
        if tag.clock_s < SET_AFTER_S {
            states.set(bus, Entity::Hydrophone, Condition::Fault, "the receiver's clock is not set");
            let text = format!("tag {} {} heard without a time", tag.protocol, tag.tag_id);
            bus.entry(Entity::Hydrophone, Level::Warning, text);
            return;
        }
        self.heard += 1;
        let us = i64::from(tag.clock_s) * 1_000_000 + i64::from(tag.millis) * 1_000;
        let place = self.place_at(UtcTime::from_micros(us - TRANSMISSION_US));
        let message = TBRFishTag {
            serial_no: tag.serial,
            unix_timestamp: tag.clock_s,
            millis: tag.millis,
            trans_protocol: protocol(&tag.protocol),
            trans_id: tag.tag_id,
            trans_data: tag.data.unwrap_or(0),
            snr: tag.snr_db,
            trans_freq: tag.frequency_khz,
            recv_mem_addr: tag.counter,
            lat: place.map(LatLon::lat_rad),
            lon: place.map(LatLon::lon_rad),
        };
        bus.send(Entity::Hydrophone, &message);
        states.set(bus, Entity::Hydrophone, Condition::Normal, self.text());
    }

    pub(crate) fn water(&mut self, bus: &mut Bus, states: &mut States, water: &WaterReading) {
        self.count(bus, water.counter);
        let temperature = if water.temperature_c.is_finite() { water.temperature_c as f32 } else { return };
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
        bus.send(Entity::Hydrophone, &Temperature { value: temperature });
        states.set(bus, Entity::Hydrophone, Condition::Normal, self.text());
    }

    fn text(&self) -> String {
        format!("{} detections, {} lines lost", self.heard, self.lost_lines)
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

fn protocol(name: &str) -> TBRFishTagTransProtocol {
    match name {
        "R256" => TBRFishTagTransProtocol::R256,
        "R04K" => TBRFishTagTransProtocol::R04K,
        "S64K" => TBRFishTagTransProtocol::S64K,
        "R64K" => TBRFishTagTransProtocol::R64K,
        "R01M" => TBRFishTagTransProtocol::R01M,
        "S256" => TBRFishTagTransProtocol::S256,
        "HS256" => TBRFishTagTransProtocol::Hs256,
        "DS256" => TBRFishTagTransProtocol::Ds256,
        _ => TBRFishTagTransProtocol::Unlisted(0),
    }
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
