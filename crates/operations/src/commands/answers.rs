//! What vessels' messages say about the progress of commands.

use super::{
    Answer, Command, CommandId, Commands, Effect, PlanAboard, PlansAboard, REST_SEEN, Stage, VESSELS,
    is_same_value,
};
use api::{Said, say};
use imc::messages::{
    Aborted, EntityParameter, EntityParameters, LogBookEntry, Payload as _, PlanControl, PlanControlOp,
    PlanControlState, PlanControlStateState, PlanControlType, PlanDB, PlanDBInformation, PlanDBOp,
    PlanDBState, PlanDBType, PlanSpecification,
};
use imc::{Address, PacketView};
use units::{Now, UtcTime};

/// Plans of one vessel that single answers may add up to; further ones are known when the vessel sends its whole list,
/// which fits one packet.
const PLANS: usize = 1_000;

impl Commands {
    /// Takes what a live packet shows of orders and of the vessel.
    pub(super) fn evidence(&mut self, now: Now, view: &PacketView<'_>) {
        let vessel = view.src();
        self.reports.heard(now, view);
        match view.id() {
            Aborted::ID => self.aborted(now, vessel),
            LogBookEntry::ID => {
                if let Ok(Some(entry)) = imc::decode::<LogBookEntry>(view) {
                    self.entry(now, vessel, &entry.text.to_str_lossy());
                }
            }
            PlanControlState::ID => {
                if let Ok(Some(state)) = imc::decode::<PlanControlState>(view) {
                    self.state(now, vessel, &state);
                }
            }
            PlanControl::ID if view.dst() == self.own => {
                if let Ok(Some(answer)) = imc::decode::<PlanControl>(view) {
                    self.control(now, vessel, &answer);
                }
            }
            PlanDB::ID => {
                if let Ok(Some(answer)) = imc::decode::<PlanDB>(view) {
                    self.plans(now, vessel, &answer);
                    if view.dst() == self.own {
                        self.database(now, vessel, &answer);
                    }
                }
            }
            EntityParameters::ID => {
                if let Ok(Some(parameters)) = imc::decode::<EntityParameters>(view) {
                    self.parameters(now, vessel, &parameters);
                }
            }
            _ => {}
        }
    }

    /// Open commands of a vessel of which this holds.
    fn open(&self, vessel: Address, holds: impl Fn(&Command) -> bool) -> Vec<CommandId> {
        let waits = |one: &Command| !one.is_over() || one.stage() == Stage::TimedOut;
        let sent = |one: &&Command| one.vessel == vessel && waits(one) && one.stage() >= Stage::Accepted;
        self.all.values().filter(sent).filter(|one| holds(one)).map(|one| one.id).collect()
    }

    /// The vessel answered: it has the command and does it.
    fn works(&mut self, now: Now, id: CommandId, text: Said) {
        if let Some(command) = self.all.get_mut(&id) {
            command.answered = true;
        }
        self.advance(now, id, Stage::Received, Said::default());
        self.advance(now, id, Stage::Executing, text);
    }

