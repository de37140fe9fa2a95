use super::content::What;
use super::judge::{Held, Notified, due};
use super::rows::{Due, ReadTold, Rules};
use super::rule::SigningKey;
use super::service::AGAIN;
use super::{
    Mail, MailTls, Notices, PER_HOUR, Rule, RuleChange, RuleRequest, Settings, Way, Webhooks, webhook,
};
use crate::clock::{Clock, ClockHand};
use crate::identity::testing::NewScript;
use crate::identity::{self, Grants, Language, People, Principal, Via, language};
use crate::owners::Owners;
use api::{AlarmWord, Permission, Role};
use operations::alarms::Priority;
use proptest::prelude::*;
use std::time::Duration;
use tokio::io::{AsyncBufReadExt as _, AsyncReadExt as _, AsyncWriteExt as _, BufReader};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::mpsc;
use units::UtcTime;

const BOAT: u16 = 0x2810;

fn alarm(id: u64, since_us: i64) -> api::Alarm {
    api::Alarm {
        id,
        vessel: Some(BOAT),
        vessel_name: Some("otter-1".to_owned()),
        kind: "not_heard".to_owned(),
        part: String::new(),
        state: "unacknowledged".to_owned(),
        priority: "alarm".to_owned(),
        says: Vec::new(),
        text: "not heard for 30 s".to_owned(),
        cause: String::new(),
        consequence: "it sails on".to_owned(),
        action: "look for it".to_owned(),
        since_us,
        over_us: None,
        count: 1,
        acknowledged: None,
        escalated: false,
        chatters: false,
        shelved: None,
        collapsed: None,
        sounded: 1,
        wants_acknowledgement: true,
    }
}

fn grants(vessel: Option<u16>) -> Grants {
    Grants::new(&[Permission { vessel, role: Role::Viewer }])
}

fn ask(way: Way, target: &str) -> RuleRequest {
    let (least, after) = (Priority::Warning, Duration::ZERO);
    RuleRequest { way, target: target.to_owned(), least, vessel: None, after, also_over: true }
}

fn held(id: i64, change: impl FnOnce(&mut RuleRequest)) -> Held {
    let mut ask = ask(Way::Mail, "nils@example.org");
    change(&mut ask);
    let rule = Rule { id, person: 1, ask, made_us: 0, key: SigningKey(String::new()) };
    Held { rule, grants: grants(None) }
}

fn s(seconds: i64) -> UtcTime {
    UtcTime::from_micros(seconds * 1_000_000)
}

/// The messages that are due at a time; they count as sent from then on.
fn tell(rules: &[Held], standing: &[api::Alarm], told: &mut Notified, now: UtcTime) -> Vec<(i64, u64, What)> {
    let drafts = due(rules, standing, told, now);
    for draft in &drafts {
        told.keep(draft.rule, &draft.content);
    }
    told.forget(rules, standing, now);
    drafts.iter().map(|one| (one.rule, one.alarm.unwrap(), one.content.event)).collect()
}

#[test]
fn a_rule_is_about_what_it_says() {
    let said = || AlarmWord { by: "anna".to_owned(), time_us: 0 };
    let one = |change: &dyn Fn(&mut api::Alarm)| {
        let mut one = alarm(1, 5_000_000);
        change(&mut one);
        one
    };
    let told = |rule: &Held, alarm: api::Alarm| {
        !tell(std::slice::from_ref(rule), &[alarm], &mut Notified::default(), s(100)).is_empty()
    };
    let any = held(1, |_| ());
    assert!(told(&any, one(&|_| ())));
    assert!(told(&any, one(&|alarm| alarm.vessel = None)), "the server's own are for everybody");
    assert!(!told(&any, one(&|alarm| alarm.priority = "caution".to_owned())), "less urgent");
    assert!(!told(&any, one(&|alarm| alarm.acknowledged = Some(said()))), "somebody knows");
    assert!(!told(&any, one(&|alarm| alarm.over_us = Some(6))), "over before anybody was told");
    assert!(!told(&any, one(&|alarm| alarm.collapsed = Some("not_heard".to_owned()))), "part of another");
    let late = held(1, |ask| ask.after = Duration::from_mins(5));
    assert!(!told(&late, one(&|_| ())), "95 s only");
    assert!(told(&late, one(&|alarm| alarm.since_us = -200_000_000)) == (late.rule.made_us < -200_000_000));
    assert!(!told(&held(1, |ask| ask.vessel = Some(7)), one(&|_| ())), "another vessel");
    let mut stranger = held(1, |_| ());
    stranger.grants = grants(Some(7));
    assert!(!told(&stranger, one(&|_| ())), "a vessel that the person may not see");
    let mut young = held(1, |_| ());
    young.rule.made_us = 6_000_000;
    assert!(!told(&young, one(&|_| ())), "it stood before the rule was made");
}

