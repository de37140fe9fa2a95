//! `lutra-server demo` with the real server and real agents: it works as documented and leaves nothing behind.

use crate::support::browser::Browser;
use crate::support::slow::SlowLine;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::thread::sleep;
use std::time::{Duration, Instant};
use testkit::{Need, absent};

const PROGRAM: &str = env!("CARGO_BIN_EXE_lutra-server");
/// Longer than anything here takes on a loaded machine.
const PATIENCE: Duration = Duration::from_mins(2);
/// How often conditions are checked.
const LOOK_EVERY: Duration = Duration::from_millis(100);

/// Whether the agent is there, which cargo builds with the whole workspace; prints a note if not.
///
/// # Panics
/// When it is missing and must be there: see [`absent`].
fn agent_is_there() -> bool {
    let agent = Path::new(PROGRAM).with_file_name("lutra-agent");
    if agent.exists() {
        return true;
    }
    absent(Need::Agent, "cargo build -p vehicle-agent");
    false
}

/// A running demo.
struct Demo {
    child: Child,
    lines: Receiver<String>,
    said: Vec<String>,
    /// What its server logged.
    logged: Arc<Mutex<Vec<String>>>,
}

impl Demo {
    /// Only Otters that sail, nothing else.
    fn start(arguments: &[&str]) -> Self {
        Self::whole(&[&["--no-cut", "--no-past"], arguments].concat())
    }

    fn whole(arguments: &[&str]) -> Self {
        let mut command = Command::new(PROGRAM);
        command.args(["demo", "--listen", "127.0.0.1:0"]).args(arguments);
        let mut child = command
            .env_remove("LUTRA_DEMO_SECONDS")
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (say, lines) = channel();
        let out = BufReader::new(child.stdout.take().unwrap());
        std::thread::spawn(move || out.lines().map_while(Result::ok).try_for_each(|line| say.send(line)));
        let logged = Arc::<Mutex<Vec<String>>>::default();
        let (log, kept) = (BufReader::new(child.stderr.take().unwrap()), Arc::clone(&logged));
        std::thread::spawn(move || {
            for line in log.lines().map_while(Result::ok) {
                eprintln!("{line}");
                kept.lock().unwrap().push(line);
            }
        });
        Self { child, lines, said: Vec::new(), logged }
    }

    /// The next line with all these words.
    fn wait_for(&mut self, words: &[&str]) -> String {
        loop {
            let line = self.lines.recv_timeout(PATIENCE);
            let line = line.unwrap_or_else(|error| panic!("no {words:?} ({error}): {:#?}", self.said));
            println!("{line}");
            self.said.push(line.clone());
            if words.iter().all(|word| line.contains(word)) {
                return line;
            }
        }
    }

    /// Where the server is, and the password of its admin.
    fn address_and_password(&mut self) -> (String, String) {
        let server = self.wait_for(&["server", "log in as admin"]);
        let url = server.split_whitespace().find(|word| word.starts_with("http://")).unwrap();
        (url.to_owned(), server.rsplit(' ').next().unwrap().to_owned())
    }

    /// A line with all these words, already printed or still to come.
    fn hears(&mut self, words: &[&str]) -> String {
        let said = self.said.iter().find(|line| words.iter().all(|word| line.contains(word)));
        said.cloned().unwrap_or_else(|| self.wait_for(words))
    }

    /// Waits until all these Otters sail; returns their agents' processes.
    fn sails(&mut self, names: &[&str]) -> BTreeMap<String, u32> {
        for _ in names {
            self.wait_for(&["sails"]);
        }
        let mut agents = BTreeMap::new();
        for line in &self.said {
            if let Some((name, number)) = line.split_once("starting, process ") {
                agents.insert(name.trim().to_owned(), number.parse().unwrap());
            }
        }
        assert!(names.iter().all(|name| agents.contains_key(*name)), "{agents:?}");
        agents
    }

