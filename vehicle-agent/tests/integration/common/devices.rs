//! The simulated devices as a process, and the true state that they write.

use super::{Agent, DEADLINE, ini, program};
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// The simulated devices, in a folder with the configuration of a vessel that has them.
pub(crate) struct Devices {
    child: Child,
    out: BufReader<ChildStdout>,
    pub(crate) folder: TempDir,
}

/// The true state of the vessel.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Truth {
    pub(crate) utc_s: f64,
    pub(crate) lat_deg: f64,
    pub(crate) lon_deg: f64,
    pub(crate) speed_mps: f64,
    /// The faster of both propellers, without direction (rad/s).
    pub(crate) shaft_radps: f64,
}

/// A vessel whose devices are behind the links, and a fish that is heard often.
pub(crate) fn configuration(links: &Path) -> String {
    let links = links.display();
    format!(
        "[Require base.ini]\n\
         [Sensors.GPS]\nSerial Port - Device = {links}/gnss\nSerial Port - Baud Rate = 115200\n\
         [Actuators.Torqeedo]\nCAN Port - Device = slcan:{links}/motors\n\
         [Sensors.ThelmaHydrophone]\nSerial Port - Device = {links}/hydrophone\nSerial Port - Baud Rate = 115200\n\
         Use PPS = false\n\
         [Simulators.Fish]\nEnabled = Simulation\nTag Interval = 5, 6\nArea -- Radius = 20\n"
    )
}

impl Devices {
    pub(crate) fn start(more: &[&str]) -> Self {
        let folder = TempDir::new().unwrap();
        let (config, links) = (folder.path().join("otter.ini"), folder.path().join("dev"));
        std::fs::copy(ini(), folder.path().join("base.ini")).unwrap();
        std::fs::write(&config, configuration(&links)).unwrap();
        let mut child = program()
            .args(["simulate-devices", "--perfect", "--config"])
            .arg(&config)
            .arg("--links")
            .arg(&links)
            .arg("--truth")
            .arg(folder.path().join("truth"))
            .arg("--received")
            .arg(folder.path().join("received"))
            .args(more)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let out = BufReader::new(child.stdout.take().unwrap());
        let mut devices = Self { child, out, folder };
        assert!(devices.line().starts_with("devices gnss="));
        devices
    }

    fn line(&mut self) -> String {
        let mut line = String::new();
        self.out.read_line(&mut line).unwrap();
        line
    }

    /// Starts or ends a fault of a device, and waits until that is done; returns the answer.
    pub(crate) fn order(&mut self, order: &str) -> String {
        writeln!(self.child.stdin.as_mut().unwrap(), "{order}").unwrap();
        let line = self.line();
        assert!(!line.is_empty());
        line
    }

    /// All that the computer has sent to a device so far.
    pub(crate) fn received(&self, device: &str) -> String {
        let text = std::fs::read_to_string(self.folder.path().join("received")).unwrap();
        let pieces = text.lines().filter_map(|line| serde_json::from_str::<serde_json::Value>(line).ok());
        let of_device = pieces.filter(|piece| piece["device"] == device);
        of_device.map(|piece| piece["text"].as_str().unwrap().to_owned()).collect()
    }

    /// The agent that steers the vessel.
    pub(crate) fn agent(&self, more: &[&str]) -> Agent {
        let mut command = program();
        command.arg("run").arg(self.folder.path().join("otter.ini"));
        command.args(["--log-level", "off", "--profile", "Hardware"]);
        Agent::spawn(&mut command, self.folder.path(), more)
    }

    /// All true states so far, five times a second.
    pub(crate) fn truth(&self) -> Vec<Truth> {
        let text = std::fs::read_to_string(self.folder.path().join("truth")).unwrap();
        let read = |line: &str| {
            let value: serde_json::Value = serde_json::from_str(line).ok()?;
            let number = |key: &str| value[key].as_f64();
            let shaft_radps = number("port_radps")?.abs().max(number("starboard_radps")?.abs());
            let (lat_deg, lon_deg) = (number("lat_deg")?, number("lon_deg")?);
            Some(Truth {
                utc_s: number("utc_s")?,
                lat_deg,
                lon_deg,
                speed_mps: number("speed_mps")?,
                shaft_radps,
            })
        };
        text.lines().filter_map(read).collect()
    }

    pub(crate) fn last(&self) -> Truth {
        *self.truth().last().unwrap()
    }

    /// Waits until the true state meets a condition.
    pub(crate) fn wait(&self, what: &str, wanted: impl Fn(&Truth) -> bool) -> Truth {
        let until = Instant::now() + DEADLINE;
        while Instant::now() < until {
            if let Some(truth) = self.truth().last().filter(|truth| wanted(truth)) {
                return *truth;
            }
            // The file grows five times a second; it can only be polled.
            std::thread::park_timeout(Duration::from_millis(50));
        }
        panic!("{what}: not within {DEADLINE:?}; last: {:?}", self.last());
    }

    /// Distance of a place from the vessel's position at a time (m).
    pub(crate) fn off_m(&self, utc_s: f64, lat_rad: f64, lon_rad: f64) -> f64 {
        let all = self.truth();
        let nearest = all.iter().min_by(|a, b| (a.utc_s - utc_s).abs().total_cmp(&(b.utc_s - utc_s).abs()));
        let truth = nearest.unwrap();
        assert!((truth.utc_s - utc_s).abs() < 0.5, "nothing is known of {utc_s}: {truth:?}");
        let north_m = (lat_rad.to_degrees() - truth.lat_deg) * 111_500.0;
        let east_m = (lon_rad.to_degrees() - truth.lon_deg) * 111_500.0 * lat_rad.cos();
        north_m.hypot(east_m)
    }

    /// Ends them as an init system does: their names are removed.
    pub(crate) fn terminate(mut self) {
        let sent = std::process::Command::new("kill").arg(self.child.id().to_string()).status().unwrap();
        assert!(sent.success() && self.child.wait().unwrap().success());
        let left: Vec<PathBuf> = std::fs::read_dir(self.folder.path().join("dev"))
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .collect();
        assert_eq!(left, [] as [PathBuf; 0]);
    }
}

impl std::ops::Drop for Devices {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }
}
