//! The program aboard an Otter: it runs [`onboard::Brain`] against the clock, the devices, the network and the disk.
//!
//! `run::Agent` is the main loop and the only owner of the clock. `hull::Hull` gives readings and takes thrust,
//! `motor_gate` stops the motors when the loop stalls. `net`, `disk`, `uplink` and `routing` have their own threads. All
//! decisions about the voyage are in `onboard`. The shore is reached by `link` only.

mod board;
mod clock;
mod device;
mod disk;
mod doctor;
mod due;
mod ending;
mod hardware;
mod hull;
mod io;
mod laws;
mod motor_gate;
mod motors_test;
mod net;
mod open_loop;
mod plan;
mod plot;
mod provision;
mod routing;
mod run;
mod say;
mod sea_chart;
mod setup;
mod simulate;
mod simulate_devices;
mod sniff;
mod track;
mod transports;
mod trial;
mod uplink;
mod vehicle;

use crate::disk::{InUse, recording};
use crate::ending::Fault;
use crate::say::{LogFormat, Voice, complain, say};
use clap::{CommandFactory as _, Parser, Subcommand};
use service::journal::VesselNames;
use std::path::PathBuf;
use std::process::ExitCode;

/// The configuration that is used if none is given.
pub(crate) const OTTER_INI: &str = include_str!("../etc/otter.ini");

const RUN_ENDS: &str = "Exit codes:
  0  ended by a signal: motors stopped, log closed
  1  could not start, or could not close the log
  2  wrong arguments
  3  another agent uses the folder of --data
  4  ended by a fault of its own; the motors were stopped first";

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
    /// Run the vessel in real time until SIGTERM, Ctrl-C or the closing of its terminal (SIGHUP); the motors are
    /// stopped first, then the log is closed.
    ///
    /// In the profile Simulation the hull, motors and sensors are simulated; everything else is the same as
    /// aboard. Prints one line `listening udp=.. tcp=.. announce=..` when others can connect (`off` for what the
    /// configuration has off), and one when it ends. The log goes to standard error.
    #[command(after_help = RUN_ENDS)]
    Run(run::RunArguments),
    /// Sail a simulated vessel with a virtual clock, as fast as this computer can.
    ///
    /// Prints track, speed and cross-track error as it goes, and a summary. Without a plan a short
    /// demonstration is sailed. With --open-loop the bare hull answers constant propeller speeds.
    Simulate(Box<simulate::SimulateArguments>),
    /// Simulate the devices of an Otter on pseudo-terminals, for `run --profile Hardware`, until SIGTERM or Ctrl-C.
    ///
    /// Prints one line `devices gnss=PATH motors=PATH hydrophone=PATH`; the motors' card is behind an adapter, so that its
    /// path is configured as `slcan:PATH`. Lines on standard input break devices: `unplug`, `plug`, `silence`, `babble`,
    /// `nonsense` or `mend`, and `gnss`, `motors` or `hydrophone`; `refuse motors` (no power channel is switched), `restart motors`
    /// (their CAN adapter). `report hydrophone` prints at which instants its clock was set, and so does the end.
    SimulateDevices(simulate_devices::SimulateDevicesArguments),
    /// Check that the vessel is ready to sail: configuration, devices, clock, disk, shore and chart, with remedies.
    ///
    /// Opens the ports of the devices and listens: no motor is commanded, nothing is set or switched. While an agent uses
    /// the data folder no port is opened. Ends with 0 when the vessel can sail, with 1 when something must be fixed first.
    Doctor(doctor::DoctorArguments),
    /// Make this computer a vessel's, from the bundle that `lutra-server fleet bundle` wrote.
    ///
    /// Asks for the passphrase of the bundle, verifies it, writes configuration, token, VPN and chart to the places that the
    /// package uses, and prints what else the boat lacks. All files are on the disk before the first is put in its place; a
    /// second run changes nothing. No service is started.
    Provision(provision::ProvisionArguments),
    /// Try the motors.
    #[command(subcommand)]
    Motors(MotorsCommand),
    /// Feed a recording of `run --record` or `simulate --record` to a new brain and compare every output.
    ///
    /// Ends with 0 when all bytes agree, with 1 and the first difference otherwise.
    Replay {
        /// The recording.
        file: PathBuf,
    },
    /// Read a configuration and print the values in force, where they come from, and every problem at once.
    ///
    /// Also tries the course and speed controller on the model of the hull, and warns when it oscillates or does not reach
    /// the requested speed.
    ///
    /// Ends with 0 when there is no error, with 1 otherwise.
    Check {
        /// The main file, in DUNE's .ini dialect.
        config: PathBuf,
        /// Profile, with the same default as `run`; a boat's is Hardware.
        #[arg(long, default_value = run::SIMULATION)]
        profile: String,
        /// Data folder, as of `run`: values that consoles saved there apply, too.
        #[arg(long)]
        data: Option<PathBuf>,
        /// Print JSON instead of text.
        #[arg(long)]
        json: bool,
    },
    /// Convert plans between IMC JSON, GeoJSON and GPX.
    #[command(subcommand)]
    Plan(plan::PlanCommand),
    /// Print a device's data: from its serial port, a recording, or - for standard input.
    ///
    /// Ends with the recording or the pipe; a port is read until Ctrl-C. The port must not be in use by a running agent.
    #[command(after_help = sniff::HELP)]
    Sniff(sniff::SniffArguments),
    /// Write manual pages and completions for shells, for packages.
    #[command(hide = true)]
    Manual(manual::ManualArguments),
}

