//! Access from app.db and from memory.

use super::super::db::tests::fresh;
use super::super::language::Choose;
use super::super::request::Request as _;
use super::super::tokens::{Make, MakeLink, Revoke};
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
    db: SqliteConnection,
    register: Register,
    nils: i64,
}

impl World {
    /// With an admin, and with Nils, who is an operator of all vessels.
    async fn new() -> Self {
        let mut db = fresh().await;
        let admin = persons::add(&mut db, "admin", "x", false, at(0)).await.unwrap();
        persons::set_permission(&mut db, admin, None, Some(Role::Admin)).await.unwrap();
        let nils = persons::add(&mut db, "nils", "x", false, at(0)).await.unwrap();
        persons::set_permission(&mut db, nils, None, Some(Role::Operator)).await.unwrap();
        Self { db, register: Register::default(), nils }
    }

    async fn session(&mut self, seconds: i64) -> Secret {
        sessions::begin(&mut self.db, self.nils, "127.0.0.1", "test", LIFE, at(seconds)).await.unwrap()
    }

    async fn token(&mut self, role: Role, vessel: Option<u16>) -> String {
        let new = NewToken { label: "grafana".to_owned(), role, vessel, days: 1 };
        Make { person: self.nils, new, now: at(0) }.run(&mut self.db).await.unwrap().secret
    }

    async fn link(&mut self, vessel: u16, days: Option<u32>) -> api::TokenMade {
        let link = MakeLink { label: "link".to_owned(), vessel, days, now: at(0) };
        link.run(&mut self.db).await.unwrap()
    }

    async fn look(&mut self) -> &Register {
        self.register.catch_up(&mut self.db).await.unwrap();
        &self.register
    }
}

fn known<T: std::fmt::Debug>(found: Found<T>) -> T {
    match found {
        Found::Known(who, _) => who,
        other => panic!("{other:?}"),
    }
}

#[tokio::test]
async fn a_session_ends_when_it_rests_and_at_last() {
    let mut world = World::new().await;
    let secret = world.session(0).await;
    let register = world.look().await;
    assert!(matches!(register.session(&secret, LIFE, at(101)), Found::Over));
    for second in (0..=1_000).step_by(50) {
        assert_eq!(known(register.session(&secret, LIFE, at(second))).name, "nils");
    }
    assert!(matches!(register.session(&secret, LIFE, at(1_001)), Found::Over));
    assert!(matches!(register.session(&Secret::random(), LIFE, at(1)), Found::Unknown));
}

#[tokio::test]
async fn a_use_is_remembered_while_app_db_takes_none() {
    let mut world = World::new().await;
    let secret = world.session(0).await;
    let register = world.look().await;
    let due = |second| match register.session(&secret, LIFE, at(second)) {
        Found::Known(_, due) => due,
        other => panic!("{other:?}"),
    };
    assert_eq!(due(59), None);
    let first = due(60).unwrap();
    assert_eq!(due(61), None, "it is not offered again at once");
    assert_eq!(due(66), Some(first));
    // Another change causes everything to be read again: a use that was never written to app.db is still known.
    world.session(70).await;
    let register = world.look().await;
    assert!(matches!(register.session(&secret, LIFE, at(160)), Found::Known(..)));
    register.written(first, at(160));
    assert!(matches!(register.session(&secret, LIFE, at(219)), Found::Known(_, None)));
}

#[tokio::test]
async fn what_ends_in_app_db_ends_here() {
    let mut world = World::new().await;
    let (secret, token) = (world.session(0).await, world.token(Role::Viewer, None).await);
    known(world.look().await.session(&secret, LIFE, at(1)));
    known(world.look().await.token(&token, at(1)));
    let id = sessions::list(&mut world.db, None).await.unwrap()[0].id;
    sessions::end(&mut world.db, id, None).await.unwrap();
    persons::set_password(&mut world.db, world.nils, "y", false, None).await.unwrap();
    assert!(matches!(world.look().await.session(&secret, LIFE, at(1)), Found::Unknown));
    assert!(
        matches!(world.look().await.token(&token, at(1)), Found::Unknown),
        "a new password ends the old tokens"
    );
}

