//! Rules and messages in app.db.

use super::content::Content;
use super::judge::{Draft, Held, Notified};
use super::rule::{PER_HOUR, Rule, RuleRequest, SigningKey, Way};
use crate::identity::{Fault, Language, Request, persons};
use api::{Fixed, fixed, say};
use operations::alarms::Priority;
use sqlx::SqliteConnection;
use std::time::Duration;
use units::UtcTime;

/// Rules of one person.
const RULES: i64 = 20;
/// Most settled messages of one rule that are kept.
const KEPT: i64 = 200;
const HOUR_US: i64 = 3_600_000_000;
/// Messages older than this are not read when the server starts.
const FORGOTTEN_US: i64 = 30 * 24 * HOUR_US;
/// Outcome of a message beyond [`PER_HOUR`].
const HELD_BACK: &str = "held back: many within an hour";

/// The error for a rule of another person, or one that does not exist.
pub(super) const NO_RULE: Fixed = fixed("You have no such rule.");

type FoundDelivery = (i64, i64, String, Option<String>, String);
type FoundLanguage = Option<Option<String>>;
type FoundRule = (i64, i64, String, String, String, String, Option<u16>, i64, bool, i64);

const RULE: &str =
    "SELECT id, person, way, target, secret, least, vessel, after_s, also_over, made_us FROM notice_rule ";

/// Rules of a newer server that this one does not know are left out.
fn rule(found: FoundRule) -> Option<Rule> {
    let (id, person, way, target, secret, least, vessel, after_s, also_over, made_us) = found;
    let (way, least) = (Way::named(&way)?, Priority::named(&least)?);
    let after = Duration::from_secs(u64::try_from(after_s).ok()?);
    Some(Rule {
        id,
        person,
        ask: RuleRequest { way, target, least, vessel, after, also_over },
        made_us,
        key: SigningKey(secret),
    })
}

/// The language that a person chose; English for one who left it to the browser, which sends no mail.
async fn language(db: &mut SqliteConnection, person: i64) -> Result<Language, Fault> {
    let sql = "SELECT language FROM person WHERE id = ?1";
    let found: FoundLanguage = sqlx::query_scalar(sql).bind(person).fetch_optional(db).await?;
    Ok(found.flatten().and_then(|code| Language::by_code(&code)).unwrap_or_default())
}

/// A message and its outcome, for the rule's owner.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Delivery {
    /// The number of its rule.
    pub rule: i64,
    /// When it was written, µs since 1970 UTC.
    pub made_us: i64,
    /// Its subject, one line.
    pub subject: String,
    /// `delivered`, `refused`, `given up`, `held back …`, or empty while it waits.
    pub outcome: String,
    /// The last answer of the other side.
    pub words: String,
}

/// All rules of a person, and the newest messages.
#[derive(Debug)]
pub(super) struct Mine {
    pub(super) person: i64,
    pub(super) messages: u32,
}

impl Request for Mine {
    type Answer = (Vec<Rule>, Vec<Delivery>);

    async fn run(self, db: &mut SqliteConnection) -> Result<Self::Answer, Fault> {
        let sql = sqlx::AssertSqlSafe(format!("{RULE} WHERE person = ?1 ORDER BY id"));
        let rules: Vec<FoundRule> = sqlx::query_as(sql).bind(self.person).fetch_all(&mut *db).await?;
        let sql = "SELECT rule, notice.made_us, body, outcome, words FROM notice
                   JOIN notice_rule ON notice_rule.id = rule WHERE person = ?1 ORDER BY notice.id DESC LIMIT ?2";
        let found: Vec<FoundDelivery> =
            sqlx::query_as(sql).bind(self.person).bind(self.messages).fetch_all(&mut *db).await?;
        let language = language(db, self.person).await?;
        let delivery = |(rule, made_us, body, outcome, words): FoundDelivery| {
            let content: Option<Content> = serde_json::from_str(&body).ok();
            let subject = content.map(|content| content.subject(language)).unwrap_or_default();
            Delivery { rule, made_us, subject, outcome: outcome.unwrap_or_default(), words }
        };
        Ok((rules.into_iter().filter_map(rule).collect(), found.into_iter().map(delivery).collect()))
    }
}

/// Makes a rule; its number.
#[derive(Debug)]
pub(super) struct Add {
    pub(super) person: i64,
    pub(super) ask: RuleRequest,
    pub(super) key: SigningKey,
    pub(super) now: UtcTime,
}

