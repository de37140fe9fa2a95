//! Data from before the start: the log of a mission that another Otter sailed yesterday, as vehicles write logs, imported
//! in the usual way.

use super::fleet::{self, Otter, World};
use super::plans;
use crate::AppState;
use crate::cli::say::say;
use anyhow::{Context as _, bail};
use api::{Import, ImportState};
use shore::clock;
use shore::identity::vessels;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;
use tokio::process::Command;
use units::UtcTime;

/// How long ago it began (µs), and how long it lasted (s).
const AGO_US: i64 = 86_400_000_000;
const LASTS_S: i64 = 1_200;
/// How often the progress of an import is checked.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// Who imports it.
const BY: &str = "the demo";

/// A mission of which only a log exists.
#[derive(Debug, Clone)]
pub(super) struct Past {
    pub(super) otter: Otter,
    begun: UtcTime,
}

impl Past {
    /// Yesterday's Otter has a name, too.
    pub(super) fn vessel(&self, now: UtcTime) -> vessels::Add {
        vessels::Add { address: self.otter.address.0, name: self.otter.name.clone(), now }
    }

    /// Yesterday's mission, at this time of day.
    pub(super) fn before(now: UtcTime) -> Self {
        // Whole seconds, as they are written into the command line.
        let begun_s = (now.micros() - AGO_US).div_euclid(1_000_000);
        Self { otter: fleet::of_yesterday(), begun: UtcTime::from_micros(begun_s * 1_000_000) }
    }

    /// Address of a page that replays it at ten times the speed.
    pub(super) fn page(&self) -> String {
        let from_us = self.begun.micros();
        let to_us = from_us + LASTS_S * 1_000_000;
        let at_us = from_us + 60_000_000;
        format!("/vessels/{}?from={from_us}&to={to_us}&t={at_us}&speed=10", self.otter.address.0)
    }

    /// Has the mission sailed with a virtual clock, and imports its log. Returns the number of packets.
    ///
    /// # Errors
    /// The agent fails, or the log cannot be imported completely.
    pub(super) async fn bring_in(
        &self,
        program: &Path,
        folder: &Path,
        chart: &Path,
        fish: bool,
        state: &AppState,
    ) -> anyhow::Result<u64> {
        let logs = self.sail(program, folder, chart, fish).await?;
        let mut packets = 0;
        for log in logs {
            let name = log.strip_prefix(folder).unwrap_or(&log).display().to_string();
            let done = import(state, &log, name).await?;
            if done.state != ImportState::Done || !done.problems.is_empty() {
                let why: Vec<&str> = done.problems.iter().map(|one| one.text.as_str()).collect();
                bail!("{} does not come in: {}", done.name, why.join("; "));
            }
            packets += done.packets;
        }
        Ok(packets)
    }

    async fn sail(
        &self,
        program: &Path,
        folder: &Path,
        chart: &Path,
        fish: bool,
    ) -> anyhow::Result<Vec<PathBuf>> {
        let Self { otter, begun } = self;
        fleet::write(folder, World { chart, since: *begun, fish }, otter, None)?;
        let plan = folder.join(format!("{}.json", otter.name));
        let (_, specification) = plans::drawn(otter)?;
        let text = imc::json::message_to_string(&specification.into()).context("the plan as JSON")?;
        fs::write(&plan, text).with_context(|| format!("cannot write {}", plan.display()))?;
        let log = otter.log(folder);
        let output = File::create(&log).with_context(|| format!("cannot write {}", log.display()))?;
        let data = otter.data(folder);
        let mut command = Command::new(program);
        command.arg("simulate").arg("--config").arg(otter.ini(folder)).arg("--plan").arg(&plan);
        command.args(["--start", &begun.to_string(), "--until", &LASTS_S.to_string(), "--every", "0"]);
        command.arg("--log").arg(&data);
        command.stdin(Stdio::null()).stdout(output.try_clone()?).stderr(output);
        command.process_group(0).kill_on_drop(true);
        let status = command.status().await.with_context(|| format!("cannot start {}", program.display()))?;
        if !status.success() {
            bail!("its simulation ended with {status}: {}", fs::read_to_string(&log).unwrap_or_default());
        }
        let mut logs = Vec::new();
        find(&data, &mut logs).with_context(|| format!("cannot read {}", data.display()))?;
        Ok(logs)
    }
}

/// The logs below a folder, in order of their names, which begin with the time.
fn find(folder: &Path, logs: &mut Vec<PathBuf>) -> std::io::Result<()> {
    let mut entries: Vec<PathBuf> =
        fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>()?;
    entries.sort();
    for path in entries {
        if path.is_dir() {
            find(&path, logs)?;
        } else if path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("Data.lsf")) {
            logs.push(path);
        }
    }
    Ok(())
}

/// Imports a log and waits for the end. An import by a user at the same time goes first.
async fn import(state: &AppState, log: &Path, name: String) -> anyhow::Result<Import> {
    let mut looks = tokio::time::interval(LOOK_EVERY);
    let upload = loop {
        looks.tick().await;
        let (imports, log) = (state.shore.imports.clone(), log.to_owned());
        let upload = tokio::task::spawn_blocking(move || imports.take(&log)).await??;
        if let Some(upload) = upload {
            break upload;
        }
    };
    let (recorder, stop) = (state.shore.recorder.clone(), state.shore.stop.clone());
    let begun = state.shore.imports.begin(upload, name, BY.to_owned(), recorder, &state.shore.tasks, stop);
    loop {
        looks.tick().await;
        match state.shore.imports.get(begun.id) {
            Some(import) if import.state == ImportState::Running => {}
            Some(import) => return Ok(import),
            None => bail!("{} is forgotten", begun.name),
        }
    }
}

/// Reports the outcome.
pub(super) fn tell(past: &Past, url: &str, outcome: anyhow::Result<u64>) {
    let name = &past.otter.name;
    match outcome {
        Ok(packets) => {
            let day = clock::written(past.begun);
            say!("{name:<9} its log of {day} is in, {packets} packets: {url}{}", past.page());
        }
        Err(error) => say!("{name:<9} there is no log of yesterday: {error:#}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn yesterday_is_a_day_ago_and_its_page_shows_all_of_it() {
        let past = Past::before(UtcTime::from_micros(1_790_086_400_900_000));
        assert_eq!(
            past.page(),
            "/vessels/10448?from=1790000000000000&to=1790001200000000&t=1790000060000000&speed=10"
        );
    }

    #[test]
    fn logs_are_found_in_order_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b/Data.lsf", "a/2/Data.lsf.gz", "a/2/IMC.xml.gz", "a/1/Data.lsf.gz"] {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "x").unwrap();
        }
        let mut logs = Vec::new();
        find(folder.path(), &mut logs).unwrap();
        let names: Vec<_> = logs.iter().map(|log| log.strip_prefix(folder.path()).unwrap()).collect();
        assert_eq!(
            names,
            [Path::new("a/1/Data.lsf.gz"), Path::new("a/2/Data.lsf.gz"), Path::new("b/Data.lsf")]
        );
    }
}