#[test]
fn what_comes_and_goes_is_told_once_and_again_when_it_has_lasted() {
    let rules = [held(1, |_| ())];
    let mut told = Notified::default();
    let over = |id, at| api::Alarm { over_us: Some(at), ..alarm(id, 0) };
    assert_eq!(tell(&rules, &[alarm(1, 0)], &mut told, s(1)), [(1, 1, What::Raised)]);
    assert_eq!(tell(&rules, &[alarm(1, 0)], &mut told, s(2)), []);
    assert_eq!(tell(&rules, &[over(1, 3)], &mut told, s(3)), [(1, 1, What::Over)]);
    assert_eq!(tell(&rules, &[], &mut told, s(4)), []);
    // The same fault as a new alarm within ten minutes.
    for second in 5..603 {
        let standing: &[api::Alarm] = if second % 2 == 0 { &[alarm(2, 5)] } else { &[] };
        assert_eq!(tell(&rules, standing, &mut told, s(second)), [], "at {second} s");
    }
    assert_eq!(tell(&rules, &[alarm(2, 5)], &mut told, s(603)), [(1, 2, What::Raised)]);
    // Dropped by the alarms before its end was seen.
    assert_eq!(tell(&rules, &[], &mut told, s(604)), [(1, 2, What::Over)]);
}

proptest! {
    /// Whatever alarms do: each reported beginning has one reported end, in that order, and alarms that were acknowledged
    /// before are not reported.
    #[test]
    fn nothing_is_told_twice_and_each_end_once(
        changes in prop::collection::vec((0_u64..4, 0_u8..3), 1..80),
        after_s in prop::sample::select(vec![0_u64, 3]),
    ) {
        let rules = [held(1, |ask| ask.after = Duration::from_secs(after_s)), held(2, |ask| ask.also_over = false)];
        let (mut told, mut all) = (Notified::default(), Vec::new());
        let mut standing: Vec<api::Alarm> = Vec::new();
        for (step, (id, change)) in changes.into_iter().enumerate() {
            let now = s(step as i64 + 1);
            let known = standing.iter().position(|one| one.id == id);
            match (known, change) {
                // Each of its own kind, so that none waits for another.
                (None, 0) if !all.iter().any(|(_, before, _)| *before == id) => {
                    standing.push(api::Alarm { kind: format!("k{id}"), ..alarm(id, now.micros()) });
                }
                (Some(at), 1) => {
                    let word = AlarmWord { by: "anna".to_owned(), time_us: now.micros() };
                    standing[at].acknowledged.get_or_insert(word);
                }
                (Some(at), 2) => drop(standing.remove(at)),
                _ => {}
            }
            let new = tell(&rules, &standing, &mut told, now);
            for (_, id, what) in &new {
                let one = standing.iter().find(|one| one.id == *id);
                prop_assert!(*what != What::Raised || one.is_some_and(|one| one.acknowledged.is_none()));
            }
            all.extend(new);
        }
        all.extend(tell(&rules, &[], &mut told, s(1_000)));
        let count = |rule, id, what| all.iter().filter(|one| **one == (rule, id, what)).count();
        for id in 0..4 {
            prop_assert!(count(1, id, What::Raised) <= 1 && count(2, id, What::Raised) <= 1);
            prop_assert_eq!(count(1, id, What::Over), count(1, id, What::Raised));
            prop_assert_eq!(count(2, id, What::Over), 0);
        }
    }
}

