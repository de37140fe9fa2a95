//! `lutra-agent doctor`: checks that the vessel is ready to sail, and prints remedies.
//!
//! It checks the configuration, the devices, the clock, the disk, the connection to the shore and the chart, with the same
//! code as under way. It commands and sets nothing: it only listens to the compass and the motor card, and asks the
//! hydrophone for its firmware. A serial CAN adapter is sent the bus speed and opened, as it is silent otherwise. While an
//! agent uses the data folder no port is opened at all: a CAN bus lets any number of programs send.

mod devices;
mod finding;

pub(crate) use finding::{Finding, Status, print};

use crate::clock::Clock;
use crate::disk::{DataLock, Host, InUse};
use crate::sea_chart::ChartFolder;
use crate::setup;
use crate::trial;
use crate::uplink::{self, UplinkSettings};
use clap::Args;
use config::Config;
use onboard::Chart;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// Below this a mission's log may not fit (MiB).
const LITTLE_DISK_MIB: f64 = 1024.0;
/// Below this the vessel must not sail (MiB).
const NO_DISK_MIB: f64 = 100.0;

#[derive(Debug, Args)]
pub(crate) struct DoctorArguments {
    /// The main configuration file, in DUNE's .ini dialect.
    config: PathBuf,
    /// Profile.
    #[arg(long, default_value = "Hardware")]
    profile: String,
    /// Folder for plans and logs, as of `run`.
    #[arg(long, default_value = "lutra-agent-data")]
    data: PathBuf,
    /// How long devices and the shore may take to answer (s).
    #[arg(long, default_value_t = 8)]
    patience: u64,
    /// Print JSON for monitoring, and end with 0 when all is well, 1 for a warning, 2 when something must be fixed. Without
    /// it: 1 when something must be fixed, else 0.
    #[arg(long)]
    json: bool,
}

pub(crate) fn doctor(arguments: &DoctorArguments) -> ExitCode {
    let config =
        Config::load_aboard(&config::Disk, &arguments.config, &[&arguments.profile], &arguments.data);
    let mut findings = vec![configuration(&config)];
    if findings[0].status != Status::Fail {
        findings.extend(aboard(arguments, &config));
    }
    match print(&findings, arguments.json) {
        status if arguments.json => ExitCode::from(status.exit_code()),
        Status::Ok | Status::Warn => ExitCode::SUCCESS,
        Status::Fail => ExitCode::FAILURE,
    }
}

fn configuration(config: &Config) -> Finding {
    let part = "configuration";
    let remedy = "`lutra-agent check` tells where";
    if config.report().has_errors() {
        return Finding::fail(part, config.report().to_string().trim_end(), remedy);
    }
    match setup::settings(config, 0) {
        Err(error) => Finding::fail(part, format!("{error:#}"), remedy),
        Ok((settings, mut doubts)) => {
            doubts.extend(trial::doubts(config, &settings));
            match &doubts[..] {
                [] => Finding::ok(part, format!("that of {}", config.vehicle())),
                some => Finding::warn(part, some.join("; "), remedy),
            }
        }
    }
}

/// Checks that need a valid configuration.
fn aboard(arguments: &DoctorArguments, config: &Config) -> Vec<Finding> {
    let patience = Duration::from_secs(arguments.patience);
    let (found, right) = agent(&arguments.data);
    let mut findings = vec![disk(&arguments.data), found];
    findings.push(link(arguments, config, patience));
    findings.push(chart(&arguments.data, config));
    if arguments.profile != "Simulation" {
        // The folder's lock is held meanwhile: no agent starts before the ports are free again.
        findings.extend(match &right {
            Right::Taken => vec![devices::left_alone()],
            Right::Ours(_) | Right::NoFolder => devices::examine(config, &Clock::system(), patience),
        });
    }
    drop(right);
    findings
}

