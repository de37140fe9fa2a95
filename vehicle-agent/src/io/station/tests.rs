use super::super::port::Script;
use super::*;
use crate::hardware::{CanMotors, MotorsWire, Orders};
use crate::io::Pty;
use control::MotorPair;
use drivers::motors::{Motors, MotorsConfig};
use std::collections::VecDeque;
use std::io::Write as _;
use std::net::TcpListener;
use std::os::unix::fs::symlink;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Sender;
use std::time::Instant;
use units::UtcTime;

const DEADLINE: Duration = Duration::from_secs(20);

/// A driver that greets, reports its inputs, and answers `?` with a paced line.
#[derive(Default)]
struct Parrot {
    outputs: VecDeque<Output>,
    heard: Vec<u8>,
}

impl Parrot {
    fn note(&mut self, text: impl Into<String>) {
        self.outputs.push_back(Output::Note(Note { warning: false, text: text.into() }));
    }

    fn send(&mut self, bytes: &[u8], now: Now, pace: Duration) {
        self.outputs.push_back(Output::Send { bytes: bytes.to_vec(), at: now.mono, pace });
    }
}

impl Driver for Parrot {
    fn handle(&mut self, now: Now, input: Input<'_>) {
        match input {
            Input::Opened => {
                self.outputs.push_back(Output::State(State::Starting));
                self.send(b"hello\r", now, Duration::ZERO);
            }
            Input::Bytes(bytes) => {
                self.heard.extend(bytes);
                if bytes.contains(&b'?') {
                    self.send(b"answer", now, Duration::from_millis(1));
                }
                let text = String::from_utf8_lossy(&self.heard).into_owned();
                self.outputs.push_back(Output::State(State::Working));
                self.note(text);
            }
            Input::Lost => self.note("lost"),
            Input::Time => self.note("time"),
        }
    }

    fn poll_output(&mut self) -> Option<Output> {
        self.outputs.pop_front()
    }

    fn poll_timeout(&self) -> Option<MonoTime> {
        None
    }
}

struct Attended {
    station: Station,
    reports: Receiver<Report>,
    wake: Arc<Wake>,
}

fn attend(place: Place) -> Attended {
    attend_with(Parrot::default(), place)
}

fn attend_with(driver: impl Driver + Send + 'static, place: Place) -> Attended {
    let wake = Arc::new(Wake::new().unwrap());
    let (sent, reports): (Sender<Report>, _) = mpsc::channel();
    let sink = move |report| {
        sent.send(report).ok();
    };
    let driver = Box::new(driver);
    let station = Station::start("test", driver, place, Clock::system(), Arc::clone(&wake), sink).unwrap();
    Attended { station, reports, wake }
}

impl Attended {
    /// Waits for a matching report.
    fn wait(&self, wanted: impl Fn(&Report) -> bool) -> Report {
        loop {
            let report = self.reports.recv_timeout(DEADLINE).unwrap();
            if wanted(&report) {
                return report;
            }
        }
    }

    fn note(&self, wanted: &str) {
        self.wait(|report| matches!(report, Report::Note(note) if note.text == wanted));
    }

    fn failing(&self) -> String {
        let Report::State(State::Failing(why)) =
            self.wait(|report| matches!(report, Report::State(State::Failing(_))))
        else {
            unreachable!("only these are waited for")
        };
        why
    }
}

/// Reads at the device's end until it is this.
fn expect(pty: &mut Pty, wanted: &[u8]) {
    let (until, mut all, mut buffer) = (Instant::now() + DEADLINE, Vec::<u8>::new(), [0; 64]);
    while all.len() < wanted.len() && Instant::now() < until {
        match pty.read(&mut buffer).unwrap() {
            Some(count) => all.extend(&buffer[..count]),
            None => std::thread::yield_now(),
        }
    }
    assert_eq!(all, wanted);
}

fn serial(path: &std::path::Path) -> Place {
    Place::Serial { path: path.to_owned(), baud: 115_200 }
}

