//! The computer's clock against GNSS time: a pulse as the kernel records it, and a real chronyd that takes the time.

use crate::common::Console;
use crate::common::devices::Devices;
use imc::messages::{EntityState, EntityStateState, Event};
use onboard::Entity;
use std::fmt::Write as _;
use std::os::unix::fs::DirBuilderExt as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use testkit::{Need, absent};

/// Adds keys of `[Monitors.Clock]` to the vessel's configuration.
fn configure(devices: &Devices, keys: &str) {
    let path = devices.folder.path().join("otter.ini");
    let mut text = std::fs::read_to_string(&path).unwrap();
    write!(text, "[Monitors.Clock]\n{keys}\n").unwrap();
    std::fs::write(path, text).unwrap();
}

/// Records a pulse at each whole second as the kernel does, for a clock that is 15 ms ahead, until `end`.
fn pulses(file: &Path, end: &AtomicBool) {
    let mut last = 0;
    while !end.load(Ordering::Relaxed) {
        let second = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs();
        if second != last {
            last = second;
            let whole = file.with_extension("new");
            std::fs::write(&whole, format!("{second}.015000000#{second}\n")).unwrap();
            std::fs::rename(whole, file).unwrap();
        }
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Slow because eight pulses take eight seconds.
#[test]
fn a_clock_that_is_15_ms_off_by_the_pulse_is_reported_in_words_and_figures() {
    let devices = Devices::start(&[]);
    let file = devices.folder.path().join("assert");
    configure(&devices, &format!("Pulse Device = {}", file.display()));
    let end = Arc::new(AtomicBool::new(false));
    let (writer, its_file, its_end) = (std::thread::Builder::new(), file.clone(), Arc::clone(&end));
    let writer = writer.spawn(move || pulses(&its_file, &its_end)).unwrap();
    let agent = devices.agent(&[]);
    let mut console = Console::connect(&agent);
    console.wait("the clock's fault", |packet| {
        let state =
            packet.get::<EntityState>().filter(|_| packet.header.src_ent == Entity::Clock.number())?;
        let text = state.description.to_str_lossy().into_owned();
        (state.state == EntityStateState::Fault
            && text.starts_with("+15.0 ms off the satellites by the pulse"))
        .then_some(())
    });
    let figures = console.wait("the clock's figures", |packet| {
        let event = packet.get::<Event>().filter(|_| packet.header.src_ent == Entity::Clock.number())?;
        Some(event.data.to_str_lossy().into_owned()).filter(|data| data.contains("quality=precise"))
    });
    assert!(figures.contains("offset_us=15000"), "{figures}");
    end.store(true, Ordering::Relaxed);
    writer.join().unwrap();
}

/// A chronyd that does not set the clock (`-x`) and takes GNSS time; slow, as it takes one sample a second.
#[test]
fn a_real_chronyd_takes_the_satellites_time() {
    if Command::new("chronyd").arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status().is_err()
    {
        return absent(
            Need::Chrony,
            "chronyd is absent (apt-get install chrony, which sets this computer's clock)",
        );
    }
    let devices = Devices::start(&[]);
    // Chronyd accepts queries only in its own folder.
    let folder = &devices.folder.path().join("chrony");
    std::fs::DirBuilder::new().mode(0o700).create(folder).unwrap();
    let (socket, asked) = (folder.join("lutra.sock"), folder.join("chronyd.sock"));
    configure(&devices, &format!("Chrony Socket = {}", socket.display()));
    let conf = folder.join("chrony.conf");
    let text = format!(
        "refclock SOCK {} refid GNSS poll 0 delay 1.0 precision 1e-1\nport 0\ncmdport 0\nbindcmdaddress {}\npidfile {}\n",
        socket.display(),
        asked.display(),
        folder.join("chronyd.pid").display()
    );
    std::fs::write(&conf, text).unwrap();
    let mut chronyd = Command::new("chronyd")
        .args(["-d", "-x", "-u", "root", "-f"])
        .arg(&conf)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let _agent = devices.agent(&[]);
    let deadline = Instant::now() + Duration::from_mins(1);
    // A line of comma-separated values: mode, state (* where the clock goes by it), name, stratum, poll, reach, age, offset, ...
    let (offset_s, said) = loop {
        let answer = Command::new("chronyc").args(["-c", "-h"]).arg(&asked).arg("sources").output().unwrap();
        let said =
            String::from_utf8_lossy(&answer.stdout).into_owned() + &String::from_utf8_lossy(&answer.stderr);
        let fields: Vec<&str> = said.trim().split(',').collect();
        if fields.get(2) == Some(&"GNSS") && fields[1] == "*" {
            break (fields[7].parse::<f64>().unwrap(), said);
        }
        assert!(Instant::now() < deadline, "chronyd does not take it: {said}");
        std::thread::sleep(Duration::from_millis(200));
    };
    chronyd.kill().unwrap();
    chronyd.wait().unwrap();
    // The simulated receiver uses this computer's clock: the remaining offset is the delay of its messages.
    assert!(offset_s.abs() < 1.0, "{offset_s} s: {said}");
}
