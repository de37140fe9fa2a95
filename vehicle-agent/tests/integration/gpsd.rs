//! Interoperation with gpsd: the real daemon between a simulated receiver and the driver, and `gpsdecode` as an independent
//! decoder.

use crate::common::devices::Devices;
use crate::common::receiver::{HEADING_RAD, PLACE_RAD, epoch_at};
use crate::common::{Console, DEADLINE, program};
use crate::hardware::sail;
use devices::{GnssReading, Quality, Reading};
use drivers::gnss::CompassSettings;
use drivers::gpsd::{Gpsd, Watch};
use drivers::{Driver, Input, Output};
use imc::messages::GpsFix;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use serde_json::Value;
use std::fs::File;
use std::io::{ErrorKind, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use units::{MonoTime, Now, UtcTime};

/// Whether a program of gpsd is installed; prints what to install if not.
fn is_there(tool: &str) -> bool {
    let version = Command::new(tool).arg("-V").stdout(Stdio::null()).stderr(Stdio::null()).status();
    if version.is_err() {
        testkit::absent(testkit::Need::Gpsd, "apt-get install gpsd gpsd-clients");
    }
    version.is_ok()
}

/// The lines of JSON that a program prints.
fn lines(command: &mut Command) -> Vec<Value> {
    let output = command.output().unwrap();
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// The same recording as read by `lutra-agent sniff` and by gpsdecode.
fn both(path: &Path) -> (Vec<Value>, Vec<Value>) {
    let ours = lines(program().args(["sniff", "--json", "--device", "gnss"]).arg(path));
    assert!(ours.iter().all(|one| one["error"].is_null()), "{ours:?}");
    (ours, lines(Command::new("gpsdecode").stdin(File::open(path).unwrap())))
}

fn of_class<'a>(reports: &'a [Value], class: &str) -> Vec<&'a Value> {
    reports.iter().filter(|report| report["class"] == class).collect()
}

fn assert_near(what: &str, ours: f64, theirs: f64, tolerance: f64) {
    assert!((ours - theirs).abs() <= tolerance, "{what}: {ours} by us, {theirs} by gpsdecode");
}

/// Our epoch at the time of a report, which has milliseconds.
fn epoch_of<'a>(ours: &'a [Value], report: &Value) -> &'a Value {
    let time = report["time"].as_str().unwrap().trim_end_matches('Z');
    let is_of = |one: &&Value| one["utc"].as_str().is_some_and(|utc| utc.starts_with(time));
    ours.iter().find(is_of).unwrap_or_else(|| panic!("no epoch of {time}"))
}

/// Compares position, time, quality and dilution of each report of gpsdecode with our epoch of that time; returns how many.
///
/// Tolerances are half of the last digit that gpsdecode prints: 1e-9 degrees, and a thousandth of a metre of `eph`, which is the
/// horizontal dilution times 4.75 m with corrections and 19 m without (gpsd's `H_UERE_WITH_DGPS` and `H_UERE_NO_DGPS`). Times
/// are the same to the millisecond. gpsdecode omits the status for an autonomous position.
fn compare_positions(ours: &[Value], theirs: &[Value]) -> usize {
    let reports = of_class(theirs, "TPV");
    for report in &reports {
        let epoch = epoch_of(ours, report);
        for (our, their) in [("lat_deg", "lat"), ("lon_deg", "lon")] {
            assert_near(our, epoch[our].as_f64().unwrap(), report[their].as_f64().unwrap(), 0.6e-9);
        }
        let quality = epoch["quality"].as_u64().unwrap();
        assert_eq!(quality, report["status"].as_u64().unwrap_or(1), "{epoch} and {report}");
        let error_m = if quality == 1 { 19.0 } else { 4.75 };
        assert_near("eph", error_m * epoch["hdop"].as_f64().unwrap(), report["eph"].as_f64().unwrap(), 1e-3);
    }
    reports.len()
}

/// Headings, in the order of the recording: gpsdecode gives them no time. A thousandth of a degree is what it prints.
fn compare_headings(ours: &[Value], theirs: &[Value]) -> usize {
    let theirs = of_class(theirs, "ATT");
    let ours: Vec<f64> = ours.iter().filter_map(|epoch| epoch["heading_rad"].as_f64()).collect();
    assert_eq!(ours.len(), theirs.len());
    for (heading_rad, report) in ours.iter().zip(&theirs) {
        assert_near("heading", heading_rad.to_degrees(), report["heading"].as_f64().unwrap(), 0.6e-3);
    }
    theirs.len()
}

#[test]
fn gpsdecode_reads_the_same_positions_times_qualities_and_headings() {
    if !is_there("gpsdecode") {
        return;
    }
    let Some(path) = testkit::shared("data/onboard/v104s_made.nmea") else { return };
    let (ours, theirs) = both(&path);
    assert_eq!(ours.len(), 20);
    // Before it has a date gpsdecode has no time, and reports no position.
    assert_eq!((compare_positions(&ours, &theirs), compare_headings(&ours, &theirs)), (19, 20));
}

