//! A register by which detections are looked up.

use crate::fields::maker_of;
use crate::lag::{HORIZON_S, Lag};
use api::{
    RegisterAnimal, RegisterDeployment, RegisterPerson, RegisterProject, RegisterReceiver, RegisterRecord,
    RegisterTag,
};
use detections::{Detection, Maker};
use std::collections::BTreeMap;

/// Carrier of the code spaces of [`CODESPACES`] (kHz).
const CODED_KHZ: u8 = 69;
/// Ping intervals within which something must confirm a detection.
const PINGS: f64 = 30.0;
/// Code spaces that readers of portals know, by the protocol of receivers (as R's actel maps them).
const CODESPACES: [(&str, &str); 4] =
    [("R256", "A69-1008"), ("R04K", "A69-1206"), ("R64K", "A69-1303"), ("S256", "A69-1105")];

/// The entries of a register, to be asked.
#[derive(Debug, Clone, Default)]
pub struct Study {
    projects: BTreeMap<String, RegisterProject>,
    people: BTreeMap<String, RegisterPerson>,
    animals: BTreeMap<String, RegisterAnimal>,
    /// By protocol in capitals and number.
    tags: BTreeMap<(String, u32), Vec<RegisterTag>>,
    /// By serial number, which makers give each for themselves.
    receivers: BTreeMap<u32, Vec<RegisterReceiver>>,
    /// By name of the receiver, in small letters.
    deployments: BTreeMap<String, Vec<RegisterDeployment>>,
    /// Size of the cells to whose middles places are coarsened, m; absent where places are exact.
    cells_m: Option<u32>,
}

/// A detection with what the register knows of it.
#[derive(Debug, Clone, Copy)]
pub struct Heard<'s> {
    /// The detection.
    pub detection: &'s Detection,
    /// The vessel's name.
    pub vessel: &'s str,
    /// When: by the receiver's clock where that was set, else when the line came to the vessel (µs since 1970 UTC).
    pub time_us: i64,
    /// Whether that is by the receiver's clock.
    pub is_by_receiver: bool,
    /// The tag.
    pub tag: Option<&'s RegisterTag>,
    /// The animal that carried it.
    pub animal: Option<&'s RegisterAnimal>,
    /// The project of the tag, or of the animal.
    pub project: Option<&'s RegisterProject>,
    /// The person who leads that.
    pub principal_investigator: Option<&'s RegisterPerson>,
    /// The person who answers questions about it.
    pub contact: Option<&'s RegisterPerson>,
    /// The receiver.
    pub receiver: Option<&'s RegisterReceiver>,
    /// Its deployment on this vessel at this time.
    pub deployment: Option<&'s RegisterDeployment>,
    /// How far the nearest other detection of this tag by this receiver is; see [`crate::Lags`].
    pub lag: Lag,
    /// Size of the cell to whose middle the place is coarsened, m; absent where the place is exact.
    pub cell_m: Option<u32>,
}

/// The meaning of a tag's count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensor<'s> {
    /// The value.
    pub value: f64,
    /// Its unit; empty where the register has none.
    pub unit: &'s str,
    /// The measured quantity, likewise.
    pub kind: &'s str,
}

impl Study {
    /// Of these entries. Those that are not dated right or refer to nothing are simply not found.
    pub fn new(records: impl IntoIterator<Item = RegisterRecord>) -> Self {
        let mut study = Self::default();
        for record in records {
            match record {
                RegisterRecord::Project(one) => drop(study.projects.insert(folded(&one.name), one)),
                RegisterRecord::Person(one) => drop(study.people.insert(folded(&one.name), one)),
                RegisterRecord::Animal(one) => drop(study.animals.insert(folded(&one.name), one)),
                RegisterRecord::Tag(one) => {
                    if let Some(id) = one.tag_id.and_then(|id| u32::try_from(id).ok()) {
                        study.tags.entry((one.protocol.to_uppercase(), id)).or_default().push(one);
                    }
                }
                RegisterRecord::Receiver(one) => {
                    if let Some(serial) = one.serial.and_then(|serial| u32::try_from(serial).ok()) {
                        study.receivers.entry(serial).or_default().push(one);
                    }
                }
                RegisterRecord::Deployment(one) => {
                    study.deployments.entry(folded(&one.receiver)).or_default().push(one);
                }
            }
        }
        study
    }

    /// Without what tells where animals were, where a receiver was or how deep it hung: for those who get places coarsened to
    /// cells of this size, m.
    #[must_use]
    pub fn without_places(mut self, cells_m: u32) -> Self {
        self.cells_m = Some(cells_m);
        for animal in self.animals.values_mut() {
            (animal.capture_place, animal.release_place) = (String::new(), String::new());
            (animal.capture_lat_deg, animal.capture_lon_deg) = (None, None);
            (animal.release_lat_deg, animal.release_lon_deg) = (None, None);
        }
        for deployment in self.deployments.values_mut().flatten() {
            deployment.depth_m = None;
            (deployment.lat_deg, deployment.lon_deg) = (None, None);
            // Its name may be the place.
            deployment.name = String::new();
        }
        self
    }

