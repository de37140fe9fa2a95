//! The arbiter of the supervisors' demands: which is carried out, and until when.
//!
//! Each supervisor has at most one standing demand; a newer one of the same supervisor replaces it (its own
//! ladder knows best). Between supervisors the strongest remedy wins:
//!
//! | rank | remedy | because |
//! |---|---|---|
//! | 3 | stop | motors off is what everything else falls back to |
//! | 2 | run a plan (return) | leads the vessel out of where it is in need |
//! | 1 | hold station | gains time |
//!
//! Of equal remedies the one that runs stays, else grounding comes before limits before battery before lost
//! communications. A
//! weaker remedy never replaces a stronger one that runs or waits. A remedy that cannot be carried out (no
//! position to hold, no plan of that name, the engine refuses) or that ended in a failure is tried again every
//! two seconds until it holds; meanwhile the next weaker that is possible replaces it, at last the stop.
//!
//! A demand ends when its supervisor withdraws it, when its plan has completed, or when an operator
//! steps in: a start, a stop or an abort from outside settles all that was asked before. No remedy but the
//! stop acts before an operator has set the vessel in motion, nor after an abort.

use mission::{Remedy, RunId};
use std::collections::BTreeMap;
use std::time::Duration;
use units::MonoTime;

/// Time between two tries.
const RETRY: Duration = Duration::from_secs(2);

/// The source of a demand; of equal remedies the later in this list comes first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Source {
    Failure,
    Restart,
    LostComms,
    Battery,
    Limits,
    Grounding,
}

/// The present state, as far as it matters here.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Picture {
    /// The run of the engine.
    pub(crate) run: Option<RunId>,
    /// Whether the last run completed.
    pub(crate) ended_well: bool,
    /// Whether an operator has set the vessel in motion, without an abort since.
    pub(crate) under_way: bool,
}

/// The state of a demand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Standing {
    /// Its remedy runs, or [another's](Arbiter::instead) that is as strong or stronger.
    Holds,
    /// It is tried again at this time.
    Waits(MonoTime),
    /// No operator has set the vessel in motion.
    AtRest,
    /// Its plan completed, or an operator stepped in.
    Settled,
}

#[derive(Debug, Clone)]
struct Demand {
    remedy: Remedy,
    settled: bool,
}

#[derive(Debug, Clone)]
struct Running {
    run: RunId,
    source: Source,
    remedy: Remedy,
}

/// The arbiter.
#[derive(Debug, Clone, Default)]
pub(crate) struct Arbiter {
    demands: BTreeMap<Source, Demand>,
    running: Option<Running>,
    next_try: MonoTime,
    under_way: bool,
}

impl Arbiter {
    /// A supervisor demands this.
    pub(crate) fn ask(&mut self, now: MonoTime, source: Source, remedy: Remedy) {
        self.demands.insert(source, Demand { remedy, settled: false });
        self.next_try = now;
    }

    /// A supervisor withdraws its demand; a remedy that runs continues until an operator steps in.
    pub(crate) fn withdraw(&mut self, source: Source) {
        self.demands.remove(&source);
    }

    /// An operator decides from here on.
    pub(crate) fn stepped_in(&mut self) {
        self.running = None;
        self.demands.values_mut().for_each(|demand| demand.settled = true);
    }

    /// The obstacle to a remedy has changed: it is tried now.
    pub(crate) fn try_now(&mut self, now: MonoTime) {
        self.next_try = now;
    }

    /// The running remedy cannot reach its end: it is demanded again, also where its supervisor had withdrawn it.
    pub(crate) fn begin_again(&mut self, now: MonoTime) -> Option<Source> {
        let Running { source, remedy, .. } = self.running.take()?;
        self.ask(now, source, remedy);
        Some(source)
    }

    /// The run that carries out a remedy.
    pub(crate) fn run(&self) -> Option<RunId> {
        self.running.as_ref().map(|running| running.run)
    }

    /// The remedy that runs.
    pub(crate) fn remedy(&self) -> Option<&Remedy> {
        self.running.as_ref().map(|running| &running.remedy)
    }

    /// The source of the remedy that runs.
    pub(crate) fn source(&self) -> Option<Source> {
        self.running.as_ref().map(|running| running.source)
    }

    /// The remedy that is asked for and not settled, whether it runs or waits; none where the motors are to be off.
    pub(crate) fn wanted(&self) -> Option<Remedy> {
        self.strongest().map(|(_, remedy)| remedy).filter(|remedy| *remedy != Remedy::Stop)
    }

    /// Whether another than this one asks for something.
    pub(crate) fn asks_besides(&self, source: Source) -> bool {
        self.demands.iter().any(|(other, demand)| *other != source && !demand.settled)
    }