/// A sentence with its checksum.
fn sentence(body: &str) -> String {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n")
}

/// Degrees and minutes.
fn angle(degrees: f64, width: usize) -> String {
    format!("{:0width$}{:010.7}", degrees.trunc(), degrees.fract() * 60.0)
}

/// A row of the values that the recording of the V104s was made of, written as a receiver with RMC, GSA and GSV does: gpsd
/// 3.22 ignores VTG, and reports satellites together with those in view, of which there are twelve here.
fn said(row: &str) -> String {
    let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
    let [utc_s, lat_rad, lon_rad, quality, satellites, hdop, _, cog_rad, sog_mps, psi_rad, ..] = cells[..]
    else {
        panic!("{row}")
    };
    let time = format!("{:02}{:02}{:05.2}", utc_s as u32 / 3600, utc_s as u32 / 60 % 60, utc_s % 60.0);
    let degrees = |angle_rad: f64| angle_rad.to_degrees().rem_euclid(360.0);
    let place = format!("{},N,{},E", angle(degrees(lat_rad), 2), angle(degrees(lon_rad), 3));
    let view = |from: u32| {
        let satellites: Vec<String> =
            (from..from + 4).map(|n| format!("{n:02},45,{:03},40", n * 20)).collect();
        satellites.join(",")
    };
    let used: String =
        (1..=12).map(|n| if f64::from(n) <= satellites { format!("{n:02},") } else { ",".into() }).collect();
    let mode = if quality > 1.0 { 'D' } else { 'A' };
    [
        sentence(&format!("GPGSV,3,1,12,{}", view(1))),
        sentence(&format!("GPGSV,3,2,12,{}", view(5))),
        sentence(&format!("GPGSV,3,3,12,{}", view(9))),
        sentence(&format!("GPGSA,A,3,{used}1.5,{hdop},1.2")),
        sentence(&format!(
            "GPRMC,{time},A,{place},{:.3},{:.2},211126,,,{mode}",
            sog_mps * 3600.0 / 1852.0,
            degrees(cog_rad)
        )),
        sentence(&format!("GPGGA,{time},{place},{quality},{satellites:02},{hdop},1.10,M,39.16,M,,")),
        sentence(&format!("GPHDT,{:.2},T", degrees(psi_rad))),
    ]
    .concat()
}

/// Course and speed to half of the last digit that gpsdecode prints (1e-4 degrees and 1e-3 m/s), satellites exactly.
#[test]
fn gpsdecode_reads_the_same_courses_speeds_and_satellites() {
    if !is_there("gpsdecode") {
        return;
    }
    let Some(path) = testkit::shared("data/onboard/v104s_made_expected.csv") else { return };
    let file = tempfile::NamedTempFile::new().unwrap();
    let text = std::fs::read_to_string(path).unwrap();
    std::fs::write(file.path(), text.lines().skip(1).map(said).collect::<String>()).unwrap();
    let (ours, theirs) = both(file.path());
    assert_eq!(ours.len(), 20);
    assert_eq!((compare_positions(&ours, &theirs), compare_headings(&ours, &theirs)), (19, 20));
    for report in of_class(&theirs, "TPV") {
        let epoch = epoch_of(&ours, report);
        let course_deg = epoch["cog_rad"].as_f64().unwrap().to_degrees();
        assert_near("course", course_deg, report["track"].as_f64().unwrap(), 0.6e-4);
        assert_near("speed", epoch["sog_mps"].as_f64().unwrap(), report["speed"].as_f64().unwrap(), 0.6e-3);
    }
    // gpsdecode reports the satellites when those in view are complete, which is before the GSA of the same second.
    let skies = of_class(&theirs, "SKY");
    assert_eq!(skies.len(), 20);
    for (epoch, sky) in ours.iter().zip(&skies[1..]) {
        // One epoch has thirteen: a GSA has room for twelve.
        let used = epoch["sats"].as_u64().unwrap().min(12);
        assert_eq!(Some(used), sky["uSat"].as_u64(), "{epoch}");
        assert_near("hdop", epoch["hdop"].as_f64().unwrap(), sky["hdop"].as_f64().unwrap(), 0.006);
    }
}

/// The daemon, ended with the test.
struct Daemon(Child);

