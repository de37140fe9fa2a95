//! A whole detection as an IMC Event (660), and any packet as a detection.

use crate::detection::{ClockState, Detection, Effort, Noise, Origin, Pose, ReceiverClock};
use crate::list::{List, number};
use crate::maker::Maker;
use crate::protocol::Protocol;
use imc::messages::{Event, Payload as _, TBRFishTag};
use imc::{PacketView, tuples};
use std::borrow::Cow;
use std::fmt::Write as _;
use units::{LatLon, UtcTime};

/// The topic of an Event that is a detection.
pub const TOPIC: &str = "AcousticDetection";

/// Whether a packet reports a detection.
pub fn is_report(view: &PacketView<'_>) -> bool {
    view.id() == TBRFishTag::ID
        || (view.id() == Event::ID
            && imc::decode::<Event>(view).is_ok_and(|event| event.is_some_and(|event| event.topic == TOPIC)))
}

impl Detection {
    /// The detection in a packet that came ashore at `received`; `None` when it is damaged or of another kind. A packet
    /// without a time of its own is taken to be sent when it came.
    pub fn from_packet(view: &PacketView<'_>, received: UtcTime) -> Option<Self> {
        let origin = Origin {
            system: view.src(),
            entity: view.src_ent(),
            reported: view.header().time().unwrap_or(received),
            received: Some(received),
        };
        if let Ok(Some(tag)) = imc::decode::<TBRFishTag>(view) {
            return Some(Self::from_fish_tag(origin, &tag));
        }
        Self::from_report(origin, &imc::decode::<Event>(view).ok()??)
    }

    /// All of it as an Event, a tuple list of these names:
    ///
    /// `receiver` (serial number), `maker`, `clock` (`set`, `not set`, `disciplined`, `lost`), `clock_s` and `clock_ms` (the
    /// receiver's count), `protocol` (or `protocol_number` where it has no name), `tag`, `data`, `snr_db`, `frequency_khz`,
    /// `line` (running number), `lat_deg`, `lon_deg`, `pose_age_s`, `pose_sigma_m`, `lines_lost`, `noise_average`, `noise_peak`,
    /// `noise_age_s`, `propeller_rpm`, `raw`. Unknown values are left out, but for `snr_db` and `frequency_khz`, which are 0
    /// then: earlier versions need them, and wrote 0 where a receiver says no ratio. In `protocol` and `raw`, `%`, `;` and bytes
    /// outside printable ASCII are written as `%` and two hexadecimal digits.
    pub fn report(&self) -> Event {
        let mut list = List::default();
        list.put("receiver", self.receiver);
        list.known("maker", self.maker);
        list.put("clock", self.clock.state.word());
        list.put("clock_s", self.clock.seconds);
        list.put("clock_ms", self.clock.millis);
        list.known("protocol", self.protocol.name().map(escaped));
        if self.protocol.name().is_none() {
            list.known("protocol_number", self.protocol.number());
        }
        list.put("tag", self.tag_id);
        list.known("data", self.data);
        list.put("snr_db", self.snr_db.unwrap_or(0));
        list.put("frequency_khz", self.frequency_khz.unwrap_or(0));
        list.put("line", self.line);
        if let Some(Pose { place, age_s, sigma_m }) = self.pose {
            list.put("lat_deg", format_args!("{:.9}", place.lat_deg()));
            list.put("lon_deg", format_args!("{:.9}", place.lon_deg()));
            list.known("pose_age_s", age_s.map(|age_s| format!("{age_s:.3}")));
            list.known("pose_sigma_m", sigma_m.map(|sigma_m| format!("{sigma_m:.2}")));
        }
        list.known("lines_lost", self.effort.lines_lost);
        if let Some(Noise { average, peak, age_s }) = self.effort.noise {
            list.put("noise_average", average);
            list.put("noise_peak", peak);
            list.put("noise_age_s", format_args!("{age_s:.3}"));
        }
        list.known("propeller_rpm", self.effort.propeller_rpm.map(|rpm| format!("{rpm:.0}")));
        list.known("raw", self.raw.as_deref().map(escaped));
        Event { topic: TOPIC.into(), data: list.0.into() }
    }

