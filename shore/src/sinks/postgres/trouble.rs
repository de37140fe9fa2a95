//! What PostgreSQL answers, in words that say what to do, and which answers are about a row and not about the way there.

use sqlx::Error;
use sqlx::postgres::{PgDatabaseError, PgSeverity};

/// What a message of it may take.
const LONGEST: usize = 300;

/// Classes of answers that a row causes: data that a column does not hold, constraints, limits.
const OF_ROWS: [&str; 3] = ["22", "23", "54"];
/// What a trigger raises.
const RAISED: &str = "P0001";

/// Whether one of the rows is to blame, so that others can be kept without it.
pub(super) fn is_of_a_row(error: &Error) -> bool {
    code(error).is_some_and(|code| OF_ROWS.iter().any(|class| code.starts_with(class)) || code == RAISED)
}

/// Whether a view cannot be replaced because its columns differ: some go, or have another name, type or place.
pub(super) fn is_of_columns(error: &Error) -> bool {
    code(error).is_some_and(|code| code == "42P16")
}

/// Whether the server answered, so that the connection goes on.
pub(super) fn is_answer(error: &Error) -> bool {
    error.as_database_error().is_some()
}

/// Whether the same statement may work later without any change to the schema or its extensions: locks, deadlocks, no room, a shutdown.
pub(super) fn is_of_the_moment(error: &Error) -> bool {
    code(error).is_some_and(|code| passes(&code))
}

/// Classes of answers that pass; a library that cannot be loaded is in the last of them, and stays away.
fn passes(code: &str) -> bool {
    const MISSING_FILE: &str = "58P01";
    ["08", "25", "40", "53", "55", "57", "58"].iter().any(|class| code.starts_with(class))
        && code != MISSING_FILE
}

fn code(error: &Error) -> Option<String> {
    error.as_database_error()?.code().map(std::borrow::Cow::into_owned)
}

/// What went wrong and what to do; shows no secret.
pub(super) fn explained(error: &Error, user: &str, schema: &str) -> anyhow::Error {
    let Some(answer) =
        error.as_database_error().and_then(|answer| answer.try_downcast_ref::<PgDatabaseError>())
    else {
        return anyhow::anyhow!("{}", unanswered(error));
    };
    anyhow::anyhow!("{}", answered(answer, user, schema))
}

/// The way there is broken.
fn unanswered(error: &Error) -> String {
    match error {
        Error::Io(error) => {
            format!(
                "it is not reached ({error}); look whether it runs and whether sinks.postgres.url names host and port"
            )
        }
        Error::Tls(error) => format!(
            "the encryption fails ({error}); look at sinks.postgres.ca_file and at the name in the server's certificate"
        ),
        Error::Protocol(error) => {
            format!("what answers at sinks.postgres.url does not speak as PostgreSQL does ({})", short(error))
        }
        other => short(&other.to_string()),
    }
}

fn answered(answer: &PgDatabaseError, user: &str, schema: &str) -> String {
    let said = short(answer.message());
    let table = answer.table().map_or_else(String::new, |table| format!("table {schema}.{table}: "));
    match answer.code() {
        "28P01" | "28000" => format!(
            "PostgreSQL refused the login ({said}); look at sinks.postgres.user and password_file, and at its pg_hba.conf"
        ),
        "3D000" => format!(
            "the database is not there ({said}); make it (createdb -E UTF8 -O {user} NAME) or name another by sinks.postgres.url"
        ),
        "42501" => format!(
            "the role {user} lacks a right ({said}); it must own the schema, by its administrator: CREATE SCHEMA {schema} \
             AUTHORIZATION {user}, or where another role owns it ALTER SCHEMA {schema} OWNER TO {user}; \
             GRANT TEMPORARY ON DATABASE … TO {user}"
        ),
        "53100" => format!("its disk is full ({said}); make room there"),
        "53300" => format!("it has no connection left ({said}); raise max_connections or end others"),
        "25006" => {
            format!("it takes no changes ({said}); sinks.postgres.url must name the primary, not a standby")
        }
        "57P01" | "57P02" | "57P03" => format!("it starts or stops ({said})"),
        "42P01" | "42703" | "42804" | "42P10" | "42809" | "428C9" | "0A000" => {
            altered(&format!("{table}{said}"), schema)
        }
        code if answer.severity() == PgSeverity::Panic => format!("it broke down ({code} {said})"),
        code => format!("{table}{said} (SQLSTATE {code})"),
    }
}

/// What PostgreSQL says of an error, and nothing else.
pub(super) fn reason(error: &Error) -> String {
    error.as_database_error().map_or_else(String::new, |answer| short(answer.message()))
}

/// A table takes nothing at all.
pub(super) fn refuses_all(table: &str, why: &str) -> String {
    format!(
        "table {table} refuses every row: {why}; remove the constraint or trigger that does so, or rename the table (ALTER TABLE … \
         RENAME TO …) and a new one is made"
    )
}

/// What stands there is not what the server made.
pub(super) fn altered(what: &str, schema: &str) -> String {
    format!(
        "the schema {schema} is not as the server made it: {what}; undo that, or rename the table (ALTER TABLE … RENAME TO …) \
         and a new one is made, which gets all of the past when DATA/sinks/postgres.json is removed while the server is stopped"
    )
}

fn short(text: &str) -> String {
    text.chars().take(LONGEST).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lock_or_a_full_disk_passes_and_a_missing_function_does_not() {
        for code in ["40P01", "40001", "55P03", "57014", "57P01", "53100", "53300", "25006", "58030"] {
            assert!(passes(code), "{code}");
        }
        for code in ["42883", "42704", "42501", "3F000", "58P01", "0A000", "2BP01", "42P16"] {
            assert!(!passes(code), "{code}");
        }
    }
}
