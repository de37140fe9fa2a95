//! The command line, one module per subcommand.

mod archive;
mod chart;
mod compress;
mod data;
mod demo;
mod detections;
mod doctor;
mod files;
mod fleet;
mod history;
mod people;
mod plan;
mod prune;
mod register;
mod say;
mod serve;
mod tls;

use crate::config::{self, Config, Overrides};
use clap::{Args, CommandFactory as _, Parser, Subcommand};
use say::{complain, say};
use shore::folder;
use std::path::PathBuf;
use std::process::ExitCode;

/// Exit code of a command for timers if a person must look. As a condition, systemd treats it as a failure; lower codes
/// only skip the unit.
const LOOK: u8 = 255;

/// Lutra's shore server: telemetry, history and control of a fleet of vessels from a browser.
#[derive(Debug, Parser)]
#[command(version, name = "lutra-server")]
struct Arguments {
    #[command(flatten)]
    common: Common,
    #[command(subcommand)]
    command: Command,
}

/// Where the configuration comes from.
#[derive(Debug, Args)]
struct Common {
    /// The configuration; `lutra-server config` prints one with every key explained.
    #[arg(long, global = true, env = "LUTRA_CONFIG", value_name = "FILE")]
    config: Option<PathBuf>,
    /// The folder of archive, history and people [default: lutra-data].
    #[arg(long, global = true, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Set any key of the configuration, like http.max_connections=100. May be repeated.
    #[arg(long, global = true, value_name = "KEY=VALUE", value_parser = key_and_value)]
    set: Vec<(String, String)>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run the server until SIGTERM or Ctrl-C; SIGHUP reads the certificate again.
    Serve(serve::ServeArguments),
    /// Show everything at once: a scratch server and simulated Otters that sail, until Ctrl-C.
    ///
    /// The Otters are lutra-agent processes with plans, which the server also shows to be changed and brought aboard.
    /// Tagged fish swim around them (--no-fish). A log of a mission that another Otter sailed yesterday is made and
    /// brought in, to be replayed (--no-past). About a minute after the last Otter began to sail its link is cut for
    /// a while, and again every few minutes (--no-cut): its terminal says when, the pages show the alarm, what the
    /// vessel will do, and how the gap is filled when the link is back. What there is to look at is printed with its
    /// addresses.
    Demo(demo::DemoArguments),
    /// People: add, list, roles, passwords.
    #[command(subcommand)]
    User(people::UserCommand),
    /// Tokens of scripts and of vessels' links.
    #[command(subcommand)]
    Token(people::TokenCommand),
    /// Vessels that have names.
    #[command(subcommand)]
    Vessel(people::VesselCommand),
    /// A whole fleet from one file: vessels, link tokens, VPN, and a bundle for each boat.
    #[command(subcommand)]
    Fleet(fleet::FleetCommand),
    /// Certificates.
    #[command(subcommand)]
    Tls(tls::TlsCommand),
    /// Read logs into the archive and the history; what is there already is not added again.
    Import(data::ImportArguments),
    /// Write what was recorded as CSV or LSF.
    Export(data::ExportArguments),
    /// Files of detections, in the formats that portals and R packages take.
    #[command(subcommand)]
    Detections(detections::DetectionsCommand),
    /// The register of studies: tables of projects, people, animals, tags, receivers and deployments, in and out.
    #[command(subcommand)]
    Register(register::RegisterCommand),
    /// Rebuild the history from the archive. The server must not run.
    Reindex(data::ReindexArguments),
    /// Copy everything into another folder, also while the server runs.
    Backup(data::BackupArguments),
    /// Make a new data folder of a backup: all or nothing, and only of undamaged files.
    Restore(data::RestoreArguments),
    /// The archive: compress days to which nothing is added.
    #[command(subcommand)]
    Archive(archive::ArchiveCommand),
    /// The history: compress months that are over.
    #[command(subcommand)]
    History(history::HistoryCommand),
    /// Remove old recordings. The server must not run.
    Prune(prune::PruneArguments),
    /// The sea chart: import, list, ask for depths, export.
    Chart(chart::ChartArguments),
    /// Plans without a running server: routes on the sea chart.
    Plan(Box<plan::PlanArguments>),
    /// Check whether all is well, and print remedies where it is not.
    Doctor(doctor::DoctorArguments),
    /// Write manual pages and completions for shells, for packages.
    #[command(hide = true)]
    Manual(manual::ManualArguments),
    /// Print a configuration file with every key, its default and what it means.
    Config {
        /// Print what is in force instead, from file, LUTRA_ variables and flags.
        #[arg(long)]
        effective: bool,
    },
}

impl Command {
    /// Whether it writes to the data folder or a backup of it, and not only to a requested file.
    fn keeps_data(&self) -> bool {
        !matches!(
            self,
            Self::Export(_)
                | Self::Detections(_)
                | Self::Chart(_)
                | Self::Plan(_)
                | Self::Doctor(_)
                | Self::Manual(_)
                | Self::Config { .. }
        )
    }
}

impl Common {
    /// Reads the configuration; `flags` of a subcommand win over everything.
    fn load(&self, flags: Vec<(String, String)>) -> anyhow::Result<Config> {
        let mut overrides = Overrides::from_environment();
        overrides.flags.extend(self.set.iter().cloned());
        if let Some(data) = &self.data {
            overrides.flags.push(("data".to_owned(), data.display().to_string()));
        }
        overrides.flags.extend(flags);
        Ok(config::load(self.config.as_deref(), &overrides)?)
    }