    /// The detection in an Event; `None` when its topic is another, or when it lacks what every detection has.
    pub fn from_report(origin: Origin, event: &Event) -> Option<Self> {
        if event.topic != TOPIC {
            return None;
        }
        let list = event.data.to_str_lossy();
        let mut clock = ReceiverClock::read(number(&list, "clock_s")?, number(&list, "clock_ms")?);
        // An unknown word leaves the state that follows from the stamp.
        if let Some(told) = tuples::get(&list, "clock").and_then(ClockState::of_word) {
            clock.state = clock.state.with(told);
        }
        Some(Self {
            origin,
            receiver: number(&list, "receiver")?,
            maker: tuples::get(&list, "maker").and_then(Maker::of_word),
            clock,
            protocol: protocol(&list)?,
            tag_id: number(&list, "tag")?,
            data: number(&list, "data"),
            snr_db: number(&list, "snr_db").filter(|snr_db| *snr_db != 0),
            frequency_khz: number(&list, "frequency_khz").filter(|khz| *khz != 0),
            line: number(&list, "line")?,
            pose: pose(&list),
            effort: Effort {
                lines_lost: number(&list, "lines_lost"),
                noise: noise(&list),
                propeller_rpm: not_negative(&list, "propeller_rpm"),
            },
            raw: tuples::get(&list, "raw").map(plain),
        })
    }
}

fn not_negative(list: &str, name: &str) -> Option<f64> {
    tuples::number(list, name).filter(|value| *value >= 0.0)
}

fn protocol(list: &str) -> Option<Protocol> {
    let named = tuples::get(list, "protocol").map(|name| Protocol::named(&plain(name)));
    named.or_else(|| number(list, "protocol_number").map(Protocol::numbered))
}

fn pose(list: &str) -> Option<Pose> {
    let (lat_deg, lon_deg) = (tuples::number(list, "lat_deg")?, tuples::number(list, "lon_deg")?);
    let place = LatLon::from_deg(lat_deg, lon_deg).ok()?;
    let (age_s, sigma_m) = (not_negative(list, "pose_age_s"), not_negative(list, "pose_sigma_m"));
    Some(Pose { place, age_s, sigma_m })
}

fn noise(list: &str) -> Option<Noise> {
    let age_s = not_negative(list, "noise_age_s")?;
    Some(Noise { average: number(list, "noise_average")?, peak: number(list, "noise_peak")?, age_s })
}

/// A text without what would end it in a tuple list.
fn escaped(text: &str) -> Cow<'_, str> {
    let stays = |byte: u8| byte.is_ascii_graphic() && !matches!(byte, b';' | b'%') || byte == b' ';
    // Blanks at the ends would be trimmed.
    if text.bytes().all(stays) && text.trim() == text {
        return text.into();
    }
    let mut safe = String::with_capacity(text.len() + 8);
    for byte in text.bytes() {
        if stays(byte) && byte != b' ' {
            safe.push(char::from(byte));
        } else {
            write!(safe, "%{byte:02X}").ok();
        }
    }
    safe.into()
}