    /// What to do now, and for whom; its outcome must be reported back.
    pub(crate) fn decide(&mut self, now: MonoTime, picture: Picture) -> Option<(Source, Remedy)> {
        self.under_way = picture.under_way;
        if let Some(ended) = self.running.take_if(|running| picture.run != Some(running.run)) {
            let demand = self.demands.get_mut(&ended.source);
            if let Some(demand) = demand.filter(|demand| picture.ended_well && demand.remedy == ended.remedy)
            {
                demand.settled = true;
            }
        }
        let (source, remedy) = self.strongest()?;
        let holds = match (&remedy, &self.running) {
            (Remedy::Stop, _) => picture.run.is_none(),
            (_, Some(running)) => running.serves(source, &remedy),
            (_, None) => !picture.under_way,
        };
        if holds || now < self.next_try {
            return None;
        }
        self.next_try = now + RETRY;
        Some((source, remedy))
    }

    /// A run now carries out a remedy for a supervisor: the one decided upon or a stand-in.
    pub(crate) fn began(&mut self, run: RunId, source: Source, remedy: Remedy) {
        self.running = Some(Running { run, source, remedy });
    }

    /// Whether a stand-in like this runs already.
    pub(crate) fn carries(&self, remedy: &Remedy) -> bool {
        self.running.as_ref().is_some_and(|running| running.remedy == *remedy)
    }

    /// A supervisor's demand and its state.
    pub(crate) fn standing(&self, source: Source) -> Option<(&Remedy, Standing)> {
        let demand = self.demands.get(&source)?;
        let standing = match &self.running {
            _ if demand.settled => Standing::Settled,
            Some(running) if running.serves(source, &demand.remedy) => Standing::Holds,
            _ if demand.remedy == Remedy::Stop || self.stop().is_some() => Standing::Holds,
            _ if !self.under_way => Standing::AtRest,
            _ => Standing::Waits(self.next_try),
        };
        Some((&demand.remedy, standing))
    }

    /// What runs in place of what a supervisor asked for, because it is as strong or stronger.
    pub(crate) fn instead(&self, source: Source) -> Option<&Remedy> {
        let demand = self.demands.get(&source).filter(|demand| !demand.settled)?;
        if let Some(stop) = self.stop().filter(|stop| **stop != demand.remedy) {
            return Some(stop);
        }
        let running = self.running.as_ref().filter(|running| running.remedy != demand.remedy)?;
        running.serves(source, &demand.remedy).then_some(&running.remedy)
    }

    /// The stop that a supervisor demands. It is carried out without a run, and no other remedy runs beside it.
    fn stop(&self) -> Option<&Remedy> {
        let open = self.demands.values().filter(|demand| !demand.settled);
        open.map(|demand| &demand.remedy).find(|remedy| **remedy == Remedy::Stop)
    }

    fn strongest(&self) -> Option<(Source, Remedy)> {
        let open = self.demands.iter().filter(|(_, demand)| !demand.settled);
        let (source, demand) = open.max_by_key(|(source, demand)| (rank(&demand.remedy), **source))?;
        Some((*source, demand.remedy.clone()))
    }
}

impl Running {
    /// Whether it is what a supervisor asks for, or what a stronger one does.
    fn serves(&self, source: Source, remedy: &Remedy) -> bool {
        if self.source == source { self.remedy == *remedy } else { rank(&self.remedy) >= rank(remedy) }
    }
}

