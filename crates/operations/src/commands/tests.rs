use super::*;
use imc::PacketView;
use imc::messages::{
    EntityParameter, EntityParameters, LogBookEntry, Message, PlanControl, PlanControlOp, PlanControlState,
    PlanControlStateState, PlanControlType, PlanDB, PlanDBInformation, PlanDBOp, PlanDBState, PlanDBType,
    PlanSpecification,
};
use units::LatLon;

const BOAT: Address = Address(0x2810);
const SHORE: Address = Address(0x4001);

fn at(seconds: u64) -> Now {
    let us = seconds * 1_000_000;
    Now { mono: MonoTime::from_micros(us), utc: UtcTime::from_micros(1_790_000_000_000_000 + us as i64) }
}

struct Bench {
    commands: Commands,
}

impl Bench {
    fn new() -> Self {
        Self { commands: Commands::new(SHORE) }
    }

    /// Orders and sends; the command and the packet's message.
    fn order(&mut self, seconds: u64, order: Order, ran: Option<&str>) -> (CommandId, Message) {
        let id = self.commands.begin(at(seconds), BOAT, &nils(), 7, order).unwrap();
        let out = self.commands.accepted(at(seconds), id, ran.map(str::to_owned)).unwrap();
        assert_eq!(out.tag.epoch, 7);
        self.commands.sent(at(seconds), id, say("by {transports}").with("transports", "link"));
        let packet = Packet::decode(&out.packet).unwrap();
        assert_eq!((packet.header.src, packet.header.dst), (SHORE, BOAT));
        (id, packet.message().unwrap().clone())
    }

    fn says(&mut self, seconds: u64, dst: Address, message: impl Into<Message>) {
        self.hears(seconds, BOAT, dst, message);
    }

    fn hears(&mut self, seconds: u64, src: Address, dst: Address, message: impl Into<Message>) {
        let header = Header { src, dst, ..Header::default() };
        let bytes = Packet::new(header, message).encode().unwrap();
        self.commands.evidence(at(seconds), &PacketView::new(&bytes).unwrap());
    }

