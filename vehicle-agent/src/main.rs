//! The program aboard an Otter.

mod chart;
mod host;
mod journal;
mod net;
mod open_loop;
mod plan;
mod recording;
mod run;
mod say;
mod setup;
mod simulate;
mod store;
mod track;
mod uplink;
mod world;

use crate::say::{complain, say};
use clap::{Parser, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

/// The configuration that is used where none is given.
pub(crate) const OTTER_INI: &str = include_str!("../etc/otter.ini");

/// The program aboard an Otter: navigation, control, plans and supervisors of a small autonomous catamaran.
///
/// Consoles (Neptus, the Lutra server) and other vehicles talk to it in IMC by UDP and TCP.
#[derive(Debug, Parser)]
#[command(version, name = "lutra-agent")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run the vessel in real time until SIGTERM or Ctrl-C; the motors are stopped first.
    ///
    /// In the profile Simulation the hull, motors and sensors are simulated; everything else is the same as
    /// aboard. Prints one line `listening udp=.. tcp=.. announce=..` when others can connect.
    Run(run::RunArguments),
    /// Sail a simulated vessel by a virtual clock, as fast as this computer can.
    ///
    /// Prints track, speed and cross-track error as it goes, and a summary. Without a plan a short
    /// demonstration is sailed. With --open-loop the bare hull answers constant propeller speeds.
    Simulate(Box<simulate::SimulateArguments>),
    /// Feed a recording of `run --record` or `simulate --record` to a new brain and compare every output.
    ///
    /// Ends with 0 when all bytes agree, with 1 and the first difference otherwise.
    Replay {
        /// The recording.
        file: PathBuf,
    },
    /// Read a configuration and print what is in force, where it comes from, and every problem at once.
    ///
    /// Ends with 0 when there is no error, with 1 otherwise.
    Check {
        /// The main file, in DUNE's .ini dialect.
        config: PathBuf,
        /// Profile.
        #[arg(long, default_value = "Simulation")]
        profile: String,
        /// Print JSON instead of text.
        #[arg(long)]
        json: bool,
    },
    /// Convert plans between IMC JSON, GeoJSON and GPX.
    #[command(subcommand)]
    Plan(plan::PlanCommand),
}

fn main() -> ExitCode {
    let outcome = match Arguments::parse().command {
        Command::Run(arguments) => run::run(&arguments),
        Command::Simulate(arguments) => simulate::simulate(&arguments),
        Command::Replay { file } => recording::replay(&file).map(|found| {
            let cut = if found.cut { "; the recording is cut short" } else { "" };
            say!("{} inputs, {} outputs: identical{cut}", found.inputs, found.outputs);
        }),
        Command::Check { config, profile, json } => return check(&config, &profile, json),
        Command::Plan(command) => plan::plan(&command),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            complain!("lutra-agent: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn check(path: &std::path::Path, profile: &str, json: bool) -> ExitCode {
    let config = config::Config::load(&config::Disk, path, &[profile]);
    if json {
        say!("{:#}", config.to_json());
    } else {
        say!("{config}");
        match setup::settings(&config, 0) {
            Ok((_, doubts)) => doubts.iter().for_each(|doubt| say!("doubt: {doubt}")),
            Err(error) => say!("error: {error:#}"),
        }
    }
    if config.report().has_errors() { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
