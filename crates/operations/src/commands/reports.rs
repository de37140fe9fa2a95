//! Vessels' reports on request of any console: parameters of their entities, and plans.
//!
//! A query commands nothing, so it needs no lease. The same query is sent once in [`AGAIN`], however many people
//! ask. The memory is bounded by bytes; the vessel that reported last stays.

use api::{Said, say};
use bytes::Bytes;
use imc::entities::SAVED_SUFFIX;
use imc::messages::{
    EntityParameter, EntityParameters, Message, Payload as _, PlanDB, PlanDBOp, PlanDBType,
    PlanSpecification, QueryEntityParameters,
};
use imc::{Address, Header, Packet, PacketView};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::time::Duration;
use units::{MonoTime, Now, UtcTime};

/// The same question is not asked again within this time: its answer may be on the way.
const AGAIN: Duration = Duration::from_secs(2);
/// Questions to one vessel within [`AGAIN`]; a system has at most 256 entities.
const QUESTIONS: usize = 300;
/// Parameters of one entity that are kept, letters of a name and of a value.
const PARAMETERS: usize = 500;
const NAME_CHARS: usize = 100;
const VALUE_CHARS: usize = 1_000;
/// Letters of a value where it is one of several in a line.
const BRIEF_CHARS: usize = 150;
/// Entities and plans of one vessel that are kept.
const ENTITIES: usize = 256;
const PLANS: usize = 16;
/// Bytes of all that is kept.
const BYTES: usize = 8 << 20;
/// Request ids of our orders are in the upper half.
const REQUEST_ID: u16 = 1;

/// The queries to a vessel.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Question {
    /// The parameters of the entity with this label.
    Parameters(String),
    /// Which plans are stored aboard.
    Plans,
    /// A plan.
    Plan(String),
}

/// A parameter as a vessel reported it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ParameterReport {
    /// Its value.
    pub value: String,
    /// Its value from the next start; `None` where the vessel does not report it.
    pub saved: Option<String>,
    /// Whether the value is longer than what is kept of it.
    pub cut: bool,
    /// When it was reported.
    pub at: UtcTime,
}

/// The parameters of an entity.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct EntityReport {
    /// By name.
    pub parameters: BTreeMap<String, ParameterReport>,
    /// How many more the vessel reported than are kept.
    pub left_out: usize,
    /// When it reported last.
    pub at: Option<UtcTime>,
    /// Since when an answer to our own question is awaited.
    asked: Option<UtcTime>,
}

impl EntityReport {
    /// Takes reported names and values.
    pub fn take<'a>(&mut self, told: impl Iterator<Item = (Cow<'a, str>, Cow<'a, str>)>, at: UtcTime) {
        (self.at, self.left_out) = (Some(at), 0);
        let mut saved = Vec::new();
        for (name, text) in told {
            if let Some(of) = name.strip_suffix(SAVED_SUFFIX) {
                saved.push((of.to_owned(), shortened(&text, VALUE_CHARS).0));
                continue;
            }
            let (name, (value, cut)) = (shortened(&name, NAME_CHARS).0, shortened(&text, VALUE_CHARS));
            if let Some(known) = self.parameters.get_mut(&name) {
                (known.value, known.cut, known.at) = (value, cut, at);
            } else if self.parameters.len() < PARAMETERS {
                self.parameters.insert(name, ParameterReport { value, saved: None, cut, at });
            } else {
                self.left_out += 1;
            }
        }
        for (name, value) in saved {
            if let Some(known) = self.parameters.get_mut(&name) {
                known.saved = Some(value);
            }
        }
    }
}

/// A plan as a vessel reported it.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanReport {
    /// All of it.
    pub plan: PlanSpecification,
    /// When it was reported.
    pub at: UtcTime,
    bytes: usize,
}

#[derive(Debug, Default)]
struct OfVessel {
    entities: BTreeMap<String, EntityReport>,
    plans: BTreeMap<String, PlanReport>,
    asked: BTreeMap<Question, MonoTime>,
    last: MonoTime,
}