    fn signal(&self, name: &str) {
        signal(self.child.id(), name);
    }
}

impl Drop for Demo {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }
}

fn signal(process: u32, name: &str) {
    let sent = Command::new("kill").args([format!("-{name}"), process.to_string()]).status().unwrap();
    assert!(sent.success());
}

/// Whether a process runs; a zombie does not.
fn runs(process: u32) -> bool {
    let state = fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    state.rsplit(") ").next().is_some_and(|rest| !rest.is_empty() && !rest.starts_with('Z'))
}

fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let end = Instant::now() + PATIENCE;
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(Instant::now() < end, "not {what} within {PATIENCE:?}");
        sleep(LOOK_EVERY);
    }
}

/// Position of each vessel, approximately in metres north of the equator and east of Greenwich.
fn places(browser: &mut Browser) -> BTreeMap<String, (f64, f64)> {
    let systems: Value = serde_json::from_str(&browser.get("/api/v1/vessels")).unwrap();
    let place = |system: &Value| {
        let fix = &system["fix"];
        let (lat_deg, lon_deg) = (fix["lat_deg"].as_f64()?, fix["lon_deg"].as_f64()?);
        let north_m = lat_deg * 111_200.0;
        Some((
            system["name"].as_str()?.to_owned(),
            (north_m, lon_deg * 111_200.0 * lat_deg.to_radians().cos()),
        ))
    };
    systems.as_array().unwrap().iter().filter_map(place).collect()
}

fn folder_of(line: &str) -> PathBuf {
    line.split(" in ").nth(1).unwrap().split(',').next().unwrap().into()
}

/// A demo is ended, and another killed, as soon as its folder is there: long before its server is.
#[test]
fn one_that_is_ended_at_once_leaves_nothing_and_what_a_killed_one_left_goes_with_the_next() {
    if !agent_is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let begun = || {
        let mut command = Command::new(PROGRAM);
        command.args(["demo", "--listen", "127.0.0.1:0", "--no-cut", "--no-past", "--otters", "1"]);
        command.env("TMPDIR", folder.path()).env_remove("LUTRA_DEMO_SECONDS").stdout(Stdio::piped());
        command.spawn().unwrap()
    };
    let folders =
        || fs::read_dir(folder.path()).unwrap().flatten().map(|entry| entry.path()).collect::<Vec<_>>();
    let found = || until("a folder", || folders().into_iter().find(|folder| folder.join("lock").exists()));
    let ended = |demo: Child| String::from_utf8(demo.wait_with_output().unwrap().stdout).unwrap();
    let mut killed = begun();
    let left = found();
    killed.kill().unwrap();
    killed.wait().unwrap();
    assert_eq!(folders(), std::slice::from_ref(&left));

    let demo = begun();
    until("another folder", || {
        folders().into_iter().find(|folder| *folder != left && folder.join("lock").exists())
    });
    signal(demo.id(), "INT");
    let said = ended(demo);
    assert!(
        said.contains(&format!("removed   {}, which a demo left that was killed", left.display())),
        "{said}"
    );
    assert_eq!(folders(), Vec::<PathBuf>::new(), "{said}");
}