    /// Looks a detection up; the vessel has the given name.
    pub fn heard<'s>(&'s self, detection: &'s Detection, vessel: &'s str, lag: Lag) -> Heard<'s> {
        let by_receiver = detection.clock.utc();
        let time_us = by_receiver.unwrap_or(detection.origin.reported).micros();
        let tag = self.tag(detection, time_us);
        let animal = tag.and_then(|tag| self.animal(tag, time_us));
        let project = tag.and_then(|tag| self.project(tag, animal));
        let person = |name: &String| self.people.get(&folded(name));
        let receiver = self.receiver(detection, time_us);
        Heard {
            detection,
            vessel,
            time_us,
            is_by_receiver: by_receiver.is_some(),
            tag,
            animal,
            project,
            principal_investigator: project.and_then(|project| person(&project.principal_investigator)),
            contact: project.and_then(|project| person(&project.contact)),
            receiver,
            deployment: receiver.and_then(|one| self.deployment(one, detection.origin.system.0, time_us)),
            lag,
            cell_m: self.cells_m,
        }
    }

    fn tag(&self, detection: &Detection, time_us: i64) -> Option<&RegisterTag> {
        let protocol = detection.protocol.to_string();
        self.tags_of(&protocol, detection.tag_id, detection.frequency_khz)
            .find(|tag| is_of_time(tag, time_us))
    }

    /// Tags of a code, one after another in time; [`is_of_time`] says which is the tag of a moment.
    /// Where the carrier is not known, it is that of any.
    pub(crate) fn tags_of(
        &self,
        protocol: &str,
        id: u32,
        khz: Option<u8>,
    ) -> impl Iterator<Item = &RegisterTag> {
        let is_heard = move |tag: &&RegisterTag| {
            tag.frequency_khz.zip(khz).is_none_or(|(wanted, khz)| wanted == i64::from(khz))
        };
        self.tags.get(&(protocol.to_uppercase(), id)).into_iter().flatten().filter(is_heard)
    }

    /// The project of a tag, or of the animal that carries it.
    pub(crate) fn project(
        &self,
        tag: &RegisterTag,
        animal: Option<&RegisterAnimal>,
    ) -> Option<&RegisterProject> {
        let of_tag = Some(folded(&tag.project)).filter(|name| !name.is_empty());
        of_tag.or(animal.map(|animal| folded(&animal.project))).and_then(|name| self.projects.get(&name))
    }

    /// The person of this name.
    pub fn person_named(&self, name: &str) -> Option<&RegisterPerson> {
        self.people.get(&folded(name))
    }

    /// Names of people.
    pub fn people_names(&self) -> impl Iterator<Item = &str> {
        self.people.values().map(|person| &*person.name)
    }

    /// The project of this name.
    pub fn project_named(&self, name: &str) -> Option<&RegisterProject> {
        self.projects.get(&folded(name))
    }

    /// The animal that carried a tag at a time.
    pub(crate) fn animal(&self, tag: &RegisterTag, time_us: i64) -> Option<&RegisterAnimal> {
        let (animal, from_us) = self.carrier(tag)?;
        from_us.is_none_or(|from_us| from_us <= time_us).then_some(animal)
    }

    /// The animal that carries a tag, and from when on (µs): from the tag's `from_time`, and where it has none, from its release,
    /// or its capture; else always.
    pub(crate) fn carrier(&self, tag: &RegisterTag) -> Option<(&RegisterAnimal, Option<i64>)> {
        let animal = self.animals.get(&folded(&tag.animal))?;
        Some((animal, tag.from_us.or(animal.release_us).or(animal.capture_us)))
    }

    fn deployment(
        &self,
        receiver: &RegisterReceiver,
        vessel: u16,
        time_us: i64,
    ) -> Option<&RegisterDeployment> {
        let holds =
            |one: &&RegisterDeployment| one.vessel == Some(vessel) && within(one.from_us, one.to_us, time_us);
        self.deployments.get(&folded(&receiver.name))?.iter().find(holds)
    }

    /// The receiver of a detection. Of several with its number, of makers that are not known, it is the one that was on its
    /// vessel then.
    fn receiver(&self, detection: &Detection, time_us: i64) -> Option<&RegisterReceiver> {
        let mut all = self.numbered(detection.receiver, detection.maker);
        let first = all.next()?;
        let Some(second) = all.next() else { return Some(first) };
        let system = detection.origin.system.0;
        let mut all = [first, second].into_iter().chain(all);
        all.find(|one| self.deployment(one, system, time_us).is_some())
    }

    /// Receivers with a serial number that are, or may be, of a maker.
    fn numbered(&self, serial: u32, maker: Option<Maker>) -> impl Iterator<Item = &RegisterReceiver> {
        let may_be = move |one: &&RegisterReceiver| {
            maker_of(one).zip(maker).is_none_or(|(registered, maker)| registered == maker)
        };
        self.receivers.get(&serial).into_iter().flatten().filter(may_be)
    }

    /// Where the receiver of a serial number and a maker was at a time (µs): its deployment, on whichever vessel or station.
    /// `None` also where it may be either of two receivers that were deployed then.
    pub(crate) fn deployed(
        &self,
        serial: u32,
        maker: Option<Maker>,
        time_us: i64,
    ) -> Option<&RegisterDeployment> {
        let then = |one: &&RegisterDeployment| within(one.from_us, one.to_us, time_us);
        let all = self.numbered(serial, maker).filter_map(|one| self.deployments.get(&folded(&one.name)));
        let mut found = all.filter_map(|all| all.iter().find(then));
        found.next().filter(|_| found.next().is_none())
    }

    /// Whether a deployment names this vessel or station.
    pub fn is_carrier(&self, system: u16) -> bool {
        self.deployments.values().flatten().any(|one| one.vessel == Some(system))
    }

    /// Tags that animals carry, with the animals, by protocol and number.
    pub(crate) fn carried(&self) -> impl Iterator<Item = (&RegisterTag, &RegisterAnimal)> {
        let animal = |tag: &RegisterTag| self.animals.get(&folded(&tag.animal));
        self.tags.values().flatten().filter_map(move |tag| Some((tag, animal(tag)?)))
    }
}