/// Who has the data folder.
enum Right {
    /// This program's.
    Ours(#[expect(dead_code, reason = "it is held, not asked")] DataLock),
    /// There is none: no agent runs there.
    NoFolder,
    /// An agent has it, or the owner is unknown.
    Taken,
}

fn disk(data: &Path) -> Finding {
    let part = "disk";
    // A folder that the first start will make is on the disk of its parent.
    let there = data.ancestors().find(|folder| folder.is_dir()).unwrap_or(Path::new("."));
    let free_mib = Host::new().read(there).disk_free_mib;
    let text = format!("{free_mib:.0} MiB free for {}", data.display());
    let remedy = "bring old logs ashore and remove them";
    if free_mib < NO_DISK_MIB {
        Finding::fail(part, text, remedy)
    } else if free_mib < LITTLE_DISK_MIB {
        Finding::warn(part, text, remedy)
    } else {
        Finding::ok(part, text)
    }
}

/// Checks whether an agent is running, which has the ports.
fn agent(data: &Path) -> (Finding, Right) {
    let part = "data folder";
    if !data.is_dir() {
        let text = format!("{} is made at the first start", data.display());
        let remedy = "give --data as `run` has it, if it is another";
        return (Finding::warn(part, text, remedy), Right::NoFolder);
    }
    match DataLock::take(data) {
        Ok(lock) => (Finding::ok(part, format!("{} is free", data.display())), Right::Ours(lock)),
        Err(error) if error.is::<InUse>() => (
            Finding::warn(part, error.to_string(), "end it first to have the devices looked at"),
            Right::Taken,
        ),
        Err(error) => {
            let remedy = "give the folder to the user that runs the agent";
            (Finding::fail(part, format!("{error:#}"), remedy), Right::Taken)
        }
    }
}

fn link(arguments: &DoctorArguments, config: &Config, patience: Duration) -> Finding {
    let part = "shore";
    let mut doubts = Vec::new();
    match UplinkSettings::read(config, &arguments.config, &arguments.data, &mut doubts) {
        Err(error) => Finding::fail(part, format!("{error:#}"), ""),
        Ok(None) => Finding::warn(
            part,
            "[Transports.Lutra] is off: nothing is sent to a Lutra server",
            "enable it, with the server's URL and a token",
        ),
        Ok(Some(settings)) => match uplink::reach(&settings, patience) {
            Ok(reached) => Finding::ok(part, format!("{reached} answers and knows the token")),
            Err(why) => Finding::fail(part, why, "is the network there (`ping`), and the server on?"),
        },
    }
}

/// Checks the chart of the next start: the shore's, else the configured one.
fn chart(data: &Path, config: &Config) -> Finding {
    let part = "chart";
    let taken = if setup::takes_chart(config) { ChartFolder::new(data).load() } else { Ok(None) };
    let configured = setup::settings(config, 0).map(|(settings, _)| settings.grounding.chart);
    match (taken, configured) {
        (Err(why), _) => Finding::fail(part, why, "remove that file: the shore sends the chart again"),
        (Ok(Some(file)), _) => Finding::ok(part, format!("of the shore: {}", file.edition())),
        (Ok(None), Ok(Chart::Loaded(file))) => {
            Finding::ok(part, format!("as configured: {}", file.edition()))
        }
        (Ok(None), Ok(Chart::Unreadable { reason })) => {
            Finding::fail(part, reason, "mend `Chart` in [Supervisors.Grounding]")
        }
        (Ok(None), Ok(Chart::Off) | Err(_)) => Finding::warn(
            part,
            "no chart is aboard: nothing keeps plans off the ground",
            "connect to the shore once, or set `Chart` in [Supervisors.Grounding]",
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_another_agent_has_is_said() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(agent(folder.path()).0.status, Status::Ok);
        let _lock = DataLock::take(folder.path()).unwrap();
        let (taken, right) = agent(folder.path());
        assert!(matches!(right, Right::Taken));
        assert!(taken.status == Status::Warn && taken.text.contains("another lutra-agent"), "{taken:?}");
        assert_eq!(agent(&folder.path().join("none")).0.status, Status::Warn);
    }
}