/// People, the service, and a person with rules.
struct Office {
    folder: tempfile::TempDir,
    people: People,
    notices: Notices,
    clock: Clock,
    hand: ClockHand,
    nils: Principal,
}

impl Office {
    async fn open(settings: Settings) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (clock, hand) = Clock::with_hand();
        let owners = Owners::new(clock.clone());
        let config = identity::Settings::default();
        let people = People::start(folder.path(), &config, &owners, clock.clone()).await.unwrap().0;
        let script =
            NewScript { name: "nils".to_owned(), vessel: None, role: Role::Viewer, most: Role::Viewer };
        let person = people.change(script).await.unwrap().0;
        let via = Via::Token { id: 1, label: "test".to_owned() };
        let nils = Principal { person, name: "nils".to_owned(), grants: grants(None), language: None, via };
        let notices = Notices::new(people.clone(), clock.clone(), settings);
        Self { folder, people, notices, clock, hand, nils }
    }

    async fn add(&self, ask: RuleRequest) -> super::Made {
        self.notices.add(&self.nils, "::1".to_owned(), ask).await.unwrap()
    }

    /// Processes the active alarms, and sends due messages.
    async fn work(&self, standing: &[api::Alarm], told: &mut Notified) {
        let rules = self.people.ask(Rules).await.unwrap();
        self.notices.tell(&rules, standing, told).await.unwrap();
        for one in self.people.ask(Due { now: self.clock.utc(), id: None }).await.unwrap() {
            self.notices.deliver(one).await;
        }
    }

    /// Outcome and answer of each message, the newest first.
    async fn outcomes(&self) -> Vec<(String, String)> {
        let mine = self.notices.mine(&self.nils).await.unwrap();
        mine.messages.into_iter().map(|one| (one.outcome, one.words)).collect()
    }

    fn alarm(&self, id: u64) -> api::Alarm {
        api::Alarm { kind: format!("k{id}"), ..alarm(id, self.clock.utc().micros()) }
    }
}

/// A server that answers each connection by `answer`; returns its port.
async fn serve<F, A>(answer: F) -> u16
where
    F: Fn(TcpStream) -> A + Send + 'static,
    A: Future<Output = ()> + Send + 'static,
{
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = listener.local_addr().unwrap().port();
    tokio::spawn(async move {
        while let Ok((stream, _)) = listener.accept().await {
            tokio::spawn(answer(stream));
        }
    });
    port
}

/// A webhook that gives these answers in turn, repeating the last; returns its port and the requests, as head and body.
async fn hook(answers: &'static [&'static str]) -> (u16, mpsc::UnboundedReceiver<(String, String)>) {
    let (got, taken) = mpsc::unbounded_channel();
    let count = std::sync::Arc::new(std::sync::atomic::AtomicUsize::new(0));
    let port = serve(move |stream| {
        let (got, count) = (got.clone(), count.clone());
        async move {
            let mut stream = BufReader::new(stream);
            let (mut head, mut length) = (String::new(), 0);
            loop {
                let mut line = String::new();
                stream.read_line(&mut line).await.unwrap();
                if line.trim().is_empty() {
                    break;
                }
                let line = line.to_lowercase();
                if let Some(bytes) = line.strip_prefix("content-length: ") {
                    length = bytes.trim().parse().unwrap();
                }
                head.push_str(&line);
            }
            let mut body = vec![0; length];
            stream.read_exact(&mut body).await.unwrap();
            got.send((head, String::from_utf8(body).unwrap())).ok();
            let number = count.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            let answer = answers[number.min(answers.len() - 1)];
            let text = format!("HTTP/1.1 {answer}\r\ncontent-length: 4\r\nconnection: close\r\n\r\nword");
            stream.get_mut().write_all(text.as_bytes()).await.ok();
        }
    })
    .await;
    (port, taken)
}