impl OfVessel {
    fn bytes(&self) -> usize {
        let of_one = |(name, one): (&String, &ParameterReport)| {
            128 + name.len() + one.value.len() + one.saved.as_ref().map_or(0, String::len)
        };
        let entities = self.entities.values().flat_map(|entity| entity.parameters.iter()).map(of_one);
        entities.sum::<usize>() + self.plans.values().map(|plan| plan.bytes).sum::<usize>()
    }
}

/// The reports of all vessels.
#[derive(Debug)]
pub struct Reports {
    own: Address,
    vessels: BTreeMap<Address, OfVessel>,
}

impl Reports {
    pub(super) fn new(own: Address) -> Self {
        Self { own, vessels: BTreeMap::new() }
    }

    /// The packets that ask a vessel; none where the same was asked a moment ago.
    ///
    /// # Errors
    /// Too much was asked within two seconds.
    pub fn ask(&mut self, now: Now, vessel: Address, questions: &[Question]) -> Result<Vec<Bytes>, Said> {
        let of = self.vessels.entry(vessel).or_default();
        of.asked.retain(|_, asked| now.mono.since(*asked) < AGAIN);
        let open = |question: &&Question| !of.asked.contains_key(*question);
        let new: Vec<Question> = questions.iter().filter(open).cloned().collect();
        if of.asked.len() + new.len() > QUESTIONS {
            return Err(say("more than {n} questions at once: ask again in two seconds")
                .with("n", QUESTIONS)
                .into());
        }
        let mut packets = Vec::with_capacity(new.len());
        for question in new {
            let header = Header {
                timestamp: now.utc.seconds(),
                src: self.own,
                src_ent: u8::MAX,
                dst: vessel,
                dst_ent: u8::MAX,
            };
            let packet = Packet::new(header, message(&question))
                .encode()
                .map_err(|error| Said::as_is(error.to_string()))?;
            packets.push(packet.into());
            if let Question::Parameters(entity) = &question
                && let Some(entity) = of.entities.get_mut(entity)
            {
                entity.asked = Some(now.utc);
            }
            of.asked.insert(question, now.mono);
        }
        Ok(packets)
    }

