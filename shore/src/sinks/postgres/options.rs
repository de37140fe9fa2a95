//! How a PostgreSQL is reached, of what is configured.

use crate::sinks::{secret, settings};
use crate::tls::trusting;
use anyhow::{Context as _, ensure};
use sqlx::ConnectOptions as _;
use sqlx::postgres::{PgConnectOptions, PgSslMode};

/// What sqlx is given. The password is that of the file, else what the environment variable `PGPASSWORD` holds.
///
/// # Errors
/// What is configured cannot be used; the error names the key and shows no secret.
pub(super) fn options(settings: &settings::Postgres) -> anyhow::Result<PgConnectOptions> {
    let url = &settings.url;
    // No error shows the address: a password may stand in it, also where it does not look like one.
    ensure!(
        !url.contains(['@', '?', '#']) && !url.contains(char::is_whitespace),
        "sinks.postgres.url must be like postgres://host:5432/database, without @, ?, # and spaces; user and password are named by \
         sinks.postgres.user and password_file"
    );
    ensure!(
        url.starts_with("postgres://") || url.starts_with("postgresql://"),
        "sinks.postgres.url must begin with postgres://"
    );
    let options: PgConnectOptions = url.parse().ok().context(
        "sinks.postgres.url is not an address; it must be like postgres://host:5432/database, or \
         postgres://%2Frun%2Fpostgresql/database for a socket",
    )?;
    ensure!(
        options.get_database().is_some_and(|database| !database.is_empty()),
        "sinks.postgres.url names no database; it must be like postgres://host:5432/database"
    );
    let mut options = options.application_name("lutra-server").disable_statement_logging();
    if !settings.user.is_empty() {
        options = options.username(&settings.user);
    }
    if !settings.password_file.as_os_str().is_empty() {
        options = options.password(&secret("sinks.postgres.password_file", &settings.password_file)?);
    }
    if settings.ca_file.as_os_str().is_empty() {
        return Ok(options.ssl_mode(PgSslMode::Disable));
    }
    // A file that cannot be used is said at the start, not when the server is reached.
    trusting("sinks.postgres.ca_file", &settings.ca_file)?;
    Ok(options.ssl_mode(PgSslMode::VerifyFull).ssl_root_cert(&settings.ca_file))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(url: &str) -> anyhow::Result<PgConnectOptions> {
        options(&settings::Postgres { url: url.to_owned(), ..settings::Postgres::default() })
    }

    #[test]
    fn an_address_is_understood_or_refused_without_being_shown() {
        let options = with("postgres://db.example.org:5433/boats").unwrap();
        assert_eq!((options.get_host(), options.get_port()), ("db.example.org", 5433));
        assert_eq!(options.get_database(), Some("boats"));
        let socket = with("postgresql://%2Frun%2Fpostgresql/boats").unwrap();
        assert!(socket.get_socket().is_some_and(|path| path.ends_with("postgresql")));
        for url in [
            "postgres://lutra:hunter2@db/boats",
            "postgres://db/boats?password=hunter2",
            "postgres://db",
            "postgres://hunter2:port/boats",
            "http://hunter2/boats",
        ] {
            let error = format!("{:#}", with(url).unwrap_err());
            assert!(error.contains("sinks.postgres.url") && !error.contains("hunter2"), "{error}");
        }
    }

    #[test]
    fn a_file_that_cannot_be_used_is_named() {
        let mut settings =
            settings::Postgres { url: "postgres://db/boats".to_owned(), ..settings::Postgres::default() };
        settings.password_file = "/none/password".into();
        assert!(
            format!("{:#}", options(&settings).unwrap_err()).contains("sinks.postgres.password_file /none")
        );
        settings = settings::Postgres { password_file: "".into(), ca_file: "/none/ca".into(), ..settings };
        assert!(format!("{:#}", options(&settings).unwrap_err()).contains("sinks.postgres.ca_file /none"));
    }
}