fn open_settings() -> Settings {
    Settings { webhooks: Webhooks::Any, url: "https://lutra.example.org/".to_owned(), ..Settings::default() }
}

#[tokio::test]
async fn a_webhook_gets_what_happened_signed_and_the_same_again_when_it_failed() {
    let office = Office::open(open_settings()).await;
    let (port, mut got) = hook(&["500 Sick", "204 Fine"]).await;
    let made = office.add(ask(Way::Webhook, &format!("http://127.0.0.1:{port}/a?b=c"))).await;
    let mut told = Notified::default();
    let standing = [office.alarm(7)];
    office.work(&standing, &mut told).await;
    let (head, body) = got.recv().await.unwrap();
    assert!(head.starts_with("post /a?b=c http/1.1\r\n"), "{head}");
    assert_eq!(
        office.outcomes().await,
        [(String::new(), "it answers 500 Internal Server Error: word".to_owned())]
    );

    office.work(&standing, &mut told).await;
    assert!(got.try_recv().is_err(), "it is not due yet");
    office.hand.advance(AGAIN[0]);
    office.work(&standing, &mut told).await;
    let (again, same) = got.recv().await.unwrap();
    assert_eq!(same, body);
    let value = |head: &str, name: &str| {
        let line = head.lines().find_map(|line| line.strip_prefix(&format!("{name}: "))).unwrap();
        line.to_owned()
    };
    assert_eq!(value(&head, "lutra-delivery"), value(&again, "lutra-delivery"));
    let signature = value(&again, "lutra-signature");
    let seconds = signature[2..].split(',').next().unwrap().parse().unwrap();
    assert_eq!(signature, webhook::signature(&made.secret, seconds, &same));
    let content: serde_json::Value = serde_json::from_str(&body).unwrap();
    assert_eq!((&content["event"], &content["alarm"]["id"]), (&"alarm.raised".into(), &7.into()));
    assert_eq!(office.outcomes().await[0].0, "delivered");

    office.work(&[], &mut told).await;
    assert!(got.recv().await.unwrap().1.contains("alarm.over"));
}

#[tokio::test]
async fn a_message_outlives_a_restart_and_is_not_told_again() {
    let office = Office::open(open_settings()).await;
    let (port, mut got) = hook(&["503 Later", "200 Fine"]).await;
    office.add(ask(Way::Webhook, &format!("http://127.0.0.1:{port}/"))).await;
    let standing = [office.alarm(7)];
    office.work(&standing, &mut Notified::default()).await;
    got.recv().await.unwrap();

    // As after a kill: only app.db is known.
    let owners = Owners::new(office.clock.clone());
    let config = identity::Settings::default();
    let people = People::start(office.folder.path(), &config, &owners, office.clock.clone()).await.unwrap().0;
    let notices = Notices::new(people.clone(), office.clock.clone(), open_settings());
    let office = Office { people, notices, ..office };
    let mut told = office.people.ask(ReadTold(office.clock.utc())).await.unwrap();
    office.hand.advance(AGAIN[0]);
    office.work(&standing, &mut told).await;
    got.recv().await.unwrap();
    assert_eq!(office.outcomes().await, [("delivered".to_owned(), String::new())], "one message");
}

#[tokio::test]
async fn what_a_webhook_refuses_or_leads_elsewhere_is_not_tried_again() {
    let office = Office::open(open_settings()).await;
    for (answer, words) in [
        (&["404 Gone"] as &[_], "it answers 404 Not Found: word"),
        (&["302 Found"], "it answers 302 Found, which is not followed: give the URL it leads to"),
    ] {
        let (port, _got) = hook(answer).await;
        let made = office.add(ask(Way::Webhook, &format!("http://127.0.0.1:{port}/"))).await;
        let test = office.notices.test(&office.nils, made.id).await.unwrap();
        assert_eq!((test.outcome.as_str(), test.words.as_str()), ("refused", words));
    }
}

