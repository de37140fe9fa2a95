//! Hostile texts from vessels, on the pages in a browser: STOP stays on the screen, nothing is executed, no page grows
//! wider than its window.

use super::browser_tests::quiet;
use super::testing::{Boats, FIRST, boat, packet};
use crate::serve::serve;
use bytes::Bytes;
use imc::messages::{
    Announce, EntityInfo, EntityParameter, EntityParameters, EntityState, EntityStateState, LogBookEntry,
    LogBookEntryType, Message, PlanControl, PlanControlOp, PlanControlState, PlanControlStateState,
    PlanControlType, PlanDB, PlanDBInformation, PlanDBOp, PlanDBState, PlanDBType, SystemType, TextMessage,
    VehicleState, VehicleStateOpMode, Voltage,
};
use shore::clock;
use shore::identity::vessels;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use testkit::Numbers;

/// Number of hostile systems. The first has a name from people; the last tells the script the round.
const SYSTEMS: u16 = 6;
const TELLER: u16 = 9;

/// What texts are made of.
const PIECES: [&str; 18] = [
    "W",
    "iiii",
    "plan_of_the_fjord_",
    "<img src=x onerror=window.executed=1>",
    "\"><script>window.executed=2</script>",
    "javascript:window.executed=3//",
    "'-window.executed-'",
    "{{7*7}}${7*7}%s%n",
    "</button></div></td>",
    "\u{202e}rotto",
    "\u{200b}\u{feff}",
    "\n2026-01-01T00:00:00Z  INFO all is well\n",
    "\r\t\0\u{7}\u{1b}[2J",
    "Z\u{335}\u{337}\u{321}\u{334}\u{322}\u{315}\u{489}",
    "\u{1f6a4}",
    "سفينة",
    "﷽",
    " ",
];
const LENGTHS: [usize; 6] = [1, 30, 100, 500, 5_000, 40_000];

/// A text of at most `most` bytes, of one repeated piece or of many.
fn text(chance: &mut Numbers, most: usize) -> String {
    let pick = |chance: &mut Numbers, count: usize| chance.within(0.0, count as f64) as usize;
    let length = LENGTHS[pick(chance, LENGTHS.len())].min(most);
    let (one, mixed) = (PIECES[pick(chance, PIECES.len())], chance.share() < 0.5);
    let mut text = String::new();
    loop {
        let piece = if mixed { PIECES[pick(chance, PIECES.len())] } else { one };
        if text.len() + piece.len() > length {
            break text;
        }
        text.push_str(piece);
    }
}

fn plans(chance: &mut Numbers) -> PlanDB {
    let plan = |chance: &mut Numbers| PlanDBInformation {
        plan_id: text(chance, 3_000).into(),
        change_sname: text(chance, 3_000).into(),
        md5: vec![7; 16],
        ..PlanDBInformation::default()
    };
    let plans_info = [plan(chance), plan(chance), plan(chance)].into_iter().collect();
    let state = PlanDBState { plan_count: 3, plans_info, md5: vec![9; 16], ..PlanDBState::default() };
    PlanDB {
        r#type: PlanDBType::Success,
        op: PlanDBOp::GetState,
        arg: Some(Message::from(state)).into(),
        info: text(chance, 3_000).into(),
        ..PlanDB::default()
    }
}