impl Heard<'_> {
    /// The meaning of the tag's count; `None` where it sent none or the register does not say.
    pub fn sensor(&self) -> Option<Sensor<'_>> {
        let (count, tag) = (self.detection.data?, self.tag?);
        let value = f64::from(count) * tag.sensor_slope? + tag.sensor_intercept.unwrap_or(0.0);
        Some(Sensor { value, unit: &tag.sensor_unit, kind: &tag.sensor_type })
    }

    /// Why this is perhaps no detection of the tag: nothing else confirms it within 30 of its ping intervals (the rule of Pincock
    /// 2012, by which GLATOS filters). `None` where something does, or where the register does not say how often the tag
    /// pings, or it pings so seldom that a day's neighbours do not suffice, or its neighbours are unknown.
    pub fn doubt(&self) -> Option<String> {
        let within_s = confirming_s(self.tag?)?;
        is_doubted(within_s, self.lag).then(|| {
            let interval_s = within_s / PINGS;
            format!(
                "no other detection of this tag by this receiver within {within_s:.0} s, {PINGS:.0} ping intervals of {interval_s:.0} s"
            )
        })
    }

    /// Frequency and code space as Innovasea writes them, `A69-1303`: of the register, else by the protocol, unchanged
    /// where it has no number there.
    pub fn codespace(&self) -> String {
        let detection = self.detection;
        codespace(self.tag, &detection.protocol.to_string(), detection.frequency_khz)
    }

    /// The receiver's model, by the register; else how its maker calls its receivers.
    pub fn model(&self) -> &str {
        let made = self.detection.maker.unwrap_or(Maker::Thelma).model();
        self.receiver.map(|one| &*one.model).filter(|model| !model.is_empty()).unwrap_or(made)
    }
}

/// Whether nothing confirms a detection within so many seconds, which are [`confirming_s`] of its tag.
pub(crate) fn is_doubted(within_s: f64, lag: Lag) -> bool {
    match lag {
        Lag::Seconds(lag_s) => lag_s > within_s,
        Lag::Nothing => true,
        Lag::Unknown => false,
    }
}

/// Within how many seconds something must confirm a detection of a tag; `None` where the register does not say how often it pings,
/// or so seldom that a day's neighbours do not suffice.
pub(crate) fn confirming_s(tag: &RegisterTag) -> Option<f64> {
    let interval_s = match (tag.interval_min_s, tag.interval_max_s) {
        (Some(least_s), Some(most_s)) => f64::midpoint(least_s, most_s),
        (one_s, other_s) => one_s.or(other_s)?,
    };
    Some(PINGS * interval_s).filter(|within_s| *within_s <= HORIZON_S as f64)
}

/// Whether this is the tag of its code at a moment.
pub(crate) fn is_of_time(tag: &RegisterTag, time_us: i64) -> bool {
    within(tag.from_us, tag.to_us, time_us)
}

/// See [`Heard::codespace`]. The protocol alone where the carrier is not known.
pub(crate) fn codespace(tag: Option<&RegisterTag>, protocol: &str, khz: Option<u8>) -> String {
    if let Some(tag) = tag.filter(|tag| !tag.codespace.is_empty()) {
        return tag.codespace.clone();
    }
    let Some(khz) = khz else { return protocol.to_owned() };
    // Receivers of Innovasea name the code space itself.
    if protocol.strip_prefix(&format!("A{khz}-")).is_some_and(|rest| !rest.is_empty()) {
        return protocol.to_owned();
    }
    let known = CODESPACES.iter().find(|(name, _)| khz == CODED_KHZ && name.eq_ignore_ascii_case(protocol));
    known.map_or_else(|| format!("A{khz}-{protocol}"), |(_, codespace)| (*codespace).to_owned())
}

fn within(from_us: Option<i64>, to_us: Option<i64>, time_us: i64) -> bool {
    from_us.is_none_or(|from| from <= time_us) && to_us.is_none_or(|to| time_us < to)
}

fn folded(name: &str) -> String {
    crate::check::folded(name)
}
