//! Positions from sources other than a serial port: a TCP stream, datagrams, a recording. The whole program with each, and
//! its behaviour when the other end disappears and returns.
//!
//! Nothing sleeps: every wait is for a packet or a connection, with a deadline.

use crate::common::receiver::{HEADING_RAD, PLACE_RAD, epoch, epoch_at};
use crate::common::{Agent, Console, DEADLINE, ini, program};
use imc::messages::{EntityState, EntityStateState, EulerAngles, GpsFix};
use onboard::Entity;
use std::io::Write as _;
use std::net::{SocketAddr, TcpListener, TcpStream, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tempfile::TempDir;
use units::UtcTime;

/// Time between two epochs of the simulated receivers.
const PERIOD: Duration = Duration::from_millis(200);

/// A vessel whose compass is at this place, and that has no other device.
fn vessel(place: &str, more: &str) -> (TempDir, Agent) {
    let folder = TempDir::new().unwrap();
    std::fs::copy(ini(), folder.path().join("base.ini")).unwrap();
    let config = folder.path().join("otter.ini");
    let text = format!(
        "[Require base.ini]\n[Sensors.GPS]\nSerial Port - Device = {place}\n{more}\
         [Actuators.Torqeedo]\nEnabled = Never\n[Sensors.ThelmaHydrophone]\nEnabled = Never\n"
    );
    std::fs::write(&config, text).unwrap();
    let mut command = program();
    command.arg("run").arg(&config).args(["--log-level", "off", "--profile", "Hardware"]);
    let agent = Agent::spawn(&mut command, folder.path(), &[]);
    (folder, agent)
}

/// Waits for the simulated receiver's position and heading.
fn wait_position(console: &mut Console) {
    let fix = console.wait_for::<GpsFix>("a position", |fix| fix.satellites == 9);
    assert!((fix.lat - PLACE_RAD.0).abs() < 1e-9 && (fix.lon - PLACE_RAD.1).abs() < 1e-9, "{fix:?}");
    let angles = console.wait_for::<EulerAngles>("a heading", |_| true);
    // Two decimals of a degree.
    assert!((angles.psi - HEADING_RAD).abs() < 1e-4, "{angles:?}");
}

fn wait_error(console: &mut Console, words: &str) {
    console.wait(words, |packet| {
        let said = packet.get::<EntityState>().filter(|_| packet.header.src_ent == Entity::Gps.number())?;
        (said.state == EntityStateState::Error && said.description.to_str_lossy().contains(words))
            .then_some(())
    });
}

/// A receiver that sends epochs repeatedly until it is ended.
struct Speaking(Arc<AtomicBool>, Option<JoinHandle<()>>);

impl Speaking {
    fn start(mut say: impl FnMut(&[u8]) -> std::io::Result<()> + Send + 'static) -> Self {
        let end = Arc::new(AtomicBool::new(false));
        let ends = Arc::clone(&end);
        let speak = move || {
            while !ends.load(Ordering::Relaxed) && say(&epoch()).is_ok() {
                std::thread::park_timeout(PERIOD);
            }
        };
        let thread = std::thread::Builder::new().spawn(speak).unwrap();
        Self(end, Some(thread))
    }

    fn stream(mut stream: TcpStream) -> Self {
        Self::start(move |bytes| stream.write_all(bytes))
    }
}

impl std::ops::Drop for Speaking {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
        if let Some(thread) = self.1.take() {
            thread.thread().unpark();
            thread.join().ok();
        }
    }
}

/// Listens again on a listener's port, which may have been assigned as local port of a connection meanwhile.
fn listen_again(address: SocketAddr) -> TcpListener {
    let until = Instant::now() + DEADLINE;
    loop {
        match TcpListener::bind(address) {
            Ok(listener) => return listener,
            Err(error) => assert!(Instant::now() < until, "{address}: {error}"),
        }
        std::thread::yield_now();
    }
}

#[test]
fn sentences_by_a_stream_are_positions_and_a_server_that_went_away_is_found_again() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let (_folder, agent) = vessel(&format!("tcp://{address}"), "");
    let mut console = Console::connect(&agent);
    let speaking = Speaking::stream(listener.accept().unwrap().0);
    wait_position(&mut console);
    // The server and its port are gone; connections are refused.
    drop((listener, speaking));
    wait_error(&mut console, "is the device's server on");
    let listener = listen_again(address);
    let _speaking = Speaking::stream(listener.accept().unwrap().0);
    console.seen.clear();
    wait_position(&mut console);
    assert!(agent.terminate().starts_with("motors stopped, log closed"));
}

#[test]
fn sentences_by_datagrams_are_positions_and_silence_is_told_until_they_come_again() {
    // A port that is probably free.
    let address = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let (_folder, agent) = vessel(&format!("udp://{address}"), "Input Timeout = 1\n");
    let mut console = Console::connect(&agent);
    let speak = || {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        // A port that is not open yet refuses: the receiver ignores that.
        Speaking::start(move |bytes| {
            socket.send_to(bytes, address).ok();
            Ok(())
        })
    };
    let speaking = speak();
    wait_position(&mut console);
    drop(speaking);
    wait_error(&mut console, "nothing came for 1 s");
    let _speaking = speak();
    wait_position(&mut console);
    assert!(agent.terminate().starts_with("motors stopped, log closed"));
}

#[test]
fn a_recording_gives_its_positions_once_and_its_end_is_told() {
    let file = tempfile::NamedTempFile::new().unwrap();
    // The positions of a quarter of a minute, a second apart by their own time.
    let epoch_of = |second: i64| epoch_at(UtcTime::from_micros(1_795_000_000_000_000 + second * 1_000_000));
    let text: Vec<u8> = (0..15).flat_map(epoch_of).collect();
    std::fs::write(file.path(), &text).unwrap();
    let place = format!("file:{}", file.path().display());
    let (_folder, agent) = vessel(&place, "Serial Port - Baud Rate = 19200\n");
    let mut console = Console::connect(&agent);
    wait_position(&mut console);
    wait_error(&mut console, "the recording is over");
    let fixes = console.seen.iter().filter(|packet| packet.get::<GpsFix>().is_some()).count();
    // At the speed of the line: those from before the console connected are not seen.
    assert!((2..=15).contains(&fixes), "{fixes}");
    assert!(agent.terminate().starts_with("motors stopped, log closed"));
}

#[test]
fn a_stream_that_comes_about_and_says_nothing_is_given_up_and_tried_again() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let (_folder, agent) =
        vessel(&format!("tcp://{}", listener.local_addr().unwrap()), "Input Timeout = 3\n");
    let mut console = Console::connect(&agent);
    // Both are open: the agent drops the first on its own.
    let silent = listener.accept().unwrap();
    let _speaking = Speaking::stream(listener.accept().unwrap().0);
    wait_position(&mut console);
    drop(silent);
}
