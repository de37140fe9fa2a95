//! An agent as a child process: finding, starting and ending it, and its last log lines if it ended unexpectedly.
//!
//! An agent ends when its standard input is closed. This program holds the other end: so it stops agents, and they also end
//! if this program is killed. Each is in its own process group, so that Ctrl-C reaches it only through this program.

use super::fleet::Otter;
use anyhow::{Context as _, bail};
use std::fs::{self, File};
use std::io;
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::{ExitStatus, Stdio};
use std::time::Duration;
use tokio::process::{Child, ChildStdin, Command};

/// The program.
const PROGRAM: &str = "lutra-agent";
/// How long an agent may take to stop its motors and close its log before it is killed.
const LONGEST_END: Duration = Duration::from_secs(5);
/// Lines of its log that are shown.
const LINES: usize = 5;

/// Where lutra-agent is: beside this program, else in PATH.
///
/// # Errors
/// It is not found.
pub(super) fn find() -> anyhow::Result<PathBuf> {
    let own = std::env::current_exe().context("cannot tell where this program is")?;
    let beside = own.parent().unwrap_or(Path::new(".")).to_owned();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let mut folders = std::iter::once(beside.clone()).chain(std::env::split_paths(&path));
    let found = folders.find_map(|folder| Some(folder.join(PROGRAM)).filter(|file| is_program(file)));
    let Some(found) = found else {
        bail!(
            "{PROGRAM}, which sails the simulated Otters, is neither in {} nor in PATH: `make demo` builds both, \
             `cargo install --path vehicle-agent` installs it",
            beside.display()
        );
    };
    Ok(found)
}

fn is_program(file: &Path) -> bool {
    fs::metadata(file).is_ok_and(|about| about.is_file() && about.permissions().mode() & 0o111 != 0)
}

/// A running agent. Dropping it kills it.
#[derive(Debug)]
pub(super) struct Agent {
    child: Child,
    /// Its standard input: it runs while this is open.
    input: Option<ChildStdin>,
    log: PathBuf,
}

impl Agent {
    /// Starts the agent of an Otter.
    ///
    /// # Errors
    /// It cannot be started, or its log not be written.
    pub(super) fn start(program: &Path, otter: &Otter, folder: &Path) -> anyhow::Result<Self> {
        let log = otter.log(folder);
        let file = File::options().create(true).append(true).open(&log);
        let file = file.with_context(|| format!("cannot write {}", log.display()))?;
        let mut command = Command::new(program);
        command.arg("run").arg(otter.ini(folder)).arg("--data").arg(otter.data(folder));
        command.args(["--bind", "127.0.0.1", "--end-with-stdin"]);
        command.stdin(Stdio::piped()).stdout(file.try_clone()?).stderr(file);
        command.process_group(0).kill_on_drop(true);
        let mut child = command.spawn().with_context(|| format!("cannot start {}", program.display()))?;
        let input = child.stdin.take();
        Ok(Self { child, input, log })
    }

    /// Its process's number, while it runs.
    pub(super) fn id(&self) -> u32 {
        self.child.id().unwrap_or_default()
    }

    /// Waits for its end.
    pub(super) async fn ended(&mut self) -> io::Result<ExitStatus> {
        self.child.wait().await
    }

    /// Ends it normally, or kills it if that takes too long; returns whether it ended normally.
    pub(super) async fn end(mut self) -> bool {
        self.input.take();
        if tokio::time::timeout(LONGEST_END, self.child.wait()).await.is_ok() {
            return true;
        }
        self.child.kill().await.ok();
        false
    }

    /// The last lines of its log.
    pub(super) fn last_words(&self) -> String {
        let text = fs::read(&self.log).unwrap_or_default();
        let text = String::from_utf8_lossy(&text);
        let lines: Vec<&str> = text.lines().collect();
        lines[lines.len().saturating_sub(LINES)..].join("\n")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_can_be_run_is_a_program() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join(PROGRAM);
        assert!(!is_program(&file) && !is_program(folder.path()));
        fs::write(&file, "x").unwrap();
        assert!(!is_program(&file));
        fs::set_permissions(&file, fs::Permissions::from_mode(0o700)).unwrap();
        assert!(is_program(&file));
    }
}