#[tokio::test]
async fn a_token_acts_within_its_scope_until_it_ends() {
    let mut world = World::new().await;
    let token = world.token(Role::Viewer, Some(7)).await;
    let who = known(world.look().await.token(&token, at(1)));
    assert_eq!((who.grants.on(7), who.grants.on(8)), (Some(Role::Viewer), None));
    assert_eq!(who.actor(), "nils (token grafana)");
    assert!(matches!(world.look().await.token(&token, at(DAY_S)), Found::Over));
    assert!(matches!(world.look().await.token("lutra_api_rubbish", at(1)), Found::Over));
}

#[tokio::test]
async fn a_token_loses_what_its_person_loses() {
    let mut world = World::new().await;
    let token = world.token(Role::Admin, None).await;
    assert_eq!(known(world.look().await.token(&token, at(1))).grants.everywhere(), Some(Role::Operator));
    persons::set_permission(&mut world.db, world.nils, None, Some(Role::Viewer)).await.unwrap();
    assert_eq!(known(world.look().await.token(&token, at(1))).grants.everywhere(), Some(Role::Viewer));
    persons::remove(&mut world.db, "nils").await.unwrap();
    assert!(matches!(world.look().await.token(&token, at(1)), Found::Unknown));
}

#[tokio::test]
async fn a_token_of_somebody_with_a_one_time_password_says_why_it_opens_nothing_yet() {
    let mut world = World::new().await;
    let new = NewToken { label: "first".to_owned(), role: Role::Admin, vessel: None, days: 1 };
    let kari = persons::add(&mut world.db, "kari", "x", true, at(0)).await.unwrap();
    persons::set_permission(&mut world.db, kari, None, Some(Role::Operator)).await.unwrap();
    let token = Make { person: kari, new, now: at(0) }.run(&mut world.db).await.unwrap().secret;
    let Found::Refused(why) = world.look().await.token(&token, at(1)) else { panic!("refused") };
    assert!(why.contains("one-time password") && why.contains("kari"), "{why}");
    // Her first own password does not end tokens made meanwhile.
    persons::set_password(&mut world.db, kari, "y", false, None).await.unwrap();
    assert_eq!(known(world.look().await.token(&token, at(1))).name, "kari");
}

#[tokio::test]
async fn a_vessel_is_expected_while_a_token_that_it_used_is_valid() {
    let mut world = World::new().await;
    world.token(Role::Viewer, Some(9)).await;
    let (_, ends, stays) =
        (world.link(6, None).await, world.link(7, Some(1)).await, world.link(8, None).await);
    assert!(world.look().await.linked(at(1)).is_empty(), "none came in yet");
    for made in [&ends, &stays] {
        known(world.look().await.link(&made.secret, at(1)));
    }
    assert_eq!(world.look().await.linked(at(1)), [7, 8]);
    assert_eq!(world.look().await.linked(at(DAY_S)), [8]);
    Revoke { id: stays.id, person: None }.run(&mut world.db).await.unwrap();
    assert!(world.look().await.linked(at(DAY_S)).is_empty());
}

#[tokio::test]
async fn link_and_api_tokens_do_not_open_each_others_transport() {
    let mut world = World::new().await;
    let (link, script) = (world.link(2068, None).await.secret, world.token(Role::Viewer, None).await);
    let register = world.look().await;
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

#[tokio::test]
async fn names_of_vessels_follow() {
    let mut world = World::new().await;
    let otter = vessels::Add { address: 7, name: "otter".to_owned(), now: at(0) };
    otter.run(&mut world.db).await.unwrap();
    assert_eq!(world.look().await.vessels()[0].name, "otter");
    vessels::Remove(7).run(&mut world.db).await.unwrap();
    assert!(world.look().await.vessels().is_empty());
}

#[tokio::test]
async fn a_language_goes_with_its_person_and_one_that_pages_do_not_speak_is_as_none() {
    let mut world = World::new().await;
    let secret = world.session(0).await;
    let nils = world.nils;
    assert_eq!(known(world.look().await.session(&secret, LIFE, at(1))).language, None);
    for language in [Some(Language::Bokmal), Some(Language::English), None] {
        Choose { person: nils, language }.run(&mut world.db).await.unwrap();
        assert_eq!(known(world.look().await.session(&secret, LIFE, at(1))).language, language);
    }
    sqlx::query("UPDATE person SET language = 'tlh'").execute(&mut world.db).await.unwrap();
    assert_eq!(known(world.look().await.session(&secret, LIFE, at(1))).language, None);
}