impl Request for Add {
    type Answer = i64;

    async fn run(self, db: &mut SqliteConnection) -> Result<i64, Fault> {
        let Self { person, ask, key, now } = self;
        let sql = "SELECT count(*) FROM notice_rule WHERE person = ?1";
        let rules: i64 = sqlx::query_scalar(sql).bind(person).fetch_one(&mut *db).await?;
        if rules >= RULES {
            return Err(Fault::refused(say("You have {n} rules: remove one first.").with("n", RULES)));
        }
        let sql = "INSERT INTO notice_rule (person, way, target, secret, least, vessel, after_s, also_over, made_us)
                   VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)";
        let insert = sqlx::query(sql).bind(person).bind(ask.way.name()).bind(ask.target).bind(key.0);
        let insert = insert.bind(ask.least.name()).bind(ask.vessel);
        let insert = insert.bind(ask.after.as_secs().cast_signed()).bind(ask.also_over).bind(now.micros());
        Ok(insert.execute(db).await?.last_insert_rowid())
    }
}

/// Changes a rule of a person. Its way and signing key stay.
#[derive(Debug)]
pub(super) struct Change {
    pub(super) person: i64,
    pub(super) id: i64,
    pub(super) ask: RuleRequest,
}

impl Request for Change {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        let Self { person, id, ask } = self;
        // Its creation time stays, so that active alarms that were not reported yet are not lost by a change.
        let sql = "UPDATE notice_rule SET target = ?3, least = ?4, vessel = ?5, after_s = ?6, also_over = ?7
                   WHERE id = ?1 AND person = ?2";
        let update = sqlx::query(sql).bind(id).bind(person).bind(ask.target).bind(ask.least.name());
        let update = update.bind(ask.vessel).bind(ask.after.as_secs().cast_signed()).bind(ask.also_over);
        let changed = update.execute(db).await?.rows_affected();
        if changed == 0 { Err(Fault::refused(NO_RULE)) } else { Ok(()) }
    }
}

/// Removes a rule of a person, with its messages.
#[derive(Debug)]
pub(super) struct Remove {
    pub(super) person: i64,
    pub(super) id: i64,
}

impl Request for Remove {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        let sql = "DELETE FROM notice_rule WHERE id = ?1 AND person = ?2";
        let gone = sqlx::query(sql).bind(self.id).bind(self.person).execute(db).await?.rows_affected();
        if gone == 0 { Err(Fault::refused(NO_RULE)) } else { Ok(()) }
    }
}

/// All rules, each with its owner's permissions.
#[derive(Debug)]
pub(super) struct Rules;

impl Request for Rules {
    type Answer = Vec<Held>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<Held>, Fault> {
        let sql = sqlx::AssertSqlSafe(format!("{RULE} ORDER BY person, id"));
        let found: Vec<FoundRule> = sqlx::query_as(sql).fetch_all(&mut *db).await?;
        let mut held: Vec<Held> = Vec::new();
        for rule in found.into_iter().filter_map(rule) {
            let known = held.last().filter(|before| before.rule.person == rule.person);
            let grants = match known {
                Some(before) => before.grants.clone(),
                None => persons::grants(&mut *db, rule.person).await?,
            };
            held.push(Held { rule, grants });
        }
        Ok(held)
    }
}

/// Messages from before the server started.
#[derive(Debug)]
pub(super) struct ReadTold(pub(super) UtcTime);

impl Request for ReadTold {
    type Answer = Notified;

    async fn run(self, db: &mut SqliteConnection) -> Result<Notified, Fault> {
        let sql = "SELECT rule, body FROM notice WHERE alarm IS NOT NULL AND made_us > ?1 ORDER BY id";
        let since = self.0.micros() - FORGOTTEN_US;
        let found: Vec<(i64, String)> = sqlx::query_as(sql).bind(since).fetch_all(db).await?;
        let mut told = Notified::default();
        for (rule, body) in found {
            if let Ok(content) = serde_json::from_str(&body) {
                told.keep(rule, &content);
            }
        }
        Ok(told)
    }
}

/// Stores messages to be sent; those of removed rules are left out. Returns the number of the last one.
#[derive(Debug)]
pub(super) struct Put {
    pub(super) drafts: Vec<Draft>,
    pub(super) now: UtcTime,
    /// When it is due.
    pub(super) due: UtcTime,
}

impl Request for Put {
    type Answer = i64;