#[tokio::test]
async fn webhooks_lead_to_public_addresses_only_unless_the_configuration_says_so() {
    let office = Office::open(Settings::default()).await;
    let refused = |url: &'static str| {
        let (notices, nils) = (office.notices.clone(), office.nils.clone());
        async move { notices.add(&nils, String::new(), ask(Way::Webhook, url)).await.err().unwrap().text }
    };
    assert!(refused("http://example.org/").await.contains("https://"));
    assert!(refused("there").await.contains("is not a URL"));
    assert!(refused("https://me:secret@example.org/").await.contains("password"));
    let mail = office.notices.add(&office.nils, String::new(), ask(Way::Mail, "a@example.org")).await;
    assert!(mail.err().unwrap().text.contains("notices.mail.host"));
    // A name that resolves to this computer is detected at lookup.
    let made = office.add(ask(Way::Webhook, "https://localhost:1/")).await;
    let test = office.notices.test(&office.nils, made.id).await.unwrap();
    assert!(test.outcome == "refused" && test.words.contains("not a public address"), "{test:?}");
    assert!(office.notices.test(&office.nils, made.id + 1).await.is_err(), "nobody's rule");
}

#[tokio::test]
async fn many_messages_within_an_hour_end_with_one_that_says_so() {
    let office = Office::open(open_settings()).await;
    let (port, mut got) = hook(&["200 Fine"]).await;
    office.add(ask(Way::Webhook, &format!("http://127.0.0.1:{port}/"))).await;
    let mut told = Notified::default();
    let standing: Vec<api::Alarm> = (0..30).map(|id| office.alarm(id)).collect();
    office.work(&standing, &mut told).await;
    for number in 1..=PER_HOUR {
        let (_, body) = got.recv().await.unwrap();
        assert_eq!(body.contains("\"last_for_an_hour\":true"), number == PER_HOUR, "{number}");
    }
    assert!(got.try_recv().is_err());
    assert!(office.outcomes().await[0].0.starts_with("held back"));
    office.hand.advance(Duration::from_hours(2));
    office.work(&[office.alarm(99)], &mut told).await;
    assert!(got.recv().await.is_some(), "an hour later it tells again");
}

/// A mail server without encryption; returns its port and what came after DATA.
async fn mail_server(refuses: bool) -> (u16, mpsc::UnboundedReceiver<String>) {
    let (got, taken) = mpsc::unbounded_channel();
    let port = serve(move |stream| {
        let got = got.clone();
        async move {
            let mut stream = BufReader::new(stream);
            stream.get_mut().write_all(b"220 test\r\n").await.unwrap();
            let (mut line, mut data) = (String::new(), None::<String>);
            loop {
                line.clear();
                if stream.read_line(&mut line).await.unwrap_or(0) == 0 {
                    return;
                }
                let answer = match (&mut data, line.trim_end()) {
                    (Some(_), ".") => {
                        got.send(data.take().unwrap()).ok();
                        "250 taken"
                    }
                    (Some(data), _) => {
                        data.push_str(&line);
                        continue;
                    }
                    (None, "DATA") => {
                        data = Some(String::new());
                        "354 go on"
                    }
                    (None, text) if text.starts_with("RCPT") && refuses => "550 no such person",
                    (None, "QUIT") => "221 bye",
                    (None, _) => "250 fine",
                };
                stream.get_mut().write_all(format!("{answer}\r\n").as_bytes()).await.unwrap();
            }
        }
    })
    .await;
    (port, taken)
}

fn by_mail(port: u16) -> Settings {
    let mail = Mail {
        host: "127.0.0.1".to_owned(),
        port,
        tls: MailTls::None,
        from: "Lutra <lutra@example.org>".to_owned(),
        ..Mail::default()
    };
    Settings { mail, ..open_settings() }
}