/// All packets of a system in one round.
fn says(number: u16, chance: &mut Numbers) -> Vec<Bytes> {
    let now = clock::now();
    let mut said = boat(number, now);
    let name = text(chance, 5_000);
    let announce = Announce {
        sys_name: name.as_str().into(),
        sys_type: if number.is_multiple_of(2) { SystemType::Usv } else { SystemType::Uuv },
        services: text(chance, 3_000).as_str().into(),
        ..Announce::default()
    };
    let entity = |id: u8, chance: &mut Numbers| {
        let label = text(chance, 3_000).as_str().into();
        let state = if id.is_multiple_of(2) { EntityStateState::Error } else { EntityStateState::Failure };
        let description = text(chance, 5_000).as_str().into();
        let component = text(chance, 200).as_str().into();
        [
            packet(number, 255, now, EntityInfo { id, label, component, ..EntityInfo::default() }),
            packet(number, id, now, EntityState { state, description, ..EntityState::default() }),
        ]
    };
    let kinds = [LogBookEntryType::Info, LogBookEntryType::Error, LogBookEntryType::Critical];
    for r#type in kinds {
        let (words, context) = (text(chance, 40_000), text(chance, 3_000));
        let (words, context) = (words.as_str().into(), context.as_str().into());
        said.push(packet(
            number,
            1,
            now,
            LogBookEntry { r#type, text: words, context, ..LogBookEntry::default() },
        ));
    }
    said.extend((2..6).flat_map(|id| entity(id, chance)));
    let parameter = |chance: &mut Numbers| EntityParameter {
        name: text(chance, 500).as_str().into(),
        value: text(chance, 5_000).as_str().into(),
    };
    let params = [parameter(chance), parameter(chance), parameter(chance)].into_iter().collect();
    said.extend([
        packet(number, 255, now, announce),
        packet(number, 2, now, Voltage { value: f32::INFINITY }),
        packet(
            number,
            1,
            now,
            VehicleState {
                op_mode: VehicleStateOpMode::Error,
                error_ents: text(chance, 5_000).as_str().into(),
                last_error: text(chance, 5_000).as_str().into(),
                ..VehicleState::default()
            },
        ),
        packet(
            number,
            1,
            now,
            PlanControlState {
                state: PlanControlStateState::Executing,
                plan_id: text(chance, 5_000).as_str().into(),
                man_id: text(chance, 5_000).as_str().into(),
                ..PlanControlState::default()
            },
        ),
        packet(
            number,
            1,
            now,
            PlanControl {
                r#type: PlanControlType::Failure,
                op: PlanControlOp::Start,
                info: text(chance, 5_000).as_str().into(),
                ..PlanControl::default()
            },
        ),
        packet(number, 1, now, plans(chance)),
        packet(
            number,
            1,
            now,
            TextMessage {
                origin: text(chance, 500).as_str().into(),
                text: text(chance, 5_000).as_str().into(),
            },
        ),
        packet(number, 1, now, EntityParameters { name: "Navigation".into(), params }),
    ]);
    said
}

/// Lets all systems send the packets of the round, for the duration of the test.
async fn speak(boats: Boats, round: Arc<AtomicU64>) {
    let mut interval = tokio::time::interval(Duration::from_millis(500));
    loop {
        interval.tick().await;
        let now = round.load(Ordering::Relaxed);
        for number in 0..SYSTEMS {
            // The same texts during a round.
            let mut chance = Numbers(now * 1_000 + u64::from(number) + 1);
            chance.share();
            boats.say(says(number, &mut chance)).await;
        }
        let sys_name = format!("round-{now}").as_str().into();
        let told = Announce { sys_name, sys_type: SystemType::Usv, ..Announce::default() };
        boats.say(vec![packet(TELLER, 255, clock::now(), told)]).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn whatever_vessels_say_stop_stays_on_the_screen_and_nothing_is_executed() {
    if !testkit::browser::is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let serving = serve(quiet(folder.path())).await.unwrap();
    let longest = "n".repeat(64);
    let named = vessels::Add { address: FIRST, name: longest, now: clock::now() };
    serving.state.shore.people.change(named).await.unwrap();
    let round = Arc::new(AtomicU64::new(1));
    tokio::spawn(speak(Boats::join(&serving.state.shore.router).await, Arc::clone(&round)));
    let address = format!("http://{}", serving.address);
    let password = serving.first_admin().unwrap().1.to_owned();
    let rounds = std::env::var("LUTRA_FUZZ_ROUNDS").unwrap_or_else(|_| "3".to_owned());
    let script = move || {
        testkit::browser::run("hostile.mjs", &[&address, &password, &rounds], |line| {
            if let Some(next) = line.strip_prefix("round ") {
                round.store(next.parse().unwrap(), Ordering::Relaxed);
            }
        });
    };
    tokio::task::spawn_blocking(script).await.unwrap();
    serving.stop().await;
}
