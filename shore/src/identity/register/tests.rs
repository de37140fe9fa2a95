//! Who is let in, from what stands in app.db and from what is remembered.

use super::super::db::tests::fresh;
use super::super::tokens::{NewLink, make, make_link, revoke};
use super::super::{sessions, vessels};
use super::*;
use api::NewToken;
use std::time::Duration;

const LIFE: Lifetime = Lifetime { idle: Duration::from_secs(100), whole: Duration::from_secs(1_000) };
const DAY_S: i64 = 86_400;

fn at(seconds: i64) -> UtcTime {
    UtcTime::from_micros(seconds * 1_000_000)
}

struct World {
    db: Connection,
    register: Register,
    nils: i64,
}

impl World {
    /// With an admin, and with Nils, who is an operator of all vessels.
    fn new() -> Self {
        let db = fresh();
        let admin = persons::add(&db, "admin", "x", false, at(0)).unwrap();
        persons::set_permission(&db, admin, None, Some(Role::Admin)).unwrap();
        let nils = persons::add(&db, "nils", "x", false, at(0)).unwrap();
        persons::set_permission(&db, nils, None, Some(Role::Operator)).unwrap();
        Self { db, register: Register::default(), nils }
    }

    fn session(&self, seconds: i64) -> Secret {
        sessions::begin(&self.db, self.nils, "127.0.0.1", "test", LIFE, at(seconds)).unwrap()
    }

    fn token(&self, role: Role, vessel: Option<u16>) -> String {
        let new = NewToken { label: "grafana".to_owned(), role, vessel, days: 1 };
        make(&self.db, self.nils, &new, at(0)).unwrap().secret
    }

    fn link(&self, vessel: u16, days: Option<u32>) -> api::TokenMade {
        make_link(&self.db, &NewLink { label: "link", vessel, days }, at(0)).unwrap()
    }

    fn look(&self) -> &Register {
        self.register.catch_up(&self.db).unwrap();
        &self.register
    }
}