#[test]
fn otters_sail_before_a_browser_and_all_ends_with_it() {
    if !agent_is_there() {
        return;
    }
    let mut demo = Demo::start(&["--otters", "2"]);
    let folder = folder_of(&demo.wait_for(&["2 simulated Otters"]));
    let server = demo.wait_for(&["server", "log in as admin"]);
    let host = server.split("http://").nth(1).unwrap().split(' ').next().unwrap();
    let password = server.rsplit(' ').next().unwrap();
    let mut agents = demo.sails(&["otter-1", "otter-2"]);

    // No change of the password is required, or the next requests would be refused.
    let mut browser = Browser::log_in(host, "admin", password);
    let named = |places: BTreeMap<_, _>| Some(places).filter(|places| places.len() == 2);
    let first = until("both on the map", || named(places(&mut browser)));
    until("both under way", || {
        let now = places(&mut browser);
        let moved = |name: &String| {
            let ((north, east), (north_0, east_0)) = (now.get(name)?, first[name]);
            Some((north - north_0).hypot(east - east_0))
        };
        let far = first.keys().all(|name| moved(name).is_some_and(|moved_m| moved_m > 5.0));
        far.then_some(())
    });

    let csv = browser.get("/api/v1/export.csv?message=EstimatedState&vessel=10449");
    assert!(csv.lines().count() > 20, "{csv}");
    until("a tag heard", || {
        let (head, body) = browser.ask("GET /api/v1/export.csv?message=TBRFishTag", "", "");
        // Before the first one there is no such message.
        (head.contains(" 200 ") && body.lines().count() > 1).then_some(())
    });

    // An agent that dies is reported and restarted.
    signal(agents["otter-2"], "KILL");
    demo.wait_for(&["otter-2", "ended by itself", "started again"]);
    let again = demo.wait_for(&["otter-2", "starting, process "]);
    agents.insert("otter-2 again".to_owned(), again.rsplit(' ').next().unwrap().parse().unwrap());
    demo.wait_for(&["otter-2", "link up"]);

    demo.signal("TERM");
    demo.wait_for(&["otter-1", "from its start"]);
    let recorded = demo.wait_for(&["packets recorded"]);
    assert!(recorded.split(' ').next().unwrap().parse::<u64>().unwrap() > 100, "{recorded}");
    assert!(demo.child.wait().unwrap().success());
    for (name, process) in agents {
        assert!(!runs(process), "{name} still runs");
    }
    assert!(!folder.exists());
}

/// The pages of a vessel in a real browser: instruments, plots, tables, STOP, and a vessel that falls silent.
#[test]
fn a_vessel_is_watched_and_stopped_in_a_browser() {
    if !agent_is_there() || !testkit::browser::is_there() {
        return;
    }
    let mut demo = Demo::start(&["--otters", "2"]);
    let (url, password) = demo.address_and_password();
    let agents = demo.sails(&["otter-1", "otter-2"]);
    testkit::browser::run("vessel.mjs", &[&url, &password], |line| match line {
        "silence otter-2" => signal(agents["otter-2"], "STOP"),
        "wake otter-2" => signal(agents["otter-2"], "CONT"),
        "stop the server" => demo.signal("STOP"),
        _ => {}
    });
    demo.signal("CONT");
    // The demonstration does not restart a vessel that a person stopped.
    demo.wait_for(&["otter-1", "commanded by admin", "leaves it alone"]);
}

/// Scripts that can share one demo: those that only look, and those that act, each on its own Otter. Two vessels over one
/// time, a plan that is drawn ashore, brought aboard and sailed, the past, parameters and plans by keyboard alone, and
/// routes around islands.
#[test]
fn otters_are_looked_at_and_sent_by_pointer_and_keyboard_in_a_browser() {
    if !agent_is_there() || !testkit::browser::is_there() {
        return;
    }
    let mut demo = Demo::start(&["--otters", "3"]);
    let (url, password) = demo.address_and_password();
    demo.sails(&["otter-1", "otter-2", "otter-3"]);
    let scripts = [
        ("beside.mjs", None),
        ("keyboard-past.mjs", None),
        ("aboard.mjs", Some("otter-2")),
        ("keyboard.mjs", Some("otter-3")),
        ("routes.mjs", Some("otter-1")),
    ];
    let mut failed = Vec::new();
    for (script, argument) in scripts {
        let begun = Instant::now();
        let arguments: Vec<&str> = [url.as_str(), password.as_str()].into_iter().chain(argument).collect();
        let ran = std::panic::catch_unwind(|| testkit::browser::run(script, &arguments, |_| {}));
        println!("{script}: {:.1} s", begun.elapsed().as_secs_f64());
        if ran.is_err() {
            failed.push(script);
        }
    }
    assert!(failed.is_empty(), "{failed:?} failed");
}

