//! Checks that the devices answer: each port is opened, and its driver listens as under way but sets and commands nothing.

use super::finding::Finding;
use crate::clock::Clock;
use crate::device::Device;
use crate::hardware::{ConfiguredDevice, listening};
use crate::io::{Report, Station, Wake};
use config::Config;
use devices::Reading;
use drivers::State;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, sync_channel};
use std::time::{Duration, Instant};
use units::UtcTime;

/// Most queued reports; further ones are dropped.
const MOST_REPORTS: usize = 1024;
/// How long the ports may take to close.
const CLOSE: Duration = Duration::from_secs(1);
/// The computer's clock may be off by so much (s).
const MOST_OFF_S: f64 = 1.0;

/// What was heard of one device.
#[derive(Debug, Default)]
struct Heard {
    state: Option<State>,
    readings: u64,
    fix: bool,
    heading: bool,
    notes: Vec<String>,
}

/// No port was opened, because an agent is using them.
pub(super) fn left_alone() -> Finding {
    Finding::warn(
        "devices",
        "not looked at: an agent has their ports, and on a CAN bus two would command the motors in turns",
        "how each device is stands on the vessel's page, under its parts, and in the agent's log; or end the agent first",
    )
}

/// Listens to all devices until each has answered, for at most `patience`.
pub(super) fn examine(config: &Config, clock: &Clock, patience: Duration) -> Vec<Finding> {
    let part = "devices";
    let configured_devices = match listening(config) {
        Ok(configured_devices) => configured_devices,
        Err(error) => return vec![Finding::fail(part, format!("{error:#}"), "mend the configuration")],
    };
    let (sent, reports) = sync_channel(MOST_REPORTS);
    let (mut places, mut stations) = (Vec::new(), Vec::new());
    for ConfiguredDevice { device, driver, place } in configured_devices {
        places.push((device, place.to_string()));
        let sent = sent.clone();
        let sink = move |report| {
            sent.try_send((device, report)).ok();
        };
        let station = Wake::new().map_err(anyhow::Error::from).and_then(|wake| {
            Station::start(device.name(), driver, place, clock.clone(), Arc::new(wake), sink)
        });
        match station {
            Ok(station) => stations.push(station),
            Err(error) => return vec![Finding::fail(part, format!("{error:#}"), "end other programs")],
        }
    }
    let (heard, off_s) = listen(&reports, &places, clock, patience);
    stations.iter().for_each(Station::end);
    for station in &stations {
        // Ports that do not close in time are closed with the program.
        let _ = station.is_over_within(CLOSE);
    }
    let mut findings: Vec<Finding> =
        places.iter().map(|(device, place)| judge(*device, place, &heard)).collect();
    findings.push(judge_clock(clock.utc(), off_s));
    findings
}

/// Returns what was heard, and the offset of the computer's clock from GNSS time (s).
fn listen(
    reports: &Receiver<(Device, Report)>,
    places: &[(Device, String)],
    clock: &Clock,
    patience: Duration,
) -> (BTreeMap<Device, Heard>, Option<f64>) {
    let until = Instant::now() + patience;
    let (mut heard, mut off_s) = (BTreeMap::<Device, Heard>::new(), None);
    let enough = |heard: &BTreeMap<Device, Heard>, off_s: Option<f64>| {
        places
            .iter()
            .all(|(device, _)| heard.get(device).is_some_and(|heard| heard.is_enough(*device, off_s)))
    };
    while !enough(&heard, off_s) {
        let Ok((device, report)) = reports.recv_timeout(until.saturating_duration_since(Instant::now()))
        else {
            break;
        };
        if let Report::Reading(at, Reading::Gnss(reading)) = &report
            && let (Some(utc), Some(_)) = (reading.utc, reading.fix)
        {
            off_s = Some(at.utc.seconds() - utc.seconds());
        }
        heard.entry(device).or_default().take(report);
    }
    tracing::debug!(utc = %clock.utc(), "listened");
    (heard, off_s)
}

