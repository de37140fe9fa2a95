//! Idempotency: a request that a page repeats, because no answer came, is carried out once.
//!
//! A page makes a key for each request. A person's first request with a key is carried out; later ones with the same key
//! get the number of the object made then. [`Once`] looks up and writes in one transaction.

use crate::error::{Error, ErrorKind, Result};
use crate::identity::{Fault, Request};
use api::say;
use sqlx::SqliteConnection;

/// Most characters of a key.
const LETTERS: usize = 64;

/// Kinds of objects that are made by key; their numbers are stored in app.db.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Made {
    /// A note of the log book.
    Note = 0,
    /// A recorded mission.
    Mission = 1,
    /// A no-go area.
    NoGoArea = 2,
}

/// A key of one person for one kind of object.
#[derive(Debug, Clone)]
pub(crate) struct Key {
    made: Made,
    person: i64,
    text: String,
}

impl Key {
    /// The key of a request, if it has one.
    ///
    /// # Errors
    /// It is empty or too long.
    pub(crate) fn new(made: Made, person: i64, key: Option<String>) -> Result<Option<Self>> {
        if key.as_ref().is_some_and(|key| key.is_empty() || key.chars().count() > LETTERS) {
            let text = say("key: give 1 to {most} characters, or leave it out").with("most", LETTERS);
            return Err(Error::new(ErrorKind::Malformed, text));
        }
        Ok(key.map(|text| Self { made, person, text }))
    }
}

/// The number of the object that was made by this key.
impl Request for Key {
    type Answer = Option<i64>;

    async fn run(self, db: &mut SqliteConnection) -> std::result::Result<Option<i64>, Fault> {
        let sql = "SELECT id FROM made_by_key WHERE person = ?1 AND made = ?2 AND key = ?3";
        let query = sqlx::query_scalar(sql).bind(self.person).bind(self.made as i64).bind(self.text);
        Ok(query.fetch_optional(db).await?)
    }
}

/// Makes an object unless it was made by this key before; returns its number.
#[derive(Debug)]
pub(crate) struct Once<R> {
    pub(crate) key: Option<Key>,
    pub(crate) make: R,
}

impl<R: Request<Answer = i64>> Request for Once<R> {
    type Answer = i64;

    async fn run(self, db: &mut SqliteConnection) -> std::result::Result<i64, Fault> {
        let Self { key, make } = self;
        let Some(key) = key else { return make.run(db).await };
        if let Some(first) = key.clone().run(&mut *db).await? {
            return Ok(first);
        }
        let id = make.run(&mut *db).await?;
        let sql = "INSERT INTO made_by_key (person, made, key, id) VALUES (?1, ?2, ?3, ?4)";
        sqlx::query(sql).bind(key.person).bind(key.made as i64).bind(key.text).bind(id).execute(db).await?;
        Ok(id)
    }
}

#[cfg(test)]
mod tests {
    use super::{Key, Made, Once};
    use crate::identity::{Fault, Request, migrated};
    use sqlx::SqliteConnection;

    /// Test request: makes the object of this number, or fails.
    struct Make(Option<i64>);

    impl Request for Make {
        type Answer = i64;

        async fn run(self, _: &mut SqliteConnection) -> Result<i64, Fault> {
            self.0.ok_or_else(|| Fault::refused(api::say("full")))
        }
    }

    #[tokio::test]
    async fn what_a_person_sends_again_by_one_key_is_made_once() {
        let mut db = migrated().await;
        let db = &mut db;
        let once = |made, person, key: Option<&str>, id| Once {
            key: Key::new(made, person, key.map(str::to_owned)).unwrap(),
            make: Make(id),
        };
        once(Made::Note, 7, Some("a"), None).run(db).await.unwrap_err();
        assert_eq!(
            once(Made::Note, 7, Some("a"), Some(1)).run(db).await.unwrap(),
            1,
            "what failed is tried again"
        );
        assert_eq!(once(Made::Note, 7, Some("a"), Some(2)).run(db).await.unwrap(), 1);
        assert_eq!(once(Made::Note, 8, Some("a"), Some(3)).run(db).await.unwrap(), 3, "another person's");
        assert_eq!(once(Made::Note, 7, Some("b"), Some(4)).run(db).await.unwrap(), 4, "another key");
        assert_eq!(once(Made::Mission, 7, Some("a"), Some(5)).run(db).await.unwrap(), 5, "another kind");
        assert_eq!(once(Made::Note, 7, None, Some(6)).run(db).await.unwrap(), 6);
        assert_eq!(
            once(Made::Note, 7, None, Some(7)).run(db).await.unwrap(),
            7,
            "without a key each is its own"
        );
    }

    #[test]
    fn a_key_has_letters_and_a_bound() {
        for wrong in [String::new(), "x".repeat(65)] {
            let told = Key::new(Made::Note, 7, Some(wrong)).unwrap_err();
            assert!(told.text.contains("1 to 64"), "{told}");
        }
        assert!(Key::new(Made::Note, 7, Some("å".repeat(64))).unwrap().is_some());
    }
}