#[derive(Debug, Subcommand)]
enum MotorsCommand {
    /// Turn each motor gently for two seconds, after you have confirmed that no one is near, ask which side turned, and
    /// print what to configure. No agent may run meanwhile.
    Test(motors_test::MotorsTestArguments),
}

fn main() -> ExitCode {
    let command = Arguments::parse().command;
    let names = VesselNames::default();
    let voice = match &command {
        Command::Run(run) => say::level(run.log_level.as_deref(), run.quiet)
            .and_then(|level| Voice::start(run.log_format, level, &names)),
        _ => say::level(None, false).and_then(|level| Voice::start(LogFormat::Human, level, &names)),
    };
    // The log runs until everything else has ended.
    let (_voice, outcome) = match voice {
        Ok(voice) => (Some(voice), obey(command, &names)),
        Err(error) => (None, Err(error)),
    };
    match outcome {
        Ok(code) => code,
        Err(error) => {
            complain!("lutra-agent: {error:#}");
            if error.is::<InUse>() {
                ExitCode::from(3)
            } else if error.is::<Fault>() {
                ExitCode::from(4)
            } else {
                ExitCode::FAILURE
            }
        }
    }
}

fn obey(command: Command, names: &VesselNames) -> anyhow::Result<ExitCode> {
    match command {
        Command::Run(arguments) => run::run(&arguments, names)?,
        Command::Simulate(arguments) if arguments.open_loop.is_some() => open_loop::run(&arguments)?,
        Command::Simulate(arguments) => simulate::simulate(&arguments)?,
        Command::Doctor(arguments) => return Ok(doctor::doctor(&arguments)),
        Command::Provision(arguments) => provision::provision(&arguments)?,
        Command::Motors(MotorsCommand::Test(arguments)) => motors_test::motors_test(&arguments)?,
        Command::SimulateDevices(arguments) => simulate_devices::simulate_devices(&arguments)?,
        Command::Replay { file } => {
            let found = recording::replay(&file)?;
            let cut = if found.cut { "; the recording is cut short" } else { "" };
            say!("{} inputs, {} outputs: identical{cut}", found.inputs, found.outputs);
        }
        Command::Check { config, profile, data, json } => {
            return Ok(check(&config, &profile, data.as_deref(), json));
        }
        Command::Plan(command) => plan::plan(&command)?,
        Command::Sniff(arguments) => sniff::sniff(&arguments)?,
        Command::Manual(arguments) => manual::write(&Arguments::command(), &arguments.folder)?,
    }
    Ok(ExitCode::SUCCESS)
}

fn check(path: &std::path::Path, profile: &str, data: Option<&std::path::Path>, json: bool) -> ExitCode {
    let config = match data {
        Some(data) => config::Config::load_aboard(&config::Disk, path, &[profile], data),
        None => config::Config::load(&config::Disk, path, &[profile]),
    };
    let doubts = setup::settings(&config, 0).map(|(settings, mut doubts)| {
        doubts.extend(trial::doubts(&config, &settings));
        doubts
    });
    let fails = config.report().has_errors() || doubts.is_err();
    if json {
        let mut shown = config.to_json();
        shown["doubts"] = doubts.unwrap_or_else(|error| vec![format!("{error:#}")]).into();
        say!("{shown:#}");
    } else {
        say!("{config}");
        say!("checked in the profile {profile}");
        match doubts {
            Ok(doubts) if doubts.is_empty() => {}
            Ok(doubts) => {
                for doubt in &doubts {
                    say!("warning: {doubt}");
                }
                let s = if doubts.len() == 1 { "" } else { "s" };
                say!("{} warning{s} of what these settings do aboard", doubts.len());
            }
            Err(error) => say!("error: {error:#}"),
        }
    }
    if fails { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_of_the_manual_is_one_that_the_program_takes() {
        let wrong = testkit::manual::commands_of("lutra-agent").into_iter().filter_map(|said| {
            let why = manual::accepts(&Arguments::command(), &said.words, said.is_whole).err()?;
            Some(format!("{}: {}\n{why}", said.place, said.words.join(" ")))
        });
        let wrong: Vec<_> = wrong.collect();
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }
}