impl Heard {
    fn take(&mut self, report: Report) {
        match report {
            Report::Reading(_, reading) => {
                self.readings += 1;
                if let Reading::Gnss(reading) = reading {
                    self.fix |= reading.fix.is_some();
                    self.heading |= reading.heading_rad.is_some();
                }
            }
            Report::State(state) => self.state = Some(state),
            Report::Note(note) if note.warning && self.notes.len() < 5 => self.notes.push(note.text),
            Report::Note(_) => {}
        }
    }

    fn is_enough(&self, device: Device, off_s: Option<f64>) -> bool {
        self.state == Some(State::Working)
            && (device != Device::Compass || (self.fix && self.heading && off_s.is_some()))
    }
}

fn judge(device: Device, place: &str, heard: &BTreeMap<Device, Heard>) -> Finding {
    let part = device.name();
    let Some(heard) = heard.get(&device) else {
        return Finding::fail(
            part,
            format!("{place}: nothing came of it"),
            "has it power, and is it this port?",
        );
    };
    let notes = heard.notes.join("; ");
    match &heard.state {
        Some(State::Failing(why)) => Finding::fail(part, why, notes),
        None | Some(State::Starting) => {
            Finding::fail(part, format!("{place} is open and the device has not answered"), "has it power?")
        }
        Some(State::Working) if device == Device::Compass && !heard.fix => Finding::warn(
            part,
            format!("{place} answers, and has no position"),
            "indoors it does not come; outdoors it takes up to some minutes",
        ),
        Some(State::Working) if device == Device::Compass && !heard.heading => Finding::fail(
            part,
            format!("{place} answers, and gives no true heading (HDT)"),
            "switch the sentence on, as by `Initialization String 0 - Command = $JASC,GPHDT,1\\r\\n`",
        ),
        Some(State::Working) if !notes.is_empty() => Finding::warn(part, format!("{place} works"), notes),
        Some(State::Working) => Finding::ok(part, format!("{place} works, {} readings", heard.readings)),
    }
}

/// Checks the computer's clock against GNSS time.
pub(super) fn judge_clock(utc: UtcTime, off_s: Option<f64>) -> Finding {
    let part = "clock";
    let remedy =
        "let the computer set its clock: `timedatectl set-ntp true` with a network, else chrony with gpsd";
    match off_s {
        Some(off_s) if off_s.abs() > MOST_OFF_S => {
            Finding::fail(part, format!("the computer's is {off_s:+.1} s off the satellites'"), remedy)
        }
        Some(off_s) => {
            Finding::ok(part, format!("{utc}, {off_s:+.2} s from the satellites' with the line's delay"))
        }
        // No agent is older than this.
        None if utc.civil().year < 2025 => Finding::fail(part, format!("{utc} is in the past"), remedy),
        None => Finding::warn(part, format!("{utc}; no satellites to compare it with"), ""),
    }
}

#[cfg(test)]
mod tests {
    use super::super::finding::Status;
    use super::*;

    #[test]
    fn a_clock_is_judged_by_the_satellites_and_else_by_its_year() {
        let now = UtcTime::from_micros(1_790_000_000_000_000);
        let verdict = |utc, off_s| judge_clock(utc, off_s).status;
        assert_eq!(verdict(now, Some(0.3)), Status::Ok);
        assert_eq!(verdict(now, Some(-1.4)), Status::Fail);
        assert_eq!(verdict(now, None), Status::Warn);
        assert_eq!(verdict(UtcTime::from_micros(0), None), Status::Fail);
    }

    #[test]
    fn a_device_is_judged_by_what_it_did() {
        let heard = |state, fix, heading| {
            let heard = Heard { state, fix, heading, readings: 1, notes: Vec::new() };
            judge(Device::Compass, "/dev/gnss", &[(Device::Compass, heard)].into()).status
        };
        assert_eq!(heard(Some(State::Working), true, true), Status::Ok);
        assert_eq!(heard(Some(State::Working), false, true), Status::Warn);
        assert_eq!(heard(Some(State::Working), true, false), Status::Fail);
        assert_eq!(heard(Some(State::Starting), true, true), Status::Fail);
        assert_eq!(heard(Some(State::Failing("x".into())), true, true), Status::Fail);
        assert_eq!(judge(Device::Motors, "can0", &BTreeMap::new()).status, Status::Fail);
    }
}