/// The past on a vessel's page: a DUNE vehicle's log and a simulated Otter, played, pointed to and taken away. Alone: on a map
/// zoomed out far, a click on its tags would meet other vessels.
#[test]
fn the_past_is_replayed_in_a_browser() {
    if !agent_is_there() || !testkit::browser::is_there() {
        return;
    }
    let mut demo = Demo::start(&["--otters", "1"]);
    let (url, password) = demo.address_and_password();
    demo.sails(&["otter-1"]);
    let log = testkit::shared("data/imc/dune_log_a/Data.lsf.gz");
    let mut arguments = vec![url.as_str(), password.as_str()];
    arguments.extend(log.as_deref().and_then(Path::to_str));
    testkit::browser::run("replay.mjs", &arguments, |_| {});
}

/// Parameters in a browser: read, checked, written with the vessel's confirmation, saved over a restart, never lost.
#[test]
fn parameters_are_read_written_and_saved_in_a_browser() {
    if !agent_is_there() || !testkit::browser::is_there() {
        return;
    }
    let mut demo = Demo::start(&["--otters", "1"]);
    let (url, password) = demo.address_and_password();
    let mut agent = demo.sails(&["otter-1"])["otter-1"];
    testkit::browser::run("params.mjs", &[&url, &password], |line| match line {
        "kill otter-1" => {
            signal(agent, "KILL");
            let again = demo.wait_for(&["otter-1", "starting, process "]);
            agent = again.rsplit(' ').next().unwrap().parse().unwrap();
        }
        "silence otter-1" => signal(agent, "STOP"),
        "wake otter-1" => signal(agent, "CONT"),
        _ => {}
    });
}

/// Plans that the fleet executes, started by anyone: sorted, drawn, and compared with those ashore.
#[test]
fn what_vessels_sail_is_seen_in_a_browser() {
    if !agent_is_there() || !testkit::browser::is_there() {
        return;
    }
    let mut demo = Demo::start(&["--otters", "2"]);
    let (url, password) = demo.address_and_password();
    demo.sails(&["otter-1", "otter-2"]);
    testkit::browser::run("sailing.mjs", &[&url, &password], |_| {});
}

/// Two people, one boat, in two browsers: control, orders and their stages, and a vessel that does not answer.
#[test]
fn a_vessel_is_commanded_by_one_of_two_people_in_a_browser() {
    if !agent_is_there() || !testkit::browser::is_there() {
        return;
    }
    let mut demo = Demo::start(&["--otters", "2"]);
    let (url, password) = demo.address_and_password();
    let agents = demo.sails(&["otter-1", "otter-2"]);
    testkit::browser::run("control.mjs", &[&url, &password], |line| match line {
        "silence otter-1" => signal(agents["otter-1"], "STOP"),
        "wake otter-1" => signal(agents["otter-1"], "CONT"),
        _ => {}
    });
}

/// Control asked for, declined, granted and taken over, and the boat steered by hand, without a pointer.
#[test]
fn a_boat_is_shared_and_steered_by_keyboard_alone_in_a_browser() {
    if !agent_is_there() || !testkit::browser::is_there() {
        return;
    }
    let mut demo = Demo::start(&["--otters", "1"]);
    let (url, password) = demo.address_and_password();
    demo.sails(&["otter-1"]);
    testkit::browser::run("keyboard-control.mjs", &[&url, &password], |_| {});
}