    fn answers(&mut self, seconds: u64, kind: PlanControlType, to: &Message, info: &str) {
        let Message::PlanControl(to) = to else { panic!("{to:?}") };
        let answer = PlanControl { r#type: kind, info: info.into(), arg: None.into(), ..(**to).clone() };
        self.says(seconds, SHORE, answer);
    }

    fn state(&mut self, seconds: u64, state: PlanControlStateState, plan_id: &str) {
        let state = PlanControlState { state, plan_id: plan_id.into(), ..PlanControlState::default() };
        self.says(seconds, Address(0xFFFF), state);
    }

    fn stages(&self, id: CommandId) -> Vec<Stage> {
        self.commands.get(id).unwrap().steps.iter().map(|step| step.stage).collect()
    }

    fn last(&self, id: CommandId) -> (Stage, String) {
        let step = self.commands.get(id).unwrap().steps.last().unwrap();
        (step.stage, step.in_full().to_string())
    }
}

fn nils() -> OrderedBy {
    OrderedBy { name: "nils".to_owned(), ..OrderedBy::default() }
}

fn start(plan_id: &str) -> Order {
    Order::StartPlan { plan_id: plan_id.to_owned() }
}

const EXECUTING: PlanControlStateState = PlanControlStateState::Executing;
const READY: PlanControlStateState = PlanControlStateState::Ready;

#[test]
fn a_start_goes_from_accepted_to_effect_seen() {
    let mut bench = Bench::new();
    let (id, request) = bench.order(0, start("survey"), None);
    bench.commands.receipt(at(1), id, Receipt::Received);
    // Several answers, with the state of the plan before in between.
    bench.answers(1, PlanControlType::Success, &request, "plan loaded");
    bench.state(1, READY, "older");
    bench.answers(1, PlanControlType::Success, &request, "wp1: executing maneuver");
    assert_eq!(bench.last(id), (Stage::Executing, "plan loaded".to_owned()));
    bench.state(2, EXECUTING, "survey");
    let all = [Stage::Accepted, Stage::Sent, Stage::Received, Stage::Executing, Stage::EffectSeen];
    assert_eq!(bench.stages(id), all);
    // A failure minutes later is another story.
    bench.answers(200, PlanControlType::Failure, &request, "aborted");
    bench.commands.tick(at(300));
    assert_eq!(bench.last(id).0, Stage::EffectSeen);
    assert!(bench.commands.get(id).unwrap().is_over());
}

#[test]
fn without_receipts_the_answers_and_the_state_tell() {
    let mut bench = Bench::new();
    let (id, _) = bench.order(0, start("survey"), None);
    bench.state(3, EXECUTING, "survey");
    assert_eq!(bench.last(id), (Stage::EffectSeen, "executing survey".to_owned()));
}

#[test]
fn what_ran_before_is_no_effect_until_the_vessel_has_answered() {
    let mut bench = Bench::new();
    let (again, request) = bench.order(0, start("survey"), Some("survey"));
    bench.state(1, EXECUTING, "survey");
    assert_eq!(bench.last(again).0, Stage::Sent);
    bench.answers(2, PlanControlType::Success, &request, "plan loaded");
    bench.state(2, EXECUTING, "survey");
    assert_eq!(bench.last(again).0, Stage::EffectSeen);
    let (stop, request) = bench.order(3, Order::StopPlan, None);
    bench.state(3, READY, "");
    assert_eq!(bench.last(stop).0, Stage::Sent, "it did not run, so that nothing was stopped");
    bench.answers(4, PlanControlType::Failure, &request, "no plan is running, request ignored");
    assert_eq!(bench.last(stop), (Stage::Refused, "no plan is running, request ignored".to_owned()));
}

#[test]
fn a_refusal_gives_the_vessels_reason() {
    let mut bench = Bench::new();
    let (id, request) = bench.order(0, start("nowhere"), None);
    bench.answers(1, PlanControlType::Failure, &request, "undefined plan");
    assert_eq!(bench.last(id), (Stage::Refused, "undefined plan".to_owned()));
    let (id, _) = bench.order(2, start("nowhere"), None);
    bench.commands.receipt(at(2), id, Receipt::Refused("another has control".to_owned()));
    assert_eq!(bench.last(id), (Stage::Refused, "another has control".to_owned()));
    // Answers to others, and from others, do not count.
    let (id, request) = bench.order(3, start("survey"), None);
    let Message::PlanControl(to) = &request else { panic!() };
    let answer = PlanControl { r#type: PlanControlType::Failure, ..(**to).clone() };
    bench.says(3, Address(0x4002), answer.clone());
    bench.says(3, SHORE, PlanControl { request_id: 999, ..answer });
    assert_eq!(bench.last(id).0, Stage::Sent);
}

#[test]
fn every_stage_times_out_with_what_was_missing() {
    let mut bench = Bench::new();
    let unsent = bench.commands.begin(at(0), BOAT, &nils(), 7, start("a")).unwrap();
    let (sent, _) = bench.order(0, start("b"), None);
    let (received, _) = bench.order(0, start("c"), None);
    bench.commands.receipt(at(0), received, Receipt::Received);
    let (answered, request) = bench.order(0, start("d"), None);
    bench.answers(0, PlanControlType::Success, &request, "plan loaded");
    bench.commands.tick(at(9));
    assert!([unsent, sent, received, answered].iter().all(|id| !bench.commands.get(*id).unwrap().is_over()));
    bench.commands.tick(at(10));
    assert_eq!(bench.last(received), (Stage::TimedOut, "the vessel has it and does not answer".to_owned()));
    bench.commands.tick(at(15));
    for (id, text) in [
        (unsent, "it was not sent"),
        (sent, "the vessel did not say that it has it"),
        (answered, "the vessel answered, but nothing shows the effect"),
    ] {
        assert_eq!(bench.last(id), (Stage::TimedOut, text.to_owned()));
    }
    let (expired, _) = bench.order(20, start("e"), None);
    bench.commands.receipt(at(30), expired, Receipt::Expired);
    assert_eq!(bench.last(expired).0, Stage::Expired);
    assert_eq!(bench.commands.accepted(at(31), expired, None), None, "it is over");
}

#[test]
fn an_upload_is_done_when_the_digest_is_the_same() {
    let mut bench = Bench::new();
    let plan = PlanSpecification { plan_id: "survey".into(), ..PlanSpecification::default() };
    let md5 = imc::plan_digest::plan_md5(&plan).unwrap().to_vec();
    let no_digest = "says that it stores survey, but gave no digest to compare";
    for (md5, last, text) in [
        (Some(md5), Stage::EffectSeen, "stores survey"),
        (Some(vec![0; 16]), Stage::Refused, "the vessel stores another 'survey': the digests differ"),
        (None, Stage::EffectSeen, no_digest),
    ] {
        let (id, request) = bench.order(0, Order::Upload(Box::new(plan.clone())), None);
        let Message::PlanDB(request) = request else { panic!() };
        let stored = md5.map(|md5| {
            Message::from(PlanDBInformation { plan_id: "survey".into(), md5, ..PlanDBInformation::default() })
        });
        let reply = |r#type, arg: Option<Message>| PlanDB {
            r#type,
            op: PlanDBOp::Set,
            request_id: request.request_id,
            plan_id: "survey".into(),
            arg: arg.into(),
            info: "OK".into(),
        };
        bench.says(1, SHORE, reply(PlanDBType::InProgress, None));
        assert_eq!(bench.last(id).0, Stage::Executing);
        bench.says(1, SHORE, reply(PlanDBType::Success, stored));
        assert_eq!(bench.last(id), (last, text.to_owned()));
    }
}

#[test]
fn the_list_of_plans_is_kept_whoever_asked() {
    let mut bench = Bench::new();
    let one = PlanDBInformation { plan_id: "survey".into(), plan_size: 9, ..PlanDBInformation::default() };
    let state = PlanDBState { plans_info: [one].into_iter().collect(), ..PlanDBState::default() };
    let reply = PlanDB {
        r#type: PlanDBType::Success,
        op: PlanDBOp::GetState,
        request_id: 1,
        arg: Some(Message::from(state)).into(),
        ..PlanDB::default()
    };
    bench.says(0, Address(0x4002), reply.clone());
    assert_eq!(bench.commands.aboard(BOAT).unwrap().plans[0].plan_id, "survey");
    let (id, request) = bench.order(1, Order::List, None);
    let Message::PlanDB(request) = request else { panic!() };
    bench.says(1, SHORE, PlanDB { request_id: request.request_id, ..reply });
    assert_eq!(bench.last(id).0, Stage::EffectSeen);
}

#[test]
fn a_plan_that_a_vessel_says_it_stores_or_removed_is_known_without_asking() {
    let mut bench = Bench::new();
    let plan = PlanSpecification { plan_id: "survey".into(), ..PlanSpecification::default() };
    let md5 = imc::plan_digest::plan_md5(&plan).unwrap().to_vec();
    let stored = |plan_id: &str, md5: &[u8]| PlanDBInformation {
        plan_id: plan_id.into(),
        plan_size: 120,
        change_sname: "lutra".into(),
        md5: md5.to_vec(),
        ..PlanDBInformation::default()
    };
    let done = |op, request_id, plan_id: &str, arg: Option<Message>| PlanDB {
        r#type: PlanDBType::Success,
        op,
        request_id,
        plan_id: plan_id.into(),
        arg: arg.into(),
        info: "OK".into(),
    };
    let known = |bench: &Bench| -> Vec<(String, Vec<u8>)> {
        let plans = bench.commands.aboard(BOAT).into_iter().flat_map(|aboard| &aboard.plans);
        plans.map(|plan| (plan.plan_id.clone(), plan.md5.clone())).collect()
    };
    // Another console's plan, reported to all.
    bench.says(
        0,
        Address(0xFFFF),
        done(PlanDBOp::Set, 9, "transit", Some(stored("transit", &[7; 16]).into())),
    );
    let (id, request) = bench.order(1, Order::Upload(Box::new(plan)), None);
    let Message::PlanDB(request) = request else { panic!() };
    let request = request.request_id;
    bench.says(2, SHORE, done(PlanDBOp::Set, request, "survey", Some(stored("survey", &md5).into())));
    assert_eq!(bench.last(id).0, Stage::EffectSeen);
    assert_eq!(known(&bench), [("survey".to_owned(), md5), ("transit".to_owned(), vec![7; 16])]);
    assert_eq!(bench.commands.aboard(BOAT).unwrap().at, at(2).utc);
    // One of that name takes its place; of one without a digest it is not known what is stored.
    bench.says(3, SHORE, done(PlanDBOp::Set, 9, "survey", Some(stored("survey", &[8; 16]).into())));
    assert_eq!(known(&bench)[0], ("survey".to_owned(), vec![8; 16]));
    bench.says(4, SHORE, done(PlanDBOp::Set, 9, "survey", None));
    assert_eq!(known(&bench), [("transit".to_owned(), vec![7; 16])]);
    bench.says(5, SHORE, done(PlanDBOp::Del, 9, "transit", None));
    assert_eq!((known(&bench), bench.commands.aboard(BOAT).is_some()), (Vec::new(), true));
    // A vessel that stores without end is kept within bounds.
    for number in 0..3_000 {
        let name = format!("p{number:04}");
        bench.says(6, SHORE, done(PlanDBOp::Set, 9, &name, Some(stored(&name, &[1; 16]).into())));
    }
    assert_eq!(known(&bench).len(), 1_000);
    bench.says(7, SHORE, done(PlanDBOp::Clear, 9, "", None));
    assert_eq!(known(&bench), []);
}

#[test]
fn of_many_vessels_the_plans_of_those_are_kept_that_told_last() {
    let mut bench = Bench::new();
    let reply = PlanDB {
        r#type: PlanDBType::Success,
        op: PlanDBOp::GetState,
        arg: Some(Message::from(PlanDBState::default())).into(),
        ..PlanDB::default()
    };
    let others = (1..=2_000).map(Address);
    for (second, vessel) in (0..).zip(others.clone()) {
        bench.hears(second, vessel, SHORE, reply.clone());
        // A vessel that continues to report stays.
        bench.says(second, SHORE, reply.clone());
    }
    assert_eq!(bench.commands.aboard.len(), VESSELS);
    assert!(bench.commands.aboard(BOAT).is_some());
    let kept: Vec<Address> = others.filter(|vessel| bench.commands.aboard(*vessel).is_some()).collect();
    assert_eq!((kept.len(), kept[0]), (VESSELS - 1, Address(1_746)));
}

#[test]
fn parameters_are_set_when_the_vessel_echoes_them() {
    let mut bench = Bench::new();
    let told = |names: &[&str]| EntityParameters {
        name: "Path Control".into(),
        params: names
            .iter()
            .map(|name| EntityParameter { name: (*name).into(), value: "1".into() })
            .collect(),
    };
    let values = |names: &[&str]| names.iter().map(|name| ((*name).to_owned(), "1".to_owned())).collect();
    let set = |names| Order::SetParameters { entity: "Path Control".to_owned(), values: values(names) };
    let (id, _) = bench.order(0, set(&["A", "B"]), None);
    bench.says(0, SHORE, told(&["C"]));
    assert_eq!(bench.last(id).0, Stage::Sent);
    bench.says(1, SHORE, told(&["A"]));
    assert_eq!(bench.last(id), (Stage::Refused, "not taken: B".to_owned()));
    let (id, _) = bench.order(2, Order::QueryParameters { entity: "Path Control".to_owned() }, None);
    bench.says(2, SHORE, told(&["A", "B"]));
    assert_eq!(bench.commands.get(id).unwrap().answer, Some(Answer::Parameters(values(&["A", "B"]))));
    // Refusals are in the log book only, and a query's answer may hold the old value.
    let (id, _) = bench.order(
        2,
        Order::SetParameters {
            entity: "Path Control".to_owned(),
            values: vec![("A".to_owned(), "5.0".to_owned())],
        },
        None,
    );
    assert_eq!(bench.commands.get(id).unwrap().subject, "Path Control: A 1 -> 5.0");
    bench.says(2, SHORE, told(&["A", "B"]));
    assert_eq!(bench.last(id).0, Stage::Sent);
    bench.says(2, SHORE, LogBookEntry { text: "B = 5.0 is refused: x".into(), ..LogBookEntry::default() });
    assert_eq!(bench.last(id).0, Stage::Sent);
    let text = "A = 5.0 is refused: 5 m is above 4 m".into();
    bench.says(2, SHORE, LogBookEntry { text, ..LogBookEntry::default() });
    assert_eq!(bench.last(id), (Stage::Refused, "A: 5 m is above 4 m".to_owned()));
    let (id, _) = bench.order(2, set(&["A"]), None);
    let text = "updating entity parameters: invalid parameter: 'A'".into();
    bench.says(2, Address(0xFFFF), LogBookEntry { text, ..LogBookEntry::default() });
    assert_eq!(bench.last(id), (Stage::Refused, "A: invalid parameter".to_owned()));
    // Saving is not answered: receipt is the last stage.
    let (id, _) = bench.order(3, Order::SaveParameters { entity: "Path Control".to_owned() }, None);
    bench.commands.receipt(at(3), id, Receipt::Received);
    assert!(bench.commands.get(id).unwrap().is_over());
}

#[test]
fn going_somewhere_is_a_plan_that_stays_there() {
    let mut bench = Bench::new();
    let place = LatLon::from_deg(63.4, 10.4).unwrap();
    let (id, message) = bench.order(0, Order::Goto { place, speed_mps: 1.5 }, None);
    let Message::PlanControl(request) = &message else { panic!() };
    assert_eq!(request.op, PlanControlOp::Start);
    let plan = request.arg.of::<PlanSpecification>().unwrap();
    assert_eq!((plan.plan_id.as_str(), plan.maneuvers.len()), (Some(GOTO_PLAN), 2));
    bench.answers(1, PlanControlType::Success, &message, "plan loaded");
    bench.state(1, EXECUTING, GOTO_PLAN);
    assert_eq!(bench.last(id).0, Stage::EffectSeen);
}

#[test]
fn steering_by_hand_begins_as_a_plan_for_this_server_alone_and_ends() {
    let mut bench = Bench::new();
    let (begun, message) = bench.order(0, Order::Teleoperate { by: SHORE }, None);
    let Message::PlanControl(request) = &message else { panic!() };
    let maneuver = request.arg.of::<imc::messages::Teleoperation>().unwrap();
    assert_eq!(maneuver.custom.as_str(), Some(format!("src={}", SHORE.0).as_str()));
    bench.answers(1, PlanControlType::Success, &message, "");
    bench.state(1, EXECUTING, TELEOPERATION_PLAN);
    assert_eq!(bench.last(begun).0, Stage::EffectSeen);
    let (ended, message) = bench.order(
        2,
        Order::EndTeleoperation { why: "the person ended it".to_owned() },
        Some(TELEOPERATION_PLAN),
    );
    assert!(matches!(message, Message::TeleoperationDone(_)));
    bench.state(3, READY, "");
    assert_eq!(bench.last(ended).0, Stage::EffectSeen);
}

#[test]
fn what_timed_out_follows_the_evidence_that_comes_late() {
    let mut bench = Bench::new();
    let (id, request) = bench.order(0, start("survey"), None);
    bench.commands.receipt(at(5), id, Receipt::Unanswered);
    assert_eq!(bench.last(id).0, Stage::TimedOut);
    bench.answers(400, PlanControlType::Success, &request, "plan loaded");
    assert_eq!(bench.last(id), (Stage::Executing, "late: plan loaded".to_owned()));
    assert!(!bench.commands.get(id).unwrap().is_over(), "its effect is looked for");
    bench.state(401, EXECUTING, "survey");
    assert_eq!(bench.last(id), (Stage::EffectSeen, "late: executing survey".to_owned()));
    // A refusal is evidence too.
    let (id, request) = bench.order(500, start("other"), None);
    bench.commands.tick(at(516));
    bench.answers(517, PlanControlType::Failure, &request, "no such plan");
    assert_eq!(bench.last(id), (Stage::Refused, "late: no such plan".to_owned()));
    // Without an answer the state of the vessel counts for a minute: after that it may come from another order.
    let (id, _) = bench.order(600, start("third"), None);
    bench.commands.tick(at(616));
    bench.state(640, EXECUTING, "third");
    assert_eq!(bench.last(id).0, Stage::EffectSeen);
    let (id, _) = bench.order(700, start("fourth"), None);
    bench.commands.tick(at(716));
    bench.state(800, EXECUTING, "fourth");
    assert_eq!(bench.last(id).0, Stage::TimedOut);
}

#[test]
fn nonsense_is_refused_with_the_place() {
    let place = LatLon::from_deg(63.4, 10.4).unwrap();
    for (order, wrong) in [
        (start(""), "plan_id"),
        (start(&"x".repeat(61)), "plan_id"),
        (start("a\nb"), "control characters"),
        (Order::Goto { place, speed_mps: -3.0 }, "speed_mps"),
        (Order::Goto { place, speed_mps: f32::NAN }, "speed_mps"),
        (Order::SetParameters { entity: "x".to_owned(), values: Vec::new() }, "values"),
    ] {
        let refused = Commands::new(SHORE).begin(at(0), BOAT, &nils(), 7, order).unwrap_err();
        assert!(refused.contains(wrong), "{refused}");
    }
}

#[test]
fn what_is_kept_is_bounded_and_no_open_command_goes() {
    let mut bench = Bench::new();
    let (open, _) = bench.order(0, start("open"), None);
    for second in 1..300 {
        let (id, _) = bench.order(second, start("x"), None);
        bench.commands.receipt(at(second), id, Receipt::Expired);
    }
    assert_eq!(bench.commands.of(BOAT).count(), KEPT);
    assert!(bench.commands.get(open).is_some());
    for _ in 1..OPEN {
        bench.order(300, start("y"), None);
    }
    let refused = bench.commands.begin(at(300), BOAT, &nils(), 7, start("z")).unwrap_err();
    assert!(refused.contains("wait"), "{refused}");
}