#[tokio::test]
async fn a_mail_says_what_happened_what_to_do_and_where_to_look() {
    let (port, mut got) = mail_server(false).await;
    let office = Office::open(by_mail(port)).await;
    office.add(ask(Way::Mail, "nils@example.org")).await;
    // A vessel may call itself anything.
    let hostile = "otter\r\nBcc: all@example.org";
    let standing = [api::Alarm { vessel_name: Some(hostile.to_owned()), ..office.alarm(7) }];
    office.work(&standing, &mut Notified::default()).await;
    let mail = got.recv().await.unwrap();
    let (head, body) = mail.split_once("\r\n\r\n").unwrap();
    assert!(
        head.contains("Subject: [Lutra] otter  Bcc: all@example.org: not heard for 30 s (alarm)"),
        "{head}"
    );
    assert!(!head.lines().any(|line| line.starts_with("Bcc:")), "{head}");
    assert!(head.contains("To: nils@example.org") && head.contains("Message-ID: <lutra-"), "{head}");
    for words in
        ["What to do: look for it", "https://lutra.example.org/vessels/10256", "If ignored: it sails on"]
    {
        assert!(body.contains(words), "{words} in {body}");
    }
    assert_eq!(office.outcomes().await[0].0, "delivered");
}

/// A boat that is not heard, as the server reports it by codes.
fn silent(alarm: api::Alarm) -> api::Alarm {
    let advice = operations::alarms::Kind::NotHeard.advice();
    let says = vec![api::AlarmSaying::NotHeard { since_us: 3_723_000_000 }];
    let (action, consequence) = (advice.action.to_owned(), advice.consequence.to_owned());
    api::Alarm { says, action, consequence, ..alarm }
}

#[tokio::test]
async fn a_message_comes_in_the_language_that_its_person_chose() {
    let (port, mut mails) = mail_server(false).await;
    let (hook_port, mut posts) = hook(&["204 Fine"]).await;
    let office = Office::open(by_mail(port)).await;
    office.add(ask(Way::Mail, "nils@example.org")).await;
    office.add(ask(Way::Webhook, &format!("http://127.0.0.1:{hook_port}/"))).await;
    let mut told = Notified::default();
    let first = silent(office.alarm(7));
    office.work(std::slice::from_ref(&first), &mut told).await;
    assert!(
        mails.recv().await.unwrap().contains("Subject: [Lutra] otter-1: not heard since 01:02:03Z (alarm)")
    );
    assert!(posts.recv().await.unwrap().1.contains("\"text\":\"not heard since 01:02:03Z\""));

    let choose = language::Choose { person: office.nils.person, language: Some(Language::Bokmal) };
    office.people.change(choose).await.unwrap();
    office.work(&[first, silent(office.alarm(8))], &mut told).await;
    let mail = mails.recv().await.unwrap();
    for words in ["Hva du gj=C3=B8r: ", "Fart=C3=B8y: otter-1"] {
        assert!(mail.contains(words), "{words} in {mail}");
    }
    let body = posts.recv().await.unwrap().1;
    assert!(body.contains("\"text\":\"ikke hørt siden 01:02:03Z\""), "{body}");
    let subject = &office.notices.mine(&office.nils).await.unwrap().messages[0].subject;
    assert_eq!(subject, "[Lutra] otter-1: ikke hørt siden 01:02:03Z (alarm)");
}