#[test]
fn a_device_is_greeted_heard_answered_and_after_a_replug_greeted_again() {
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("tbr");
    let Some(mut pty) = Pty::for_test() else { return };
    symlink(pty.path(), &link).unwrap();
    let attended = attend(serial(&link));
    expect(&mut pty, b"hello\r");
    pty.write(b"how?").unwrap();
    attended.note("how?");
    expect(&mut pty, b"answer");

    drop(pty);
    attended.note("lost");
    let why = attended.failing();
    assert!(why.contains("tbr") && why.contains("cable"), "{why}");
    std::fs::remove_file(&link).unwrap();
    let absent = attended.failing();
    assert!(absent.contains("there is no"), "{absent}");

    let mut pty = Pty::open().unwrap();
    symlink(pty.path(), &link).unwrap();
    expect(&mut pty, b"hello\r");
    attended.wait(|report| *report == Report::State(State::Starting));
    attended.station.end();
    assert!(attended.station.is_over_within(DEADLINE));
}

#[test]
fn the_bell_hands_the_driver_the_time_also_while_the_port_is_away() {
    let attended = attend(serial(std::path::Path::new("/dev/lutra-nothing")));
    attended.failing();
    attended.wake.ring();
    attended.note("time");
    attended.station.end();
    assert!(attended.station.is_over_within(DEADLINE));
}

#[test]
fn a_recording_is_played_once() {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), "line").unwrap();
    let attended = attend(Place::Recording { path: file.path().to_owned(), baud: 9600 });
    attended.note("line");
    let why = attended.failing();
    assert!(why.contains("the recording is over") && !why.contains("cable"), "{why}");
}

/// An attendant of a port whose other end is the test, with a clock that the test moves.
struct Bench {
    attendant: Attendant,
    script: Arc<Mutex<Script>>,
    now_us: Arc<AtomicU64>,
}

impl Bench {
    fn new(driver: impl Driver + Send + 'static) -> Self {
        let (script, now_us) = (Arc::<Mutex<Script>>::default(), Arc::<AtomicU64>::default());
        let elapsed = Arc::clone(&now_us);
        let elapsed = move || Duration::from_micros(elapsed.load(Ordering::Relaxed));
        let attendant = Attendant {
            port: Some(Port::Scripted(Arc::clone(&script))),
            ..Attendant::new(
                Box::new(driver),
                Place::Can("can0".to_owned()),
                Clock::of(elapsed, UtcTime::default),
                Arc::new(Wake::new().unwrap()),
                Box::new(|_: Report| {}),
            )
        };
        Self { attendant, script, now_us }
    }

    /// Runs the loop until a time, each cycle after the wait that it requests; returns the number of cycles.
    fn run_to(&mut self, until_ms: u64) -> usize {
        for turns in 0.. {
            self.attendant.tick();
            self.attendant.write();
            let now = self.attendant.clock.now().mono;
            let wait = self.attendant.longest_wait(now);
            let next = now.micros() + u64::try_from(wait.as_micros()).unwrap().max(1);
            self.now_us.store(next.min(until_ms * 1000), Ordering::Relaxed);
            if next >= until_ms * 1000 {
                return turns;
            }
        }
        unreachable!("the count does not end")
    }

    /// Tries to open the port and advances to the next attempt; returns the wait (ms).
    fn wait_to_open(&mut self) -> u64 {
        self.attendant.open();
        let now_us = self.now_us.load(Ordering::Relaxed);
        let open_at_us = self.attendant.open_at.micros();
        self.now_us.store(open_at_us, Ordering::Relaxed);
        open_at_us.saturating_sub(now_us) / 1000
    }

    /// Reads until the condition holds, as bytes of a socket arrive asynchronously.
    fn read_until(&mut self, wanted: impl Fn(&Attendant) -> bool) {
        let until = Instant::now() + DEADLINE;
        while !wanted(&self.attendant) {
            assert!(Instant::now() < until);
            self.attendant.read(&mut [0; 64]);
            std::thread::yield_now();
        }
    }

    /// The throttles that the port has taken, as motor 0 gets them.
    fn taken(&self) -> Vec<i16> {
        let taken = std::mem::take(&mut self.script.lock().unwrap().taken);
        let frames = taken.chunks_exact(16).filter(|frame| frame[..4] == (0x80D0_FEAB_u32).to_ne_bytes());
        frames.map(|frame| i16::from_le_bytes([frame[8], frame[9]])).collect()
    }
}