fn known<T: std::fmt::Debug>(found: Found<T>) -> T {
    match found {
        Found::Known(who, _) => who,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_session_ends_when_it_rests_and_at_last() {
    let world = World::new();
    let secret = world.session(0);
    let register = world.look();
    assert!(matches!(register.session(&secret, LIFE, at(101)), Found::Over));
    for second in (0..=1_000).step_by(50) {
        assert_eq!(known(register.session(&secret, LIFE, at(second))).name, "nils");
    }
    assert!(matches!(register.session(&secret, LIFE, at(1_001)), Found::Over));
    assert!(matches!(register.session(&Secret::random(), LIFE, at(1)), Found::Unknown));
}

#[test]
fn a_use_is_remembered_while_app_db_takes_none() {
    let world = World::new();
    let secret = world.session(0);
    let register = world.look();
    let due = |second| match register.session(&secret, LIFE, at(second)) {
        Found::Known(_, due) => due,
        other => panic!("{other:?}"),
    };
    assert_eq!(due(59), None);
    let first = due(60).unwrap();
    assert_eq!(due(61), None, "it is not offered again at once");
    assert_eq!(due(66), Some(first));
    // Something else changes, so that everything is read anew: what app.db never got is still known.
    world.session(70);
    let register = world.look();
    assert!(matches!(register.session(&secret, LIFE, at(160)), Found::Known(..)));
    register.written(first, at(160));
    assert!(matches!(register.session(&secret, LIFE, at(219)), Found::Known(_, None)));
}

#[test]
fn what_ends_in_app_db_ends_here() {
    let world = World::new();
    let (secret, token) = (world.session(0), world.token(Role::Viewer, None));
    known(world.look().session(&secret, LIFE, at(1)));
    known(world.look().token(&token, at(1)));
    let id = sessions::list(&world.db, None).unwrap()[0].id;
    sessions::end(&world.db, id, None).unwrap();
    persons::set_password(&world.db, world.nils, "y", false, None).unwrap();
    assert!(matches!(world.look().session(&secret, LIFE, at(1)), Found::Unknown));
    assert!(
        matches!(world.look().token(&token, at(1)), Found::Unknown),
        "a new password ends the old tokens"
    );
}

#[test]
fn a_token_acts_within_its_scope_until_it_ends() {
    let world = World::new();
    let token = world.token(Role::Viewer, Some(7));
    let who = known(world.look().token(&token, at(1)));
    assert_eq!((who.grants.on(7), who.grants.on(8)), (Some(Role::Viewer), None));
    assert_eq!(who.actor(), "nils (token grafana)");
    assert!(matches!(world.look().token(&token, at(DAY_S)), Found::Over));
    assert!(matches!(world.look().token("lutra_api_rubbish", at(1)), Found::Over));
}

#[test]
fn a_token_loses_what_its_person_loses() {
    let world = World::new();
    let token = world.token(Role::Admin, None);
    let role = || known(world.look().token(&token, at(1))).grants.everywhere();
    assert_eq!(role(), Some(Role::Operator));
    persons::set_permission(&world.db, world.nils, None, Some(Role::Viewer)).unwrap();
    assert_eq!(role(), Some(Role::Viewer));
    persons::remove(&world.db, "nils").unwrap();
    assert!(matches!(world.look().token(&token, at(1)), Found::Unknown));
}

#[test]
fn a_token_of_somebody_with_a_one_time_password_says_why_it_opens_nothing_yet() {
    let world = World::new();
    let new = NewToken { label: "first".to_owned(), role: Role::Admin, vessel: None, days: 1 };
    let kari = persons::add(&world.db, "kari", "x", true, at(0)).unwrap();
    persons::set_permission(&world.db, kari, None, Some(Role::Operator)).unwrap();
    let token = make(&world.db, kari, &new, at(0)).unwrap().secret;
    let Found::Refused(why) = world.look().token(&token, at(1)) else { panic!("refused") };
    assert!(why.contains("one-time password") && why.contains("kari"), "{why}");
    // The first password of her own is no reason to end what was made meanwhile.
    persons::set_password(&world.db, kari, "y", false, None).unwrap();
    assert_eq!(known(world.look().token(&token, at(1))).name, "kari");
}

#[test]
fn a_vessel_is_expected_while_a_token_that_it_used_is_valid() {
    let world = World::new();
    world.token(Role::Viewer, Some(9));
    let (_, ends, stays) = (world.link(6, None), world.link(7, Some(1)), world.link(8, None));
    assert!(world.look().linked(at(1)).is_empty(), "none came in yet");
    for made in [&ends, &stays] {
        known(world.look().link(&made.secret, at(1)));
    }
    assert_eq!(world.look().linked(at(1)), [7, 8]);
    assert_eq!(world.look().linked(at(DAY_S)), [8]);
    revoke(&world.db, stays.id, None).unwrap();
    assert!(world.look().linked(at(DAY_S)).is_empty());
}

#[test]
fn link_and_api_tokens_do_not_open_each_others_door() {
    let world = World::new();
    let (link, script) = (world.link(2068, None).secret, world.token(Role::Viewer, None));
    let register = world.look();
    assert_eq!(known(register.link(&link, at(1))), 2068);
    let as_script = link.replace(LINK_PREFIX, API_PREFIX);
    let as_link = script.replace(API_PREFIX, LINK_PREFIX);
    for disguised in [&link, &as_script] {
        assert!(matches!(register.token(disguised, at(1)), Found::Over), "{disguised}");
    }
    for disguised in [&script, &as_link] {
        assert!(matches!(register.link(disguised, at(1)), Found::Over), "{disguised}");
    }
}

#[test]
fn names_of_vessels_follow() {
    let world = World::new();
    vessels::add(&world.db, 7, "otter", at(0)).unwrap();
    assert_eq!(world.look().vessels()[0].name, "otter");
    vessels::remove(&world.db, 7).unwrap();
    assert!(world.look().vessels().is_empty());
}