    fn control(&mut self, now: Now, vessel: Address, answer: &PlanControl) {
        let wanted = |command: &Command| match command.effect {
            Effect::Runs(_) => answer.op == PlanControlOp::Start,
            Effect::Rests => answer.op == PlanControlOp::Stop,
            _ => false,
        };
        let request = answer.request_id;
        let info = answer.info.to_str_lossy();
        for id in self.open(vessel, |one| one.request_id == request && wanted(one)) {
            match answer.r#type {
                PlanControlType::Success | PlanControlType::InProgress => {
                    self.works(now, id, Said::as_is(&*info));
                }
                PlanControlType::Failure => self.refused(now, id, Said::as_is(info.clone().into_owned())),
                PlanControlType::Request | PlanControlType::Unlisted(_) => {}
            }
        }
    }

    fn state(&mut self, now: Now, vessel: Address, state: &PlanControlState) {
        let plan_id = state.plan_id.to_str_lossy();
        let executing = state.state == PlanControlStateState::Executing;
        let rests = matches!(state.state, PlanControlStateState::Ready | PlanControlStateState::Blocked);
        // A plan that ran, or did not run, before the order is not evidence until the vessel has answered.
        let seen = |command: &Command| match &command.effect {
            Effect::Runs(wanted) => {
                executing && *wanted == plan_id && (command.answered || command.ran.as_ref() != Some(wanted))
            }
            Effect::Rests => rests && (command.answered || command.ran.is_some()),
            // A vessel that rested before counts as stopped once it has had time to receive the order.
            Effect::Aborts => {
                let long = command.sent.is_some_and(|sent| now.mono.since(sent) >= REST_SEEN);
                rests && command.sent.is_some() && (command.ran.is_some() || long)
            }
            _ => false,
        };
        for id in self.open(vessel, |one| one.listens(now.mono) && seen(one)) {
            let text = if executing {
                say("executing {plan}").with("plan", &plan_id)
            } else {
                say("no plan is executed")
            };
            self.works(now, id, Said::default());
            self.advance(now, id, Stage::EffectSeen, text);
        }
    }

    /// The vessel says that it aborted.
    fn aborted(&mut self, now: Now, vessel: Address) {
        let stop =
            |one: &Command| one.effect == Effect::Aborts && one.sent.is_some() && one.listens(now.mono);
        for id in self.open(vessel, stop) {
            self.works(now, id, Said::default());
            self.advance(now, id, Stage::EffectSeen, say("the vessel says that it aborted"));
        }
    }

    /// Takes news of the plans stored aboard, whichever console asked. An answer about one plan updates the list at once;
    /// before the whole list has come, that plan is all that is known.
    fn plans(&mut self, now: Now, vessel: Address, answer: &PlanDB) {
        if answer.r#type != PlanDBType::Success {
            return;
        }
        let known = self.aboard.get(&vessel).map(|(_, aboard)| aboard.plans.as_slice());
        let without = |plan_id: &str| -> Vec<PlanAboard> {
            known.unwrap_or_default().iter().filter(|plan| plan.plan_id != plan_id).cloned().collect()
        };
        let named = answer.plan_id.to_str_lossy();
        let plans = match (answer.op, answer.arg.of::<PlanDBState>(), answer.arg.of::<PlanDBInformation>()) {
            (_, Some(state), _) => state.plans_info.of::<PlanDBInformation>().map(plan_aboard).collect(),
            (PlanDBOp::Set, _, Some(stored)) => {
                let stored = plan_aboard(stored);
                let mut plans = without(&stored.plan_id);
                if plans.len() < PLANS {
                    let place = plans.partition_point(|plan| plan.plan_id < stored.plan_id);
                    plans.insert(place, stored);
                }
                plans
            }
            // Of one that is stored without a digest it is not known what it is.
            (PlanDBOp::Set | PlanDBOp::Del, ..) if known.is_some() => without(&named),
            (PlanDBOp::Clear, ..) => Vec::new(),
            _ => return,
        };
        if self.aboard.len() >= VESSELS && !self.aboard.contains_key(&vessel) {
            let oldest = self.aboard.iter().min_by_key(|(_, (at, _))| *at).map(|(vessel, _)| *vessel);
            oldest.and_then(|oldest| self.aboard.remove(&oldest));
        }
        self.aboard.insert(vessel, (now.mono, PlansAboard { at: now.utc, plans }));
    }

    fn database(&mut self, now: Now, vessel: Address, answer: &PlanDB) {
        let wanted = |command: &Command| {
            let op = match command.effect {
                Effect::Stores(..) => PlanDBOp::Set,
                Effect::Removed(_) => PlanDBOp::Del,
                Effect::Listed => PlanDBOp::GetState,
                Effect::Gave(_) => PlanDBOp::Get,
                _ => return false,
            };
            answer.op == op && answer.request_id == command.request_id
        };
        let info = answer.info.to_str_lossy().into_owned();
        for id in self.open(vessel, wanted) {
            match answer.r#type {
                PlanDBType::InProgress => self.works(now, id, Said::as_is(&*info)),
                PlanDBType::Failure => self.refused(now, id, Said::as_is(info.clone())),
                PlanDBType::Success => {
                    self.works(now, id, Said::as_is(&*info));
                    self.done(now, id, answer);
                }
                PlanDBType::Request | PlanDBType::Unlisted(_) => {}
            }
        }
    }

    /// The database says that it has done what was asked.
    fn done(&mut self, now: Now, id: CommandId, answer: &PlanDB) {
        let Some(command) = self.all.get_mut(&id) else { return };
        let text: Said = match &command.effect {
            Effect::Stores(plan_id, digest) => match answer.arg.of::<PlanDBInformation>() {
                Some(stored) if stored.md5 != digest => {
                    let text =
                        say("the vessel stores another '{plan}': the digests differ").with("plan", plan_id);
                    return self.refused(now, id, text);
                }
                Some(_) => say("stores {plan}").with("plan", plan_id).into(),
                None => say("says that it stores {plan}, but gave no digest to compare")
                    .with("plan", plan_id)
                    .into(),
            },
            Effect::Removed(plan_id) => say("{plan} is removed").with("plan", plan_id).into(),
            Effect::Gave(_) => {
                let Some(plan) = answer.arg.of::<PlanSpecification>() else {
                    return self.refused(now, id, say("the answer holds no plan"));
                };
                command.answer = Some(Answer::Plan(Box::new(plan)));
                Said::default()
            }
            _ => Said::default(),
        };
        let vessel = command.vessel;
        self.advance(now, id, Stage::EffectSeen, text);
        self.forget(vessel);
    }

    /// A vessel reports refused values in its log book only: Lutra's to the requester, DUNE's to all.
    fn entry(&mut self, now: Now, vessel: Address, text: &str) {
        let (text, _) = imc::logbook::split_command(text);
        for id in self.open(vessel, |one| matches!(&one.effect, Effect::Reports(_, set) if !set.is_empty())) {
            let Some(command) = self.all.get_mut(&id) else { continue };
            let Effect::Reports(_, set) = &command.effect else { continue };
            let why = |name: &str, value: &str| {
                let by_lutra = text.strip_prefix(&format!("{name} = {value} is refused: "));
                let by_dune =
                    || text.strip_prefix("updating entity parameters: ")?.strip_suffix(&format!("'{name}'"));
                by_lutra.or_else(by_dune).map(|why| why.trim_end_matches([':', ' ']).to_owned())
            };
            let refused = set.iter().filter_map(|(name, value)| Some((name.clone(), why(name, value)?)));
            command.refusals.extend(refused.collect::<Vec<_>>());
            if command.refusals.len() < set.len() {
                continue;
            }
            let words: Vec<String> =
                command.refusals.iter().map(|(name, why)| format!("{name}: {why}")).collect();
            self.works(now, id, Said::default());
            self.refused(now, id, Said::as_is(words.join("; ")));
        }
    }

    fn parameters(&mut self, now: Now, vessel: Address, told: &EntityParameters) {
        let entity = told.name.to_str_lossy();
        let text = |text: &imc::Text| text.to_str_lossy().into_owned();
        let values: Vec<(String, String)> =
            told.params.of::<EntityParameter>().map(|one| (text(&one.name), text(&one.value))).collect();
        for id in self.open(vessel, |one| matches!(&one.effect, Effect::Reports(of, _) if *of == entity)) {
            let Some(command) = self.all.get_mut(&id) else { continue };
            let Effect::Reports(_, set) = &command.effect else { continue };
            // An answer echoes the accepted values, and nothing else; one to a query may still hold the old ones.
            let taken = |(name, value): &&(String, String)| {
                values.iter().any(|(told, now)| told == name && is_same_value(now, value))
            };
            let left_out: Vec<&String> = set.iter().filter(|one| !taken(one)).map(|(name, _)| name).collect();
            if left_out.len() == set.len() && !set.is_empty() {
                continue;
            }
            let why = |name: &&String| {
                command.refusals.get(*name).map_or_else(|| (*name).clone(), |why| format!("{name} ({why})"))
            };
            let told: Vec<String> = left_out.iter().map(why).collect();
            let refused = (!told.is_empty())
                .then(|| say("not taken: {parameters}").with("parameters", told.join(", ")));
            command.answer = Some(Answer::Parameters(values.clone()));
            self.works(now, id, Said::default());
            match refused {
                Some(why) => self.refused(now, id, why),
                None => self.advance(now, id, Stage::EffectSeen, Said::default()),
            }
            self.forget(vessel);
        }
    }
}

fn plan_aboard(told: PlanDBInformation) -> PlanAboard {
    PlanAboard {
        plan_id: told.plan_id.to_str_lossy().into_owned(),
        size: told.plan_size,
        changed: UtcTime::from_seconds(told.change_time),
        changed_by: told.change_sname.to_str_lossy().into_owned(),
        md5: told.md5,
    }
}
