//! The vessel's present activity, as stored on disk for the next start of the program.
//!
//! It is kept as one IMC packet that any tool opens: the PlanControl that would start what runs, with the satellites'
//! time in its header (a computer without a network may keep a wrong time for ever), what the vessel does and the maneuver in `info`, and the plan in `arg`.

use crate::bus::Bus;
use crate::entity::Entity;
use crate::output::{Keep, Output};
use imc::messages::{
    PlanControl, PlanControlOp, PlanControlType, PlanManeuver, PlanSpecification, PlanTransition,
};
use imc::{Header, Packet};
use std::time::Duration;
use units::{MonoTime, UtcTime};

/// An unchanged state is stored again after this time: its age shows how long the program was away.
const REFRESH: Duration = Duration::from_secs(30);

/// The activity of a vessel that is not at rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Doing {
    /// An operator's plan.
    Plan,
    /// An operator steers.
    Teleoperation,
    /// A remedy of its supervisors.
    Remedy,
    /// Nothing: it was stopped, or its plan is over.
    Drift,
}

const WORDS: [(Doing, &str); 4] = [
    (Doing::Plan, "plan"),
    (Doing::Teleoperation, "teleoperation"),
    (Doing::Remedy, "remedy"),
    (Doing::Drift, "drift"),
];

/// The activity.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct UnderWay {
    pub(crate) doing: Doing,
    pub(crate) plan_id: String,
    /// The maneuver of the plan, once it has begun.
    pub(crate) maneuver: String,
    /// The plan, for [`Doing::Plan`].
    pub(crate) plan: Option<PlanSpecification>,
}

impl UnderWay {
    /// From the packet, with its time.
    pub(crate) fn read(packet: &[u8]) -> Option<(UtcTime, Self)> {
        let packet = Packet::decode(packet).ok()?;
        let control: &PlanControl = packet.get()?;
        let info = control.info.to_str_lossy();
        let (word, maneuver) = info.split_once(' ').unwrap_or((&info, ""));
        let (doing, _) = WORDS.into_iter().find(|(_, known)| *known == word)?;
        let under_way = Self {
            doing,
            plan_id: control.plan_id.to_str_lossy().into_owned(),
            maneuver: maneuver.to_owned(),
            plan: control.arg.of(),
        };
        Some((packet.header.time()?, under_way))
    }

    /// The packet; of a plan too large to fit into another message only its name.
    fn packet(&self, bus: &Bus, timestamp_s: f64) -> Option<Vec<u8>> {
        let whole = self.packet_with(bus, timestamp_s, self.plan.as_ref());
        whole.or_else(|| self.packet_with(bus, timestamp_s, None))
    }

    fn packet_with(&self, bus: &Bus, timestamp_s: f64, plan: Option<&PlanSpecification>) -> Option<Vec<u8>> {
        let word = WORDS.into_iter().find(|(doing, _)| *doing == self.doing).map_or("", |(_, word)| word);
        let control = PlanControl {
            r#type: PlanControlType::Request,
            op: PlanControlOp::Start,
            plan_id: self.plan_id.as_str().into(),
            arg: plan.cloned().map(imc::messages::Message::from).into(),
            info: format!("{word} {}", self.maneuver).as_str().into(),
            ..PlanControl::default()
        };
        let header = Header {
            timestamp: timestamp_s,
            src: bus.address(),
            src_ent: Entity::PlanEngine.number(),
            ..Header::default()
        };
        Packet::new(header, control).encode().ok()
    }

    /// The plan from the maneuver on that was under way.
    pub(crate) fn rest_of_plan(&self) -> Option<PlanSpecification> {
        let plan = self.plan.as_ref().filter(|_| self.doing == Doing::Plan)?;
        Some(rest_from(plan, &self.maneuver))
    }

    /// In words.
    pub(crate) fn text(&self) -> String {
        let Self { plan_id, maneuver, .. } = self;
        match self.doing {
            Doing::Plan if maneuver.is_empty() => format!("plan '{plan_id}' was under way"),
            Doing::Plan => format!("plan '{plan_id}' was under way at maneuver '{maneuver}'"),
            Doing::Teleoperation => "an operator was steering".to_owned(),
            Doing::Remedy => format!("the vessel's own '{plan_id}' was under way"),
            Doing::Drift => "the vessel was adrift on purpose".to_owned(),
        }
    }
}

/// A plan from this maneuver on; the whole where it has none of this name. Maneuvers that do not follow it are left out: in
/// a plan each must be led to.
pub(crate) fn rest_from(plan: &PlanSpecification, maneuver: &str) -> PlanSpecification {
    let nodes: Vec<PlanManeuver> = plan.maneuvers.of::<PlanManeuver>().collect();
    let Some(start) = nodes.iter().find(|node| node.maneuver_id == *maneuver) else { return plan.clone() };
    let transitions: Vec<PlanTransition> = plan.transitions.of::<PlanTransition>().collect();
    let mut led_to = vec![start.maneuver_id.clone()];
    let mut looked_at = 0;
    while let Some(from) = led_to.get(looked_at).cloned() {
        looked_at += 1;
        let next = transitions.iter().filter(|transition| transition.source_man == from);
        for transition in next {
            if !led_to.contains(&transition.dest_man) {
                led_to.push(transition.dest_man.clone());
            }
        }
    }
    PlanSpecification {
        start_man_id: start.maneuver_id.clone(),
        maneuvers: nodes.into_iter().filter(|node| led_to.contains(&node.maneuver_id)).collect(),
        transitions: transitions.into_iter().filter(|one| led_to.contains(&one.source_man)).collect(),
        ..plan.clone()
    }
}

/// Has it kept whenever it changes, and from time to time.
#[derive(Debug, Default)]
pub(crate) struct Keeper {
    kept: Option<UnderWay>,
    next: MonoTime,
}

impl Keeper {
    /// With what the disk holds.
    pub(crate) fn new(kept: Option<UnderWay>) -> Self {
        Self { kept, next: MonoTime::default() }
    }

    /// The present activity; `None` at rest. The time is that of the satellites (s).
    pub(crate) fn keep(&mut self, bus: &mut Bus, under_way: Option<UnderWay>, timestamp_s: f64) {
        let refresh = under_way.is_some() && bus.mono() >= self.next;
        if under_way == self.kept && !refresh {
            return;
        }
        self.next = bus.mono() + REFRESH;
        let packet = under_way.as_ref().and_then(|under_way| under_way.packet(bus, timestamp_s));
        bus.put(Output::Keep(Keep::UnderWay(packet)));
        self.kept = under_way;
    }
}