#[tokio::test]
async fn a_rule_is_changed_in_its_place_and_keeps_its_key() {
    let office = Office::open(open_settings()).await;
    let (port, mut got) = hook(&["204 Fine"]).await;
    let made = office.add(ask(Way::Webhook, "https://example.org/before")).await;
    let to = |target: String, least| RuleChange {
        target,
        least,
        vessel: Some(BOAT),
        after: Duration::from_mins(5),
        also_over: false,
    };
    let there = format!("http://127.0.0.1:{port}/after");
    let change = |who: Principal, id, change| {
        let notices = office.notices.clone();
        async move { notices.change(&who, String::new(), id, change).await }
    };
    let other = Principal { person: office.nils.person + 1, ..office.nils.clone() };
    assert!(change(other, made.id, to(there.clone(), Priority::Alarm)).await.is_err(), "another's rule");
    let nowhere = to("nowhere".to_owned(), Priority::Alarm);
    assert!(change(office.nils.clone(), made.id, nowhere).await.is_err());
    change(office.nils.clone(), made.id, to(there.clone(), Priority::Alarm)).await.unwrap();
    let rules = office.notices.mine(&office.nils).await.unwrap().rules;
    let wanted = RuleRequest {
        way: Way::Webhook,
        target: there,
        least: Priority::Alarm,
        vessel: Some(BOAT),
        after: Duration::from_mins(5),
        also_over: false,
    };
    assert_eq!((rules.len(), rules[0].id, &rules[0].ask), (1, made.id, &wanted));
    // It is in force from then on, with the key that was shown once.
    let (mut told, standing) = (Notified::default(), [office.alarm(7)]);
    office.work(&standing, &mut told).await;
    assert!(got.try_recv().is_err(), "five minutes have not passed");
    office.hand.advance(Duration::from_mins(6));
    office.work(&standing, &mut told).await;
    let (head, body) = got.recv().await.unwrap();
    let signature = head.lines().find_map(|line| line.strip_prefix("lutra-signature: ")).unwrap();
    let seconds = signature[2..].split(',').next().unwrap().parse().unwrap();
    assert_eq!(signature, webhook::signature(&made.secret, seconds, &body));
}

#[tokio::test]
async fn a_mail_server_that_refuses_or_is_not_there_is_told_in_its_words() {
    let (port, _got) = mail_server(true).await;
    let office = Office::open(by_mail(port)).await;
    let made = office.add(ask(Way::Mail, "nobody@example.org")).await;
    let test = office.notices.test(&office.nils, made.id).await.unwrap();
    assert!(test.outcome == "refused" && test.words.contains("no such person"), "{test:?}");

    let nobody = TcpListener::bind("127.0.0.1:0").await.unwrap().local_addr().unwrap().port();
    let office = Office::open(by_mail(nobody)).await;
    let made = office.add(ask(Way::Mail, "nils@example.org")).await;
    let test = office.notices.test(&office.nils, made.id).await.unwrap();
    assert!(test.outcome.is_empty() && !test.words.is_empty(), "it waits: {test:?}");
    office.hand.advance(Duration::from_hours(25));
    office.work(&[], &mut Notified::default()).await;
    let (outcome, words) = office.outcomes().await.remove(0);
    assert!(outcome == "given up" && !words.is_empty(), "{outcome} {words}");
}

#[tokio::test]
async fn rules_are_their_persons_alone() {
    let office = Office::open(open_settings()).await;
    let made = office.add(ask(Way::Webhook, "https://example.org/secret-path")).await;
    let other = Principal { person: office.nils.person + 1, ..office.nils.clone() };
    assert!(office.notices.mine(&other).await.unwrap().rules.is_empty());
    assert!(office.notices.remove(&other, String::new(), made.id).await.is_err());
    assert!(office.notices.test(&other, made.id).await.is_err());
    let rule = &office.notices.mine(&office.nils).await.unwrap().rules[0];
    let shown = format!("{rule:?}");
    assert!(!shown.contains("secret-path") && !shown.contains(&made.secret), "{shown}");
    office.notices.remove(&office.nils, String::new(), made.id).await.unwrap();
    assert!(office.notices.mine(&office.nils).await.unwrap().rules.is_empty());
    for number in 0..20 {
        office.add(ask(Way::Webhook, &format!("https://example.org/{number}"))).await;
    }
    let more =
        office.notices.add(&office.nils, String::new(), ask(Way::Webhook, "https://example.org/")).await;
    assert!(more.err().unwrap().text.contains("20 rules"));
}
