//! Small data of this version, kept permanently: a shore's folder and a vessel's spool, made by the real programs.
//!
//! A chart set of the demonstration's harbour is made, a simulated Otter sails for some seconds, its shore is stopped, and it continues until its spool has data. Each file is
//! compressed by gzip. A test of every later version opens them. Run once for each version, before its tag:
//! `cargo build --workspace && cargo xtask fixtures`.

use anyhow::{Context as _, bail, ensure};
use flate2::{Compression, GzBuilder};
use std::fs;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

/// Bytes of packets that must arrive ashore, and then be in the spool, before the next step.
const ENOUGH_BYTES: u64 = 20_000;
/// Time limit of each step.
const PATIENCE: Duration = Duration::from_mins(1);
/// Temporary files, and files that every program makes again.
const LEFT_OUT: [&str; 8] =
    ["lock", "agent.lock", "chart.gpkg.lock", "otter.ini", "definitions", "IMC.xml.gz", "logs", "errors"];

/// The folder of cells that the chart set is made of; it is not kept.
const CELLS: &str = "cells";

/// A program that ends with this one.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

impl Running {
    /// Ends it normally.
    fn end(&mut self) -> anyhow::Result<()> {
        let told = Command::new("kill").arg(self.0.id().to_string()).status()?;
        ensure!(told.success() && self.0.wait()?.success(), "a program did not end well");
        Ok(())
    }

    /// Its next line.
    fn line(&mut self) -> anyhow::Result<(String, BufReader<ChildStdout>)> {
        let mut out = BufReader::new(self.0.stdout.take().context("it prints nothing")?);
        let mut line = String::new();
        out.read_line(&mut line)?;
        Ok((line.trim().to_owned(), out))
    }
}

/// Makes them in `to`, or where those of this version are kept.
pub(crate) fn make(root: &Path, to: Option<&Path>) -> anyhow::Result<()> {
    let kept = || root.join("server/tests/fixtures").join(env!("CARGO_PKG_VERSION"));
    let to = to.map_or_else(kept, Path::to_owned);
    ensure!(
        !to.exists(),
        "{} exists: data of a version are never changed; remove the folder if that version has no tag yet",
        to.display()
    );
    let work = std::env::temp_dir().join(format!("lutra-fixtures-{}", std::process::id()));
    let made = sail(root, &work).and_then(|()| pack(&work, &work, &to));
    fs::remove_dir_all(&work).ok();
    made?;
    println!("wrote {}", to.display());
    Ok(())
}

fn program(root: &Path, name: &str) -> anyhow::Result<Command> {
    let path = root.join("target/debug").join(name);
    ensure!(path.exists(), "{} is not there: run `cargo build --workspace`", path.display());
    Ok(Command::new(path))
}

fn sail(root: &Path, work: &Path) -> anyhow::Result<()> {
    let (data, aboard) = (work.join("shore"), work.join("aboard"));
    fs::create_dir_all(&aboard)?;
    let run = |arguments: &[&str]| -> anyhow::Result<String> {
        let mut command = program(root, "lutra-server")?;
        let mut child = command
            .args(arguments)
            .arg("--data")
            .arg(&data)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        child.stdin.take().context("stdin")?.write_all(b"seven small boats\n")?;
        let output = child.wait_with_output()?;
        ensure!(output.status.success(), "{arguments:?} failed");
        Ok(String::from_utf8(output.stdout)?.trim().to_owned())
    };
    run(&["user", "add", "nils", "--role", "admin", "--password-stdin"])?;
    run(&["vessel", "add", "otter-1", "0x2810"])?;
    let token = run(&["token", "create", "--link", "otter-1"])?;
    let cell = cell(&work.join(CELLS))?;
    run(&["chart", "import", &cell.display().to_string()])?;
    let mut server = program(root, "lutra-server")?;
    server.args(["serve", "--listen", "127.0.0.1:0", "--set", "imc.active=false", "--data"]).arg(&data);
    let mut server = Running(server.stdout(Stdio::piped()).stderr(Stdio::null()).spawn()?);
    let (line, _out) = server.line()?;
    let address =
        line.strip_prefix("listening http://").with_context(|| format!("the server says {line:?}"))?;
    let otter = fs::read_to_string(root.join("vehicle-agent/etc/otter.ini"))?;
    let link = format!(
        "\n[Transports.Lutra]\nEnabled = Always\nURL = ws://{address}/link\nToken File = lutra.token\n"
    );
    fs::write(aboard.join("otter.ini"), otter + &link)?;
    fs::write(aboard.join("lutra.token"), token)?;
    let mut agent = program(root, "lutra-agent")?;
    agent.arg("run").arg(aboard.join("otter.ini")).args([
        "--profile",
        "Simulation",
        "--quiet",
        "--bind",
        "127.0.0.1",
    ]);
    agent.args(["--udp-port", "0", "--tcp-port", "0", "--announce-port", "0", "--data"]).arg(&aboard);
    let mut agent = Running(agent.stdout(Stdio::piped()).stderr(Stdio::null()).spawn()?);
    let (line, _heard) = agent.line()?;
    ensure!(line.starts_with("listening "), "the agent says {line:?}");
    wait("something ashore", || bytes_in(&data.join("archive"), "Data.lsf") > ENOUGH_BYTES)?;
    server.end()?;
    let before = bytes_in(&aboard.join("spool"), "");
    wait("something in the spool", || bytes_in(&aboard.join("spool"), "") > before + ENOUGH_BYTES)?;
    agent.end()
}

/// The smaller cell of the demonstration's chart, in a folder.
fn cell(folder: &Path) -> anyhow::Result<PathBuf> {
    fs::create_dir_all(folder)?;
    let harbour = charts::demo::archipelago()?.pop().context("the demonstration has no chart")?;
    let path = folder.join(format!("{}.000", harbour.name.trim_end_matches(".000")));
    fs::write(&path, harbour.bytes)?;
    Ok(path)
}

fn wait(what: &str, holds: impl Fn() -> bool) -> anyhow::Result<()> {
    let end = Instant::now() + PATIENCE;
    while !holds() {
        if Instant::now() > end {
            bail!("{what}: not within {} s", PATIENCE.as_secs());
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    Ok(())
}

/// Bytes of all files below a folder whose names end so.
fn bytes_in(folder: &Path, end: &str) -> u64 {
    files(folder)
        .iter()
        .filter(|path| path.to_string_lossy().ends_with(end))
        .filter_map(|path| path.metadata().ok())
        .map(|file| file.len())
        .sum()
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.push(path);
        }
    }
    found
}

/// Packs all files below `folder` to the same places below `to`.
fn pack(work: &Path, folder: &Path, to: &Path) -> anyhow::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let is_of_a_moment = name == CELLS
            || LEFT_OUT.contains(&name.as_str())
            || name.ends_with("-wal")
            || name.ends_with("-shm");
        // The vessel's own logs are no part of what is tested.
        let is_log = path.starts_with(work.join("aboard")) && name.ends_with(".lsf.gz");
        if is_of_a_moment || is_log {
            continue;
        }
        if path.is_dir() {
            pack(work, &path, to)?;
            continue;
        }
        let target = to.join(format!("{}.gz", path.strip_prefix(work)?.display()));
        fs::create_dir_all(target.parent().unwrap_or(to))?;
        // Without times and names: the same bytes for the same file.
        let mut packed = GzBuilder::new().write(fs::File::create(&target)?, Compression::best());
        packed.write_all(&fs::read(&path)?)?;
        packed.finish()?;
    }
    Ok(())
}