#[test]
fn a_bus_that_takes_nothing_costs_no_time_and_gets_no_stale_throttle_when_it_takes_again() {
    let orders = Arc::new(Orders::default());
    let motors = Motors::new(MotorsConfig::default()).unwrap();
    let driver = CanMotors::new(motors, MotorsWire::Kernel(Vec::new()), Arc::clone(&orders));
    let mut bench = Bench::new(driver);
    bench.attendant.tell(Input::Opened);
    // The loop commands ahead for three seconds while no device acknowledges on the bus.
    let mut turns = 0;
    for ms in (0..3000).step_by(100) {
        orders.put(MonoTime::from_micros(ms * 1000), MotorPair { port: 1.0, starboard: 1.0 });
        bench.attendant.tell(Input::Time);
        turns += bench.run_to(ms + 100);
    }
    assert!(turns <= 400, "{turns} turns in 3 s, each after 10 ms at least");
    assert!((200..=400).contains(&bench.script.lock().unwrap().offers), "{:?}", bench.script);
    // It gets a stop, and then the bus is back: the stop is sent first, and no earlier throttle.
    orders.put(MonoTime::from_micros(3_000_000), MotorPair::STOPPED);
    bench.attendant.tell(Input::Time);
    bench.run_to(3050);
    bench.script.lock().unwrap().takes = usize::MAX;
    bench.run_to(4000);
    let taken = bench.taken();
    assert!(!taken.is_empty() && taken.iter().all(|throttle| *throttle == 0), "{taken:?}");

    // Nor is a command sent after its time without a refresh.
    bench.script.lock().unwrap().takes = 0;
    orders.put(MonoTime::from_micros(4_000_000), MotorPair { port: 1.0, starboard: 1.0 });
    bench.attendant.tell(Input::Time);
    bench.run_to(4500);
    bench.script.lock().unwrap().takes = 16;
    bench.run_to(6000);
    assert_eq!(bench.taken(), [0]);
}

#[test]
fn a_stream_that_brings_nothing_for_too_long_is_opened_again() {
    /// A driver of a device that always has a deadline due.
    struct Restless(Parrot);

    impl Driver for Restless {
        fn handle(&mut self, now: Now, input: Input<'_>) {
            self.0.handle(now, input);
        }

        fn poll_output(&mut self) -> Option<Output> {
            self.0.poll_output()
        }

        fn poll_timeout(&self) -> Option<MonoTime> {
            None
        }

        fn longest_silence(&self) -> Option<Duration> {
            Some(Duration::from_millis(100))
        }
    }

    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let place = Place::Tcp(listener.local_addr().unwrap().to_string());
    let attended = attend_with(Restless(Parrot::default()), place);
    let silent = listener.accept().unwrap().0;
    let why = attended.failing();
    assert!(why.contains("nothing came for 0.1 s"), "{why}");
    // The second connection comes while the first is still open.
    let second = listener.accept().unwrap();
    drop((silent, second));
    attended.station.end();
    assert!(attended.station.is_over_within(DEADLINE));
}

#[test]
fn a_server_that_is_away_is_tried_after_waits_that_double_until_it_has_said_something() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    drop(listener);
    let mut bench = Bench::new(Parrot::default());
    bench.attendant.port = None;
    bench.attendant.place = Place::Tcp(address.to_string());
    // Refused at once, each time.
    let mut waits_ms = Vec::new();
    for _ in 0..7 {
        waits_ms.push(bench.wait_to_open());
    }
    assert_eq!(waits_ms, [500, 1000, 2000, 4000, 8000, 10_000, 10_000]);
    // It accepts, and closes without sending data: that is no success.
    let listener = TcpListener::bind(address).unwrap();
    bench.attendant.open();
    drop(listener.accept().unwrap());
    bench.read_until(|attendant| attendant.port.is_none());
    assert_eq!(bench.wait_to_open(), 10_000);
    // It sends data, and closes.
    bench.attendant.open();
    let mut server = listener.accept().unwrap().0;
    server.write_all(b"word").unwrap();
    drop((server, listener));
    bench.read_until(|attendant| attendant.port.is_none());
    assert_eq!((bench.wait_to_open(), bench.wait_to_open()), (500, 1000));
}