impl Drop for Daemon {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

/// The receiver's end of a pseudo-terminal, and the name of the other.
fn terminal() -> (File, String) {
    let receiver = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    grantpt(&receiver).unwrap();
    unlockpt(&receiver).unwrap();
    let name = ptsname(&receiver, Vec::new()).unwrap().into_string().unwrap();
    (File::from(receiver), name)
}

/// A real gpsd that reads a terminal and listens at a free port.
fn gpsd_on(terminal: &Path) -> (Daemon, u16) {
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let daemon = Command::new("gpsd")
        .args(["-N", "-n", "-b", "-s", "115200", "-f", "8N1", "-S", &port.to_string()])
        .arg(terminal)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    (Daemon(daemon.unwrap()), port)
}

/// The first reading with position and heading from a real gpsd.
fn first_reading(watch: Watch) -> GnssReading {
    let (mut receiver, name) = terminal();
    let (_daemon, port) = gpsd_on(Path::new(&name));
    let started = Instant::now();
    let now = || Now {
        mono: MonoTime::default() + started.elapsed(),
        utc: UtcTime::from_micros(SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_micros() as i64),
    };
    let mut connection = loop {
        if let Ok(connection) = TcpStream::connect(("127.0.0.1", port)) {
            break connection;
        }
        assert!(started.elapsed() < DEADLINE, "gpsd does not listen");
        std::thread::yield_now();
    };
    connection.set_read_timeout(Some(Duration::from_millis(200))).unwrap();
    let mut driver = Gpsd::new(watch, &CompassSettings::default());
    driver.handle(now(), Input::Opened);
    let mut bytes = [0; 4096];
    for count in 0.. {
        assert!(started.elapsed() < DEADLINE, "no reading by {watch:?}");
        while let Some(output) = driver.poll_output() {
            match output {
                Output::Send { bytes, .. } => connection.write_all(&bytes).unwrap(),
                Output::Reading { reading: Reading::Gnss(reading), .. }
                    if reading.fix.is_some() && reading.heading_rad.is_some() =>
                {
                    return reading;
                }
                _ => {}
            }
        }
        // The receiver sends whenever the line was quiet for a while: an epoch is complete.
        match connection.read(&mut bytes) {
            Ok(0) => panic!("gpsd hung up"),
            Ok(length) => driver.handle(now(), Input::Bytes(&bytes[..length])),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
                let utc = UtcTime::from_micros(1_795_000_000_000_000 + count * 1_000_000);
                receiver.write_all(&epoch_at(utc)).unwrap();
            }
            Err(error) => panic!("{error}"),
        }
        if driver.poll_timeout().is_some_and(|due| due <= now().mono) {
            driver.handle(now(), Input::Time);
        }
    }
    unreachable!("the deadline ends it")
}

/// Takes some seconds: gpsd needs a few epochs before it accepts a receiver.
#[test]
fn a_real_gpsd_gives_the_receivers_readings_both_ways() {
    if !is_there("gpsd") {
        return;
    }
    for watch in [Watch::Nmea, Watch::Json] {
        let reading = first_reading(watch);
        let fix = reading.fix.unwrap();
        assert!((fix.lat_rad - PLACE_RAD.0).abs() < 1e-9, "{watch:?}: {reading:?}");
        assert!((fix.lon_rad - PLACE_RAD.1).abs() < 1e-9, "{watch:?}: {reading:?}");
        assert_eq!(fix.quality, Quality::RtkFixed, "{watch:?}");
        assert!((reading.heading_rad.unwrap() - HEADING_RAD).abs() < 1e-3, "{watch:?}: {reading:?}");
    }
}

/// The simulated compass at its terminal, a real gpsd that reads it, and the whole program that sails by that.
/// Takes some seconds: all three use the computer's clock, and the boat has to gather way.
#[test]
fn a_plan_is_sailed_by_a_real_gpsd_that_reads_the_simulated_compass() {
    if !is_there("gpsd") {
        return;
    }
    let devices = Devices::start(&["--set-up"]);
    let terminal = devices.folder.path().join("dev/gnss").canonicalize().unwrap();
    let (_daemon, port) = gpsd_on(&terminal);
    let config = devices.folder.path().join("otter.ini");
    let by_gpsd = format!(
        "[Sensors.GPS]\nEnabled = Never\n[Sensors.GPSDraw]\nEnabled = Hardware\nEntity Label = GPS\n\
         GPSD - Host = 127.0.0.1\nGPSD - Port = {port}\n[Actuators.Torqeedo]\n"
    );
    let text = std::fs::read_to_string(&config).unwrap();
    let (before, from_motors) = text.split_once("[Sensors.GPS]\n").unwrap();
    let (_, from_motors) = from_motors.split_once("[Actuators.Torqeedo]\n").unwrap();
    std::fs::write(&config, format!("{before}{by_gpsd}{from_motors}")).unwrap();
    let agent = devices.agent(&[]);
    let mut console = Console::connect(&agent);
    sail(&mut console);
    devices.wait("the boat makes way", |truth| truth.speed_mps > 0.5);
    console.seen.clear();
    let (fix, utc_s) = console.wait("a position", |packet| {
        let fix = packet.get::<GpsFix>()?;
        Some((fix.clone(), packet.header.timestamp))
    });
    devices.wait("the truth of that time", |truth| truth.utc_s > utc_s);
    // gpsd passes sentences on as they arrive; the boat moves a metre in that time at most.
    let off_m = devices.off_m(utc_s, fix.lat, fix.lon);
    assert!(off_m < 2.0, "{off_m} m off: {fix:?}");
    assert!(agent.terminate().starts_with("motors stopped, log closed"));
    devices.terminate();
}