/// The text before it was escaped. A `%` without two hexadecimal digits stays.
fn plain(safe: &str) -> String {
    let bytes = safe.as_bytes();
    let mut text = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while let Some(byte) = bytes.get(at) {
        let digits = bytes
            .get(at + 1..at + 3)
            .filter(|digits| *byte == b'%' && digits.iter().all(u8::is_ascii_hexdigit));
        let escape = digits.and_then(|digits| std::str::from_utf8(digits).ok());
        let value = escape.and_then(|digits| u8::from_str_radix(digits, 16).ok());
        text.push(value.unwrap_or(*byte));
        at += if value.is_some() { 3 } else { 1 };
    }
    String::from_utf8_lossy(&text).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fused;
    use imc::{Address, Header, Packet};
    use proptest::option;
    use proptest::prelude::*;

    const RECEIVED: UtcTime = UtcTime::from_micros(1_795_248_010_000_000);

    fn packet(detection: &Detection, message: impl Into<imc::Message>) -> Vec<u8> {
        let Origin { system, entity, reported, .. } = detection.origin;
        let header =
            Header { timestamp: reported.seconds(), src: system, src_ent: entity, ..Header::default() };
        Packet::new(header, message).encode().unwrap()
    }

    fn read(bytes: &[u8]) -> Option<Detection> {
        let view = PacketView::new(bytes).unwrap();
        let read = Detection::from_packet(&view, RECEIVED);
        assert!(is_report(&view) || read.is_none());
        read
    }

    /// Numbers as they are written, so that what comes back is equal.
    fn hundredths(most: i32) -> impl Strategy<Value = f64> {
        (0..most).prop_map(|it| format!("{:.2}", f64::from(it) / 100.0).parse().unwrap())
    }

    fn pose() -> impl Strategy<Value = Pose> {
        let degree = |most: i64| (-most * 1_000_000..most * 1_000_000).prop_map(|it| it as f64 / 1e6);
        (degree(90), degree(180), option::of(hundredths(10_000)), option::of(hundredths(10_000))).prop_map(
            |(lat_deg, lon_deg, age_s, sigma_m)| {
                let place = LatLon::from_deg(lat_deg, lon_deg).unwrap();
                Pose { place, age_s, sigma_m }
            },
        )
    }

    fn effort() -> impl Strategy<Value = Effort> {
        let noise = (any::<u8>(), any::<u8>(), hundredths(100_000));
        let noise = noise.prop_map(|(average, peak, age_s)| Noise { average, peak, age_s });
        (option::of(any::<u16>()), option::of(noise), option::of(0..3_000_u16)).prop_map(
            |(lines_lost, noise, rpm)| Effort { lines_lost, noise, propeller_rpm: rpm.map(f64::from) },
        )
    }

    fn protocols() -> impl Strategy<Value = Protocol> {
        prop_oneof![
            (0..12_u8).prop_map(Protocol::numbered),
            "\\PC{0,12}".prop_map(|name| Protocol::named(&name)),
            Just(Protocol::named("OPi")),
        ]
    }

    fn detections() -> impl Strategy<Value = Detection> {
        let origin = (any::<u16>(), any::<u8>(), 1_700_000_000_000_000..1_800_000_000_000_000_i64);
        let told = prop_oneof![
            Just(ClockState::NotSet),
            Just(ClockState::Lost),
            Just(ClockState::Set),
            Just(ClockState::Disciplined)
        ];
        let clock = (any::<u32>(), 0..1_000_u16, told);
        let tag = (protocols(), any::<u32>(), option::of(any::<u16>()));
        let maker = prop_oneof![Just(None), Just(Some(Maker::Thelma)), Just(Some(Maker::Innovasea))];
        let known = || option::of(1..=u8::MAX);
        let signal = ((any::<u32>(), maker), known(), known(), any::<u16>());
        let rest = (option::of(pose()), effort(), option::of("\\PC{0,40}"));
        (origin, clock, tag, signal, rest).prop_map(
            |((system, entity, us), (seconds, millis, told), (protocol, tag_id, data), signal, rest)| {
                let mut clock = ReceiverClock::read(seconds, millis);
                clock.state = clock.state.with(told);
                let (((receiver, maker), snr_db, frequency_khz, line), (pose, effort, raw)) = (signal, rest);
                let reported = UtcTime::from_micros(us);
                let (system, received) = (Address(system), Some(RECEIVED));
                let origin = Origin { system, entity, reported, received };
                Detection {
                    origin,
                    receiver,
                    maker,
                    clock,
                    protocol,
                    tag_id,
                    data,
                    snr_db,
                    frequency_khz,
                    line,
                    pose,
                    effort,
                    raw,
                }
            },
        )
    }

    /// The same but for what a decimal of a degree rounds off (1e-9 degrees are 0.1 mm).
    fn same(one: &Detection, other: &Detection) -> bool {
        let place = |one: &Detection| one.pose.map(|pose| pose.place);
        let near = match (place(one), place(other)) {
            (Some(a), Some(b)) => {
                (a.lat_deg() - b.lat_deg()).abs() < 1e-9 && (a.lon_deg() - b.lon_deg()).abs() < 1e-9
            }
            (a, b) => a == b,
        };
        let mut moved = other.clone();
        if let (Some(moved), Some(place)) = (&mut moved.pose, place(one)) {
            moved.place = place;
        }
        near && *one == moved
    }

    proptest! {
        #[test]
        fn a_report_tells_the_whole_detection(detection in detections()) {
            let told = read(&packet(&detection, detection.report())).unwrap();
            prop_assert!(same(&told, &detection), "{told:?}\n{detection:?}");
            prop_assert_eq!(told.id(), detection.id());
        }

        #[test]
        fn both_messages_are_one_detection_in_either_order(detection in detections()) {
            let whole = read(&packet(&detection, detection.report())).unwrap();
            let Some(tag) = detection.fish_tag() else {
                let is_ours = detection.maker.is_none();
                prop_assert!(!is_ours || detection.clock.utc().is_none() || detection.protocol.number().is_none());
                return Ok(());
            };
            let brief = read(&packet(&detection, tag)).unwrap();
            prop_assert!(brief.is_same(&whole));
            prop_assert_eq!(brief.id(), whole.id());
            prop_assert_eq!(brief.raw.clone(), None);
            for reports in [vec![brief.clone(), whole.clone()], vec![whole.clone(), brief.clone(), whole.clone()]] {
                let one = fused(reports);
                prop_assert_eq!(one.len(), 1);
                prop_assert_eq!(&one[0].raw, &whole.raw);
                prop_assert_eq!(one[0].effort, whole.effort);
                prop_assert_eq!(one[0].clock, whole.clock);
                let told = |one: &Detection| one.pose.map(|pose| (pose.age_s, pose.sigma_m));
                prop_assert_eq!(told(&one[0]).unwrap_or_default(), told(&whole).unwrap_or_default());
            }
        }

        #[test]
        fn no_text_is_more_than_a_detection_or_nothing(data in "(\\PC|[;=%.0-9-]){0,200}") {
            let names = ["receiver", "clock_s", "clock_ms", "protocol", "tag", "snr_db", "frequency_khz", "line"];
            let complete: String = names.map(|name| format!(";{name}=1")).concat();
            for data in [data.clone(), format!("{data}{complete}")] {
                let event = Event { topic: TOPIC.into(), data: data.as_str().into() };
                let bytes = Packet::new(Header::default(), event).encode().unwrap();
                if let Some(told) = read(&bytes) {
                    let again = read(&packet(&told, told.report())).unwrap();
                    prop_assert_eq!(again.report(), told.report());
                }
            }
        }
    }

    #[test]
    fn other_events_and_broken_packets_are_no_detections() {
        let event = |topic: &str, data: &str| Event { topic: topic.into(), data: data.into() };
        for message in [event("Dive", "receiver=1"), event(TOPIC, ""), event(TOPIC, "receiver=1;clock_s=2")] {
            let bytes = Packet::new(Header::default(), message).encode().unwrap();
            assert_eq!(read(&bytes), None);
        }
        let temperature = Packet::new(Header::default(), imc::messages::Temperature { value: 4.0 });
        assert_eq!(read(&temperature.encode().unwrap()), None);
        let damaged = Packet {
            body: imc::Body::Unknown { id: TBRFishTag::ID, payload: vec![1; 13] },
            ..Packet::new(Header::default(), imc::messages::Heartbeat)
        };
        assert_eq!(read(&damaged.encode().unwrap()), None);
    }

    #[test]
    fn what_a_word_of_a_list_cannot_hold_is_escaped() {
        for (text, written) in [
            ("$001129,1551087572,897,OPs,15,32,33,69", "$001129,1551087572,897,OPs,15,32,33,69"),
            ("a;b=c%41", "a%3Bb=c%2541"),
            (" æ", "%20%C3%A6"),
        ] {
            assert_eq!(escaped(text), written);
            assert_eq!(plain(written), text);
        }
        assert_eq!(plain("50%, 5%z"), "50%, 5%z");
    }
}