/// Over a slow and lossy network: pages load, values continue, orders show their stages, and no work is lost.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn work_goes_on_behind_a_slow_and_lossy_link() {
    if !agent_is_there() || !testkit::browser::is_there() {
        return;
    }
    let script = tokio::task::spawn_blocking(|| {
        let mut demo = Demo::start(&["--otters", "1"]);
        let (url, password) = demo.address_and_password();
        demo.sails(&["otter-1"]);
        let line = SlowLine::to(url.trim_start_matches("http://").parse().unwrap());
        let slow = format!("http://{}", line.address);
        testkit::browser::run("slow.mjs", &[&url, &slow, &password], |said| match said {
            "cut the line" => line.cut(true),
            "mend the line" => line.cut(false),
            _ => {}
        });
    });
    script.await.unwrap();
}

/// Besides Otters that sail: plans ashore, a mission of yesterday, a link that is cut and returns with the missed data.
#[test]
fn a_cut_link_and_yesterday_are_watched_in_a_browser() {
    if !agent_is_there() || !testkit::browser::is_there() {
        return;
    }
    let mut demo =
        Demo::whole(&["--otters", "2", "--cut-after", "5", "--cut-for", "30", "--cut-every", "3600"]);
    let (url, password) = demo.address_and_password();
    let past = demo.hears(&["/vessels/10448?"]).trim().to_owned();
    testkit::browser::run("demo.mjs", &[&url, &password, &past], |line| {
        if line == "until yesterday is in" {
            demo.hears(&["otter-0", "its log of", &past]);
        }
    });
    let filled = demo.hears(&["otter-2", "gap filled"]);
    let positions = filled.split("later: ").nth(1).unwrap().split(' ').next().unwrap();
    // At least one each second of the thirty; the rate aboard is higher.
    assert!(positions.parse::<u32>().unwrap() >= 30, "{filled}");
    // A cut by intention is no warning in the terminal of who tries the demo.
    let logged = demo.logged.lock().unwrap();
    assert!(
        !logged.iter().any(|line| line.contains("shore::links") || line.contains("shore::alarms")),
        "{logged:?}"
    );
}

#[test]
fn killed_it_takes_its_agents_along_and_by_the_clock_it_ends_well() {
    if !agent_is_there() {
        return;
    }
    let parent = tempfile::tempdir().unwrap();
    let keep = parent.path().join("demo");
    let mut demo = Demo::start(&["--otters", "1", "--keep", keep.to_str().unwrap()]);
    let agents = demo.sails(&["otter-1"]);
    demo.signal("KILL");
    until("the agent ended", || (!runs(agents["otter-1"])).then_some(()));
    assert!(fs::read_to_string(keep.join("otter-1.log")).unwrap().contains("motors stopped, log closed"));

    let again = Command::new(PROGRAM).args(["demo", "--keep"]).arg(&keep).output().unwrap();
    assert!(!again.status.success() && String::from_utf8_lossy(&again.stderr).contains("not empty"));

    let mut demo = Demo::whole(&["--otters", "1", "--seconds", "1"]);
    demo.wait_for(&["packets recorded"]);
    assert!(demo.child.wait().unwrap().success(), "{:#?}", demo.said);
}

#[test]
fn mistakes_are_told_with_their_remedy() {
    let wrong = |program: &Path, arguments: &[&str], text: &str| {
        let output = Command::new(program).arg("demo").args(arguments).env("PATH", "").output().unwrap();
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && told.contains(text), "{arguments:?}: {told}");
    };
    // The same program without an agent beside it; a link, because it is large.
    let alone = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let program = alone.path().join("lutra-server");
    fs::hard_link(PROGRAM, &program).unwrap();
    wrong(&program, &[], "`make demo` builds both");
    let here = Path::new(PROGRAM);
    wrong(here, &["--data", "x"], "--keep DIR");
    wrong(here, &["--otters", "0"], "1..=24");
    if agent_is_there() {
        wrong(here, &["--listen", "0.0.0.0:8080"], "beyond loopback");
        wrong(here, &["--listen", "192.0.2.7:8080"], "beyond loopback");
        wrong(here, &["--set", "http.listn=1"], "nearest is http.listen");
        wrong(here, &["--no-cut", "--cut-for", "5"], "cannot be used with");
    }
}
