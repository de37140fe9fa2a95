//! The language of a person's pages.

use super::fault::Fault;
use super::request::Request;
use sqlx::SqliteConnection;

/// A language of the pages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Language {
    /// English, the language of the source texts.
    #[default]
    English,
    /// Norwegian Bokmål.
    Bokmal,
}

impl Language {
    /// All of them, in the order in which they are offered.
    pub const ALL: [Self; 2] = [Self::English, Self::Bokmal];

    /// By its code of BCP 47; `None` for a language that the pages do not have.
    pub fn by_code(code: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|language| language.code() == code)
    }

    /// The code of BCP 47.
    pub fn code(self) -> &'static str {
        match self {
            Self::English => "en",
            Self::Bokmal => "nb",
        }
    }

    /// What its speakers call it.
    pub fn own_name(self) -> &'static str {
        match self {
            Self::English => "English",
            Self::Bokmal => "Norsk bokmål",
        }
    }
}

/// Sets the language of a person's pages.
#[derive(Debug)]
pub struct Choose {
    /// The person's number.
    pub person: i64,
    /// The language; `None` follows what the browser asks for.
    pub language: Option<Language>,
}

impl Request for Choose {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        let sql = "UPDATE person SET language = ?1 WHERE id = ?2";
        sqlx::query(sql).bind(self.language.map(Language::code)).bind(self.person).execute(db).await?;
        Ok(())
    }
}