    /// A packet of the present from a vessel.
    pub(super) fn heard(&mut self, now: Now, view: &PacketView<'_>) {
        match view.id() {
            EntityParameters::ID => {
                if let Ok(Some(told)) = imc::decode::<EntityParameters>(view) {
                    self.parameters_told(now, view, &told);
                }
            }
            PlanSpecification::ID => {
                if let Ok(Some(plan)) = imc::decode::<PlanSpecification>(view) {
                    self.plan_told(now, view, plan);
                }
            }
            PlanDB::ID => {
                if let Ok(Some(answer)) = imc::decode::<PlanDB>(view)
                    && (answer.r#type, answer.op) == (PlanDBType::Success, PlanDBOp::Get)
                    && let Some(plan) = answer.arg.of::<PlanSpecification>()
                {
                    self.plan_told(now, view, plan);
                }
            }
            _ => return,
        }
        self.forget(view.src());
    }

    /// The entities of which a vessel reported parameters, by label.
    pub fn entities(&self, vessel: Address) -> impl Iterator<Item = (&str, &EntityReport)> {
        let of = self.vessels.get(&vessel);
        of.into_iter().flat_map(|of| of.entities.iter().map(|(label, entity)| (label.as_str(), entity)))
    }

    /// A parameter as last reported.
    pub fn parameter(&self, vessel: Address, entity: &str, name: &str) -> Option<&ParameterReport> {
        self.vessels.get(&vessel)?.entities.get(entity)?.parameters.get(name)
    }

    /// A plan as the vessel last reported it.
    pub fn plan(&self, vessel: Address, plan_id: &str) -> Option<&PlanReport> {
        self.vessels.get(&vessel)?.plans.get(plan_id)
    }

    fn parameters_told(&mut self, now: Now, view: &PacketView<'_>, told: &EntityParameters) {
        let of = self.vessels.entry(view.src()).or_default();
        let label = shortened(&told.name.to_str_lossy(), NAME_CHARS).0;
        if of.entities.len() >= ENTITIES && !of.entities.contains_key(&label) {
            return;
        }
        of.last = now.mono;
        let entity = of.entities.entry(label).or_default();
        // An echo of a change has only what was changed; the answer to a query has all parameters.
        if view.dst() == self.own
            && let Some(asked) = entity.asked.take()
        {
            entity.parameters.retain(|_, one| one.at >= asked);
        }
        let params: Vec<EntityParameter> = told.params.of().collect();
        entity.take(params.iter().map(|one| (one.name.to_str_lossy(), one.value.to_str_lossy())), now.utc);
    }

    fn plan_told(&mut self, now: Now, view: &PacketView<'_>, plan: PlanSpecification) {
        // A console sends its plans to vessels, and a vessel may not have accepted such a plan.
        if view.src().is_ccu() {
            return;
        }
        let of = self.vessels.entry(view.src()).or_default();
        of.last = now.mono;
        let plan_id = plan.plan_id.to_str_lossy().into_owned();
        of.plans.insert(plan_id, PlanReport { plan, at: now.utc, bytes: view.bytes().len() });
        while of.plans.len() > PLANS {
            let oldest = of.plans.iter().min_by_key(|(_, plan)| plan.at).map(|(id, _)| id.clone());
            oldest.and_then(|id| of.plans.remove(&id));
        }
    }

    /// Keeps what is kept within its bounds; the vessel that was heard just now goes last.
    fn forget(&mut self, heard: Address) {
        let mut bytes: usize = self.vessels.values().map(OfVessel::bytes).sum();
        while bytes > BYTES {
            let others = self.vessels.iter().filter(|(address, _)| **address != heard);
            let oldest = others.min_by_key(|(_, of)| of.last).map_or(heard, |(address, _)| *address);
            bytes -= self.vessels.remove(&oldest).map_or(bytes, |of| of.bytes());
        }
    }
}

fn message(question: &Question) -> Message {
    let database = |op, plan_id: &str| {
        let (r#type, request_id, plan_id) = (PlanDBType::Request, REQUEST_ID, plan_id.into());
        PlanDB { r#type, op, request_id, plan_id, ..PlanDB::default() }.into()
    };
    match question {
        Question::Parameters(entity) => QueryEntityParameters {
            name: entity.as_str().into(),
            visibility: "developer".into(),
            scope: "global".into(),
        }
        .into(),
        Question::Plans => database(PlanDBOp::GetState, ""),
        Question::Plan(plan_id) => database(PlanDBOp::Get, plan_id),
    }
}

/// A value in a sentence: of a long one its beginning and how long it is.
pub(super) fn brief(value: &str) -> Cow<'_, str> {
    match shortened(value, BRIEF_CHARS) {
        (start, true) => Cow::Owned(format!("{start}... ({} letters)", value.chars().count())),
        (_, false) => Cow::Borrowed(value),
    }
}

/// At most so many letters, and whether there were more.
fn shortened(text: &str, letters: usize) -> (String, bool) {
    match text.char_indices().nth(letters) {
        Some((end, _)) => (text[..end].to_owned(), true),
        None => (text.to_owned(), false),
    }
}

/// Whether two texts are the same value: numbers by their value, words without regard to capitals, lists item by
/// item.
pub fn is_same_value(one: &str, other: &str) -> bool {
    let (mut ones, mut others) = (one.split(','), other.split(','));
    loop {
        match (ones.next(), others.next()) {
            (None, None) => return true,
            (Some(one), Some(other)) if is_same_item(one.trim(), other.trim()) => {}
            _ => return false,
        }
    }
}

fn is_same_item(one: &str, other: &str) -> bool {
    match (one.parse::<f64>(), other.parse::<f64>()) {
        // Vessels round reported values to nine decimals.
        (Ok(one), Ok(other)) => (one - other).abs() <= 1e-9 * one.abs().max(1.0),
        _ => one.eq_ignore_ascii_case(other),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOAT: Address = Address(0x2810);
    const SHORE: Address = Address(0x4001);

    fn at(seconds: u64) -> Now {
        let us = seconds * 1_000_000;
        Now { mono: MonoTime::from_micros(us), utc: UtcTime::from_micros(us as i64) }
    }

    fn says(told: &mut Reports, seconds: u64, src: Address, message: impl Into<Message>) {
        let bytes = Packet::new(Header { src, dst: SHORE, ..Header::default() }, message).encode().unwrap();
        told.heard(at(seconds), &PacketView::new(&bytes).unwrap());
    }

    fn parameters(values: &[(&str, &str)]) -> EntityParameters {
        let one =
            |(name, value): &(&str, &str)| EntityParameter { name: (*name).into(), value: (*value).into() };
        EntityParameters { name: "Path Control".into(), params: values.iter().map(one).collect() }
    }

    fn known(told: &Reports) -> Vec<(&str, &str, Option<&str>)> {
        let of = told.entities(BOAT).flat_map(|(_, entity)| &entity.parameters);
        of.map(|(name, one)| (name.as_str(), one.value.as_str(), one.saved.as_deref())).collect()
    }

    #[test]
    fn an_echo_adds_to_what_is_known_and_an_answer_replaces_it() {
        let mut told = Reports::new(SHORE);
        says(&mut told, 1, BOAT, parameters(&[("A", "1"), ("B", "2"), ("A - Saved", "0")]));
        says(&mut told, 2, BOAT, parameters(&[("B", "3")]));
        assert_eq!(known(&told), [("A", "1", Some("0")), ("B", "3", None)]);
        let question = [Question::Parameters("Path Control".to_owned())];
        assert_eq!(told.ask(at(3), BOAT, &question).unwrap().len(), 1);
        assert_eq!(told.ask(at(3), BOAT, &question).unwrap().len(), 0, "it was asked just now");
        says(&mut told, 4, BOAT, parameters(&[("B", "3"), ("C", "x")]));
        assert_eq!(known(&told), [("B", "3", None), ("C", "x", None)]);
        assert_eq!(told.ask(at(6), BOAT, &question).unwrap().len(), 1);
    }

    #[test]
    fn plans_are_what_vessels_say_and_not_what_consoles_do() {
        let mut told = Reports::new(SHORE);
        let plan = |id: usize| PlanSpecification { plan_id: format!("p{id}").into(), ..Default::default() };
        says(&mut told, 0, Address(0x4002), plan(0));
        assert_eq!(told.plan(Address(0x4002), "p0"), None);
        for id in 0..40 {
            says(&mut told, id as u64, BOAT, plan(id));
        }
        assert!(told.plan(BOAT, "p39").is_some() && told.plan(BOAT, "p0").is_none());
    }

    #[test]
    fn a_vessel_that_tells_without_end_is_kept_within_bounds() {
        let mut told = Reports::new(SHORE);
        let long = "x".repeat(30_000);
        let names: Vec<String> = (0..2_000).map(|number| format!("{number}")).collect();
        let all: Vec<(&str, &str)> = names.iter().map(|name| (name.as_str(), "1")).collect();
        says(&mut told, 0, BOAT, parameters(&all));
        let (_, entity) = told.entities(BOAT).next().unwrap();
        assert_eq!((entity.parameters.len(), entity.left_out), (PARAMETERS, 1_500));
        says(&mut told, 1, BOAT, parameters(&[("0", &long)]));
        let one = told.parameter(BOAT, "Path Control", "0").unwrap();
        assert_eq!((one.value.len(), one.cut), (VALUE_CHARS, true));
        for address in 1..2_000_u16 {
            let plan = PlanSpecification { description: long.as_str().into(), ..Default::default() };
            says(&mut told, 2 + u64::from(address), Address(address), plan);
        }
        let bytes: usize = told.vessels.values().map(OfVessel::bytes).sum();
        assert!(bytes <= BYTES && told.plan(Address(1_999), "").is_some(), "{bytes}");
        let many: Vec<Question> = (0..400).map(|n| Question::Plan(format!("{n}"))).collect();
        assert!(told.ask(at(9_000), BOAT, &many).unwrap_err().contains("ask again"));
    }

    #[test]
    fn values_are_compared_by_what_they_mean() {
        for (one, other) in
            [("12", "12.0"), ("1, 2,3", "1,2, 3.0"), ("True", "true"), ("0.1", "0.1000000000001")]
        {
            assert!(is_same_value(one, other), "{one} {other}");
        }
        for (one, other) in [("12", "12.1"), ("1,2", "1,2,3"), ("a", "b"), ("", "0")] {
            assert!(!is_same_value(one, other), "{one} {other}");
        }
    }
}
