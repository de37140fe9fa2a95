//! A PostgreSQL that a test starts, kills and asks.

use std::fs;
use std::net::{SocketAddr, TcpListener};
use std::os::unix::fs::MetadataExt as _;
use std::path::PathBuf;
use std::process::Command;
use tempfile::TempDir;

/// A server with a role `lutra`, whose database is `boats`, and a superuser `postgres`; both let in by passwords over TCP.
pub(crate) struct Postgres {
    pub(crate) bin: PathBuf,
    pub(crate) folder: TempDir,
    pub(crate) port: u16,
    pub(crate) options: &'static str,
}

impl Postgres {
    /// Makes and starts one; `None`, and says so, where there is none.
    pub(crate) fn start() -> Option<Self> {
        Self::start_with("-c fsync=off")
    }

    pub(crate) fn start_with(options: &'static str) -> Option<Self> {
        let Some(bin) = newest_bin() else {
            testkit::absent(testkit::Need::Postgres, "apt-get install postgresql");
            return None;
        };
        let folder = TempDir::new().unwrap();
        if let Some((user, group)) = other_user() {
            std::os::unix::fs::chown(folder.path(), Some(user), Some(group)).unwrap();
        }
        fs::write(folder.path().join("password"), "admin").unwrap();
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let postgres = Self { bin, folder, port, options };
        let at = |name: &str| postgres.folder.path().join(name).display().to_string();
        let initdb = [
            "-D",
            &at("data"),
            "-U",
            "postgres",
            "-A",
            "scram-sha-256",
            "--pwfile",
            &at("password"),
            "-E",
            "UTF8",
        ];
        postgres.tool("initdb", &initdb);
        postgres.up();
        postgres.admin("CREATE ROLE lutra LOGIN PASSWORD 'right'");
        postgres.admin("CREATE DATABASE boats OWNER lutra");
        Some(postgres)
    }

    /// A program of PostgreSQL's, which refuses to run as root.
    pub(crate) fn tool(&self, program: &str, arguments: &[&str]) {
        let mut command = match other_user() {
            None => Command::new(self.bin.join(program)),
            Some((user, group)) => {
                let mut command = Command::new("setpriv");
                command.arg(format!("--reuid={user}")).arg(format!("--regid={group}")).arg("--clear-groups");
                command.arg(self.bin.join(program));
                command
            }
        };
        let output = command.args(arguments).current_dir(self.folder.path()).output().unwrap();
        assert!(output.status.success(), "{program}: {}", String::from_utf8_lossy(&output.stderr));
    }

    pub(crate) fn up(&self) {
        let folder = self.folder.path().display();
        let options = format!(
            "-p {} -c listen_addresses=127.0.0.1 -c unix_socket_directories={folder} {}",
            self.port, self.options
        );
        self.tool(
            "pg_ctl",
            &["-D", &format!("{folder}/data"), "-o", &options, "-l", &format!("{folder}/log"), "-w", "start"],
        );
    }

    /// As if its power failed, or in good order.
    pub(crate) fn down(&self, mode: &str) {
        let data = self.folder.path().join("data").display().to_string();
        self.tool("pg_ctl", &["-D", &data, "-m", mode, "-w", "stop"]);
    }

    pub(crate) fn address(&self) -> SocketAddr {
        SocketAddr::from(([127, 0, 0, 1], self.port))
    }

    pub(crate) fn url(&self) -> String {
        format!("postgres://{}/boats", self.address())
    }

    /// What a statement answers, in CSV without a heading; or what is wrong with it.
    pub(crate) fn ask(&self, user: &str, password: &str, sql: &str) -> Result<String, String> {
        // What belongs to the whole server is made before there is a database of ours.
        let is_for_all = sql.starts_with("CREATE DATABASE") || sql.starts_with("CREATE ROLE");
        let database = if is_for_all { "postgres" } else { "boats" };
        let mut command = Command::new(self.bin.join("psql"));
        command.args(["-h", "127.0.0.1", "-p", &self.port.to_string(), "-U", user, "-d", database]);
        command.args(["-v", "ON_ERROR_STOP=1", "-q", "--csv", "-t", "-c", "SET timezone = 'UTC'", "-c", sql]);
        let output = command.env("PGPASSWORD", password).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim_end().to_owned();
        if output.status.success() { Ok(text(&output.stdout)) } else { Err(text(&output.stderr)) }
    }

    pub(crate) fn admin(&self, sql: &str) -> String {
        self.ask("postgres", "admin", sql).unwrap()
    }

    pub(crate) fn say(&self, sql: &str) -> String {
        self.ask("lutra", "right", sql).unwrap()
    }

    /// How many rows a table has; 0 where there is none.
    pub(crate) fn count(&self, table: &str) -> usize {
        let answer = self.ask("lutra", "right", &format!("SELECT count(*) FROM lutra.{table}"));
        answer.ok().and_then(|count| count.parse().ok()).unwrap_or_default()
    }
}

impl Drop for Postgres {
    fn drop(&mut self) {
        let data = self.folder.path().join("data").display().to_string();
        if self.folder.path().join("data/postmaster.pid").exists() {
            self.tool("pg_ctl", &["-D", &data, "-m", "immediate", "-w", "stop"]);
        }
    }
}

/// Where Debian has the programs of the newest version that is installed.
pub(crate) fn newest_bin() -> Option<PathBuf> {
    let versions = fs::read_dir("/usr/lib/postgresql").ok()?;
    let bins = versions.flatten().map(|version| version.path().join("bin"));
    bins.filter(|bin| bin.join("initdb").exists() && bin.join("psql").exists()).max()
}

/// Whom to run it as where the tests run as root.
pub(crate) fn other_user() -> Option<(u32, u32)> {
    if fs::metadata("/proc/self").unwrap().uid() != 0 {
        return None;
    }
    let users = fs::read_to_string("/etc/passwd").unwrap();
    let line = users.lines().find(|line| line.starts_with("postgres:") || line.starts_with("nobody:"))?;
    let mut parts = line.split(':').skip(2).map(|number| number.parse().unwrap());
    Some((parts.next()?, parts.next()?))
}