    async fn run(self, db: &mut SqliteConnection) -> Result<i64, Fault> {
        let mut last = 0;
        for Draft { rule, alarm, mut content } in self.drafts {
            let sql = "SELECT count(*) FROM notice WHERE rule = ?1 AND made_us > ?2 AND outcome IS NOT ?3";
            let since = self.now.micros() - HOUR_US;
            let count = sqlx::query_scalar(sql).bind(rule).bind(since).bind(HELD_BACK);
            let made: i64 = count.fetch_one(&mut *db).await?;
            let made = usize::try_from(made).unwrap_or(PER_HOUR);
            content.last_for_an_hour = made + 1 == PER_HOUR;
            let held_back = (made >= PER_HOUR).then_some((HELD_BACK, self.now.micros()));
            let sql = "INSERT INTO notice (rule, alarm, what, body, made_us, due_us, outcome, outcome_us)
                       SELECT id, ?2, ?3, ?4, ?5, ?6, ?7, ?8 FROM notice_rule WHERE id = ?1";
            let insert =
                sqlx::query(sql).bind(rule).bind(alarm.map(u64::cast_signed)).bind(content.event.name());
            let insert = insert.bind(serde_json::to_string(&content).unwrap_or_default());
            let insert = insert.bind(self.now.micros()).bind(self.due.micros());
            let insert = insert.bind(held_back.map(|one| one.0)).bind(held_back.map(|one| one.1));
            last = insert.execute(&mut *db).await?.last_insert_rowid();
            let sql = "DELETE FROM notice WHERE rule = ?1 AND outcome IS NOT NULL AND id <=
                       (SELECT id FROM notice WHERE rule = ?1 ORDER BY id DESC LIMIT 1 OFFSET ?2)";
            sqlx::query(sql).bind(rule).bind(KEPT).execute(&mut *db).await?;
        }
        Ok(last)
    }
}

/// A message to be sent.
#[derive(Debug, Clone)]
pub(super) struct Waiting {
    pub(super) id: i64,
    pub(super) rule: Rule,
    pub(super) content: Content,
    /// The language of the rule's owner.
    pub(super) language: Language,
    pub(super) made_us: i64,
    pub(super) tries: u32,
}

/// Messages that are due, the oldest first; with `id` only that one, due or not.
#[derive(Debug)]
pub(super) struct Due {
    pub(super) now: UtcTime,
    pub(super) id: Option<i64>,
}

impl Request for Due {
    type Answer = Vec<Waiting>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Vec<Waiting>, Fault> {
        type Found = (i64, i64, String, i64, u32);
        let sql = "SELECT id, rule, body, made_us, tries FROM notice
                   WHERE outcome IS NULL AND (due_us <= ?1 OR id = ?2) AND (?2 IS NULL OR id = ?2) ORDER BY due_us, id LIMIT 32";
        let found: Vec<Found> =
            sqlx::query_as(sql).bind(self.now.micros()).bind(self.id).fetch_all(&mut *db).await?;
        let mut waiting = Vec::new();
        for (id, number, body, made_us, tries) in found {
            let sql = sqlx::AssertSqlSafe(format!("{RULE} WHERE id = ?1"));
            let of: Option<FoundRule> = sqlx::query_as(sql).bind(number).fetch_optional(&mut *db).await?;
            if let (Some(rule), Ok(content)) = (of.and_then(rule), serde_json::from_str(&body)) {
                let language = language(&mut *db, rule.person).await?;
                waiting.push(Waiting { id, rule, content, language, made_us, tries });
            }
        }
        Ok(waiting)
    }
}

/// Stores the result of an attempt: an outcome, or the time of the next attempt.
#[derive(Debug)]
pub(super) struct Settle {
    pub(super) id: i64,
    pub(super) words: String,
    pub(super) outcome: Result<&'static str, UtcTime>,
    pub(super) now: UtcTime,
}

impl Request for Settle {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        let sql = "UPDATE notice SET tries = tries + 1, words = ?2, outcome = ?3, outcome_us = ?4, due_us = coalesce(?5, due_us)
                   WHERE id = ?1 AND outcome IS NULL";
        let query = sqlx::query(sql).bind(self.id).bind(self.words).bind(self.outcome.ok());
        let at = self.outcome.is_ok().then_some(self.now.micros());
        query.bind(at).bind(self.outcome.err().map(UtcTime::micros)).execute(db).await?;
        Ok(())
    }
}
