//! The function of each part of a vessel.
//!
//! Labels come from people: the files of a vessel may name its parts freely, in any language. The messages of a part come
//! from its program, so they count first. The label is used for a part whose messages do not show its function, such as a
//! device that was never connected.

use detections::{LISTENING_TOPIC, TOPIC as DETECTION_TOPIC};
use hub::{SeriesKey, System};
use imc::messages::{
    EstimatedState, Event, FuelLevel, GpsFix, PathControlState, Payload as _, Rpm, TBRFishTag, TBRSensor,
    Voltage,
};
use imc::{PacketView, tuples};
use std::collections::BTreeMap;

/// The topic of the Events by which a part of a Lutra vessel says in names and values what its state says in words.
const VALUES_TOPIC: &str = "EntityStateValues";

/// The functions of parts. Where two apply, the first counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum PartKind {
    /// It watches for shallow water.
    Grounding,
    /// It works out where the vessel is.
    Navigation,
    /// A motor.
    Motor,
    /// A battery, or what watches the charge.
    Battery,
    /// A receiver of fish tags.
    Hydrophone,
    /// It watches the computer's clock.
    Clock,
    /// It watches whether a console is heard.
    Console,
    /// The satellite compass.
    Compass,
    /// It keeps the vessel on its path.
    Path,
}

impl PartKind {
    /// By a message that it sends.
    fn of_message(key: SeriesKey, packet: &[u8]) -> Option<Self> {
        match key.id {
            EstimatedState::ID => Some(Self::Navigation),
            Rpm::ID => Some(Self::Motor),
            FuelLevel::ID => Some(Self::Battery),
            TBRFishTag::ID | TBRSensor::ID => Some(Self::Hydrophone),
            GpsFix::ID => Some(Self::Compass),
            PathControlState::ID => Some(Self::Path),
            Event::ID => Self::of_event(packet),
            _ => None,
        }
    }

    fn of_event(packet: &[u8]) -> Option<Self> {
        let event = imc::decode::<Event>(&PacketView::unchecked(packet).ok()?).ok()??;
        if event.topic == DETECTION_TOPIC || event.topic == LISTENING_TOPIC {
            return Some(Self::Hydrophone);
        }
        let values = event.data.to_str_lossy();
        let says = |name: &str| event.topic == VALUES_TOPIC && tuples::get(&values, name).is_some();
        let kinds = [("blocks", Self::Grounding), ("quality", Self::Clock), ("lost", Self::Console)];
        kinds.into_iter().find(|(name, _)| says(name)).map(|(_, kind)| kind)
    }

    /// By its label, as the boats' programs name their parts.
    pub(super) fn of_label(label: &str) -> Option<Self> {
        const WORDS: [(&[&str], PartKind); 9] = [
            (&["grounding"], PartKind::Grounding),
            (&["navigation"], PartKind::Navigation),
            (&["motor", "torqeedo"], PartKind::Motor),
            (&["fuel", "battery"], PartKind::Battery),
            (&["hydrophone", "tbr", "tblive"], PartKind::Hydrophone),
            (&["clock"], PartKind::Clock),
            (&["lost comm", "lostcomm"], PartKind::Console),
            (&["gps", "compass"], PartKind::Compass),
            (&["path control"], PartKind::Path),
        ];
        let label = label.to_lowercase();
        let called = |words: &[&str]| words.iter().any(|word| label.contains(word));
        WORDS.into_iter().find(|(words, _)| called(words)).map(|(_, kind)| kind)
    }

    /// Whether its trouble follows from a lost position.
    pub(super) const fn needs_position(self) -> bool {
        matches!(self, Self::Navigation | Self::Compass | Self::Path)
    }
}

/// The functions of a vessel's parts by their messages.
#[derive(Debug, Default)]
pub(super) struct SentKinds {
    /// By number: in the vessel's present life, and before it started again.
    all: BTreeMap<u8, [Option<PartKind>; 2]>,
}

impl SentKinds {
    /// From the messages since the server started.
    pub(super) fn of(system: &System) -> Self {
        let mut sent = Self::default();
        for (key, series) in system.all_series() {
            let Some(kind) = PartKind::of_message(key, series.packet()) else { continue };
            let life = usize::from(!system.is_of_this_life(series));
            let known = &mut sent.all.entry(key.entity).or_default()[life];
            *known = Some(known.map_or(kind, |known| known.min(kind)));
        }
        sent
    }

    /// A part's function by its messages and, where these do not show it, by its label. Messages from before the vessel's
    /// restart count last: its number may have been another part's.
    pub(super) fn kind(&self, entity: u8, label: &str) -> Option<PartKind> {
        let [now, before] = self.all.get(&entity).copied().unwrap_or_default();
        now.or_else(|| PartKind::of_label(label)).or(before)
    }
}

/// How well a part represents the charge of the whole vessel, the best first: one labelled "fuel", one that does not
/// measure voltage as a battery would, a battery.
pub(super) fn charge_rank(system: &System, entity: u8) -> u8 {
    let called = system.entity(entity).is_some_and(|label| label.to_lowercase().contains("fuel"));
    let battery = system.all_series().any(|(key, _)| key.entity == entity && key.id == Voltage::ID);
    match (called, battery) {
        (true, _) => 0,
        (false, false) => 1,
        (false, true) => 2,
    }
}