fn rank(remedy: &Remedy) -> u8 {
    match remedy {
        Remedy::Hold => 1,
        Remedy::Run { .. } => 2,
        Remedy::Stop => 3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAILING: Picture = Picture { run: Some(RunId(1)), ended_well: false, under_way: true };

    fn at(seconds: u64) -> MonoTime {
        MonoTime::from_micros(seconds * 1_000_000)
    }

    fn home() -> Remedy {
        Remedy::Run { plan_id: "home".to_owned() }
    }

    fn running(run: u32) -> Picture {
        Picture { run: Some(RunId(run)), ..SAILING }
    }

    #[test]
    fn the_strongest_is_obeyed_in_whatever_order_they_ask() {
        for reversed in [false, true] {
            let mut arbiter = Arbiter::default();
            let mut asks = vec![
                (Source::LostComms, Remedy::Hold),
                (Source::Battery, home()),
                (Source::Limits, Remedy::Hold),
            ];
            if reversed {
                asks.reverse();
            }
            for (source, remedy) in asks {
                arbiter.ask(at(1), source, remedy);
            }
            assert_eq!(arbiter.decide(at(1), SAILING), Some((Source::Battery, home())));
            arbiter.began(RunId(2), Source::Battery, home());
            assert_eq!(arbiter.decide(at(9), running(2)), None, "the weaker do not replace it");
            assert_eq!(arbiter.standing(Source::Limits), Some((&Remedy::Hold, Standing::Holds)));
            arbiter.ask(at(10), Source::Limits, Remedy::Stop);
            assert_eq!(arbiter.decide(at(10), running(2)), Some((Source::Limits, Remedy::Stop)));
            let stopped = Picture { run: None, ..SAILING };
            assert_eq!(arbiter.decide(at(20), stopped), None, "the return does not start again");
        }
    }

    #[test]
    fn what_runs_in_place_of_a_demand_is_known() {
        let berth = Remedy::Run { plan_id: "berth".to_owned() };
        let mut arbiter = Arbiter::default();
        arbiter.ask(at(1), Source::Battery, home());
        assert!(arbiter.decide(at(1), SAILING).is_some());
        assert_eq!(arbiter.instead(Source::Battery), None, "nothing runs yet");
        arbiter.began(RunId(2), Source::Battery, home());
        // Of equal remedies the one that runs stays.
        arbiter.ask(at(2), Source::LostComms, berth.clone());
        assert_eq!(arbiter.decide(at(9), running(2)), None);
        assert_eq!(arbiter.standing(Source::LostComms), Some((&berth, Standing::Holds)));
        assert_eq!(arbiter.instead(Source::LostComms), Some(&home()));
        assert_eq!(arbiter.instead(Source::Battery), None, "its own runs");
        arbiter.ask(at(10), Source::LostComms, home());
        assert_eq!(
            arbiter.instead(Source::LostComms),
            None,
            "what it asked for runs, though another asked for it"
        );
        arbiter.ask(at(11), Source::LostComms, Remedy::Hold);
        assert_eq!(arbiter.instead(Source::LostComms), Some(&home()));
        // A stop has no run; it is in force all the same.
        arbiter.ask(at(12), Source::Limits, Remedy::Stop);
        assert_eq!(arbiter.decide(at(12), running(2)), Some((Source::Limits, Remedy::Stop)));
        assert_eq!(arbiter.decide(at(13), Picture { run: None, ..SAILING }), None);
        assert_eq!(arbiter.standing(Source::LostComms), Some((&Remedy::Hold, Standing::Holds)));
        assert_eq!(arbiter.instead(Source::LostComms), Some(&Remedy::Stop));
        assert_eq!(arbiter.instead(Source::Limits), None, "its own stop is in force");
        arbiter.withdraw(Source::Limits);
        assert_eq!(arbiter.standing(Source::LostComms), Some((&Remedy::Hold, Standing::Waits(at(14)))));
        arbiter.stepped_in();
        assert_eq!(arbiter.instead(Source::LostComms), None);
    }

    #[test]
    fn what_failed_is_tried_again_until_it_holds() {
        let mut arbiter = Arbiter::default();
        arbiter.ask(at(1), Source::LostComms, Remedy::Hold);
        let adrift = Picture { run: None, ..SAILING };
        let tries: Vec<u64> = (1..8).filter(|second| arbiter.decide(at(*second), adrift).is_some()).collect();
        assert_eq!(tries, [1, 3, 5, 7]);
        assert_eq!(arbiter.standing(Source::LostComms), Some((&Remedy::Hold, Standing::Waits(at(9)))));
        arbiter.began(RunId(4), Source::LostComms, Remedy::Hold);
        assert_eq!(arbiter.decide(at(60), running(4)), None);
        // Its path failed.
        assert_eq!(arbiter.decide(at(61), adrift), Some((Source::LostComms, Remedy::Hold)));
    }

    #[test]
    fn a_stand_in_gives_way_to_what_was_asked_for() {
        let mut arbiter = Arbiter::default();
        arbiter.ask(at(1), Source::Battery, home());
        assert!(arbiter.decide(at(1), SAILING).is_some());
        arbiter.began(RunId(2), Source::Battery, Remedy::Hold);
        assert_eq!(arbiter.decide(at(2), running(2)), None);
        assert_eq!(arbiter.decide(at(3), running(2)), Some((Source::Battery, home())));
        arbiter.began(RunId(3), Source::Battery, home());
        let arrived = Picture { run: None, ended_well: true, under_way: true };
        assert_eq!(arbiter.decide(at(90), arrived), None);
        assert_eq!(arbiter.standing(Source::Battery), Some((&home(), Standing::Settled)));
    }

    #[test]
    fn an_operator_settles_what_was_asked_before() {
        let mut arbiter = Arbiter::default();
        arbiter.ask(at(1), Source::Battery, home());
        assert!(arbiter.decide(at(1), SAILING).is_some());
        arbiter.began(RunId(2), Source::Battery, home());
        arbiter.stepped_in();
        assert_eq!(arbiter.decide(at(9), running(3)), None);
        arbiter.ask(at(10), Source::Battery, Remedy::Hold);
        assert!(arbiter.decide(at(10), running(3)).is_some(), "what comes later counts");
    }

    #[test]
    fn a_supervisor_may_ask_for_less_than_it_did() {
        let mut arbiter = Arbiter::default();
        arbiter.ask(at(1), Source::Battery, home());
        assert!(arbiter.decide(at(1), SAILING).is_some());
        arbiter.began(RunId(2), Source::Battery, home());
        // Not even the way home is left.
        arbiter.ask(at(60), Source::Battery, Remedy::Hold);
        assert_eq!(arbiter.decide(at(60), running(2)), Some((Source::Battery, Remedy::Hold)));
    }

    #[test]
    fn a_vessel_at_rest_stays_so() {
        let mut arbiter = Arbiter::default();
        arbiter.ask(at(1), Source::Battery, home());
        let quay = Picture { run: None, ended_well: false, under_way: false };
        assert_eq!(arbiter.decide(at(5), quay), None);
        assert_eq!(arbiter.standing(Source::Battery), Some((&home(), Standing::AtRest)));
    }
}