    /// As [`Self::load`], for commands that write to the data folder: a foreign one, or one of a later version, is refused.
    fn load_to_write(&self) -> anyhow::Result<Config> {
        let config = self.load(Vec::new())?;
        folder::check(&config.data)?;
        folder::refuse_newer(&config.data)?;
        Ok(config)
    }
}

/// Reads the command line and runs the command.
pub fn main() -> ExitCode {
    let is_condition = std::env::args_os().any(|argument| argument == "--check");
    if is_condition { condition(run) } else { run() }
}

/// Runs the condition of a systemd unit. For systemd 0 is yes, 255 a failure, and anything between a silent no, which here
/// only 1 may mean: an invalid command line would end with 2, and a panic with 101.
fn condition(run: impl FnOnce() -> ExitCode) -> ExitCode {
    let outcome = std::panic::catch_unwind(std::panic::AssertUnwindSafe(run));
    let is_meant = |code: &ExitCode| [ExitCode::SUCCESS, ExitCode::FAILURE].contains(code);
    outcome.ok().filter(is_meant).unwrap_or(ExitCode::from(LOOK))
}

fn run() -> ExitCode {
    let Arguments { common, command } = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(told) => {
            told.print().ok();
            // Help and version are no errors.
            return ExitCode::from(u8::try_from(told.exit_code()).unwrap_or(LOOK));
        }
    };
    if command.keeps_data() {
        shore::private::begin();
    }
    let outcome = match command {
        Command::Serve(arguments) => serve::serve(&common, &arguments),
        Command::Demo(arguments) => demo::demo(&common, &arguments),
        Command::User(command) => people::user(&common, command),
        Command::Token(command) => people::token(&common, command),
        Command::Vessel(command) => people::vessel(&common, command),
        Command::Fleet(command) => fleet::fleet(&common, command),
        Command::Tls(command) => return tls::tls(&common, command),
        Command::Import(arguments) => data::import(&common, &arguments),
        Command::Export(arguments) => data::export(&common, &arguments),
        Command::Detections(command) => detections::detections(&common, &command),
        Command::Register(command) => register::register(&common, &command),
        Command::Reindex(arguments) => data::reindex(&common, &arguments),
        Command::Backup(arguments) => return data::backup(&common, &arguments),
        Command::Restore(arguments) => data::restore(&common, &arguments),
        Command::Archive(command) => archive::archive(&common, &command),
        Command::History(command) => history::history(&common, &command),
        Command::Chart(arguments) => chart::chart(&common, &arguments),
        Command::Plan(arguments) => plan::plan(&common, &arguments),
        // Their result is the exit code.
        Command::Prune(arguments) => return prune::prune(&common, &arguments),
        Command::Doctor(arguments) => return doctor::doctor(&common, &arguments),
        Command::Manual(arguments) => {
            manual::write(&Arguments::command(), &arguments.folder).map_err(anyhow::Error::from)
        }
        Command::Config { effective: false } => {
            say!("{}", config::DOCUMENTED.trim_end());
            Ok(())
        }
        Command::Config { effective: true } => effective(&common),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            complain!("lutra-server: {}", told(&error));
            if error.is::<Partial>() { ExitCode::from(PARTIAL) } else { ExitCode::FAILURE }
        }
    }
}

/// The exit code of a command that did a part of its work.
const PARTIAL: u8 = 3;

/// A part of the work was done; says which.
#[derive(Debug)]
struct Partial(String);

impl std::fmt::Display for Partial {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Partial {}

fn effective(common: &Common) -> anyhow::Result<()> {
    say!("{}", toml::to_string_pretty(&common.load(Vec::new())?)?.trim_end());
    Ok(())
}

fn key_and_value(text: &str) -> Result<(String, String), String> {
    let (key, value) = text.split_once('=').ok_or("write KEY=VALUE, like http.max_connections=100")?;
    Ok((key.trim().to_owned(), value.trim().to_owned()))
}
/// An error with its causes, none of them twice: many errors include their cause.
fn told(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain().map(ToString::to_string) {
        if cause.starts_with(&text) {
            text = cause;
        } else if !text.contains(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::Context as _;

    #[test]
    fn every_command_of_the_manual_is_one_that_the_program_takes() {
        let wrong = testkit::manual::commands_of("lutra-server").into_iter().filter_map(|said| {
            let why = manual::accepts(&Arguments::command(), &said.words, said.is_whole).err()?;
            Some(format!("{}: {}\n{why}", said.place, said.words.join(" ")))
        });
        let wrong: Vec<_> = wrong.collect();
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }

    #[test]
    fn a_condition_is_quiet_by_one_code_alone() {
        let [yes, no, fault] = [0, 1, LOOK].map(ExitCode::from);
        for (code, expected) in [(0, yes), (1, no), (2, fault), (101, fault), (LOOK, fault)] {
            assert_eq!(condition(|| ExitCode::from(code)), expected, "{code}");
        }
        assert_eq!(condition(|| panic!("a test's own")), fault);
    }

    #[test]
    fn no_cause_is_told_twice() {
        let cause = || std::io::Error::other("no such file");
        let told = |error: anyhow::Result<()>| told(&error.unwrap_err());
        let error = named("/data: no such file", cause());
        assert_eq!(told(Err(error).context("/data")), "/data: no such file");
        assert_eq!(told(Err(cause()).context("cannot start")), "cannot start: no such file");
    }

    /// An error whose text includes its cause's.
    fn named(text: &'static str, cause: std::io::Error) -> anyhow::Error {
        anyhow::Error::from(cause).context(text)
    }
}
