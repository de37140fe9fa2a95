//! A real Mosquitto that everything recorded is published to: whole in the end, although it is slow, killed and emptied, and what it
//! retains only moves forward in time.

use crate::support::browser::{Browser, ask};
use crate::support::program::{Line, Process, SERVER, Server, add_admin, run, until};
use crate::support::{CONSOLE, Client, OTTER, archive_of, archived_packets, packet};
use imc::Address;
use imc::messages::{LogBookEntry, Pressure, Temperature};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

const START_S: f64 = 1_795_248_000.0;
const TOPIC: &str = "lutra/0x2810/Temperature/3";

/// A broker without storage: after a kill it is empty.
struct Broker {
    process: Process,
    address: SocketAddr,
    folder: TempDir,
}

impl Broker {
    /// Starts one with `more` in its configuration; `None`, with a note, if it is not installed.
    async fn start(more: &str) -> Option<Self> {
        let folder = TempDir::new().unwrap();
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let address = SocketAddr::from(([127, 0, 0, 1], port));
        let text = format!("listener {port} 127.0.0.1\nuser root\npersistence false\n{more}\n");
        let config = folder.path().join("mosquitto.conf");
        fs::write(&config, text).unwrap();
        let mut command = Command::new("mosquitto");
        command.arg("-c").arg(&config).stdout(Stdio::null()).stderr(Stdio::null());
        let Ok(process) = command.spawn() else {
            testkit::absent(testkit::Need::Mosquitto, "apt-get install mosquitto mosquitto-clients");
            return None;
        };
        until("up", || TcpStream::connect(address).ok()).await;
        Some(Self { process: Process(process), address, folder })
    }

    fn client(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.args(["-h", "127.0.0.1", "-p", &self.address.port().to_string(), "-q", "1"]);
        command
    }

    /// Records everything that is published from here on.
    async fn subscribe(&self) -> Subscriber {
        let file = self.folder.path().join("heard");
        let mut command = self.client("mosquitto_sub");
        command.args(["-t", "lutra/#", "-t", "marker", "-F", "%r %t %p"]);
        let process = Process(command.stdout(File::create(&file).unwrap()).spawn().unwrap());
        let subscriber = Subscriber { _process: process, file };
        until("subscribed", || {
            let status = self.client("mosquitto_pub").args(["-t", "marker", "-m", "x"]).status().unwrap();
            (status.success() && subscriber.lines().iter().any(|line| line.contains(" marker ")))
                .then_some(())
        })
        .await;
        subscriber
    }

    /// The value that is retained.
    fn retained(&self) -> u32 {
        let mut command = self.client("mosquitto_sub");
        let output = command.args(["-t", TOPIC, "-C", "1", "-W", "20"]).output().unwrap();
        let payload: Value = serde_json::from_slice(&output.stdout).unwrap();
        payload["fields"]["value"].as_f64().unwrap() as u32
    }
}

struct Subscriber {
    _process: Process,
    file: PathBuf,
}

impl Subscriber {
    fn lines(&self) -> Vec<String> {
        let text = fs::read_to_string(&self.file).unwrap();
        // The last line may be half written.
        text.split_inclusive('\n').filter(|line| line.ends_with('\n')).map(str::to_owned).collect()
    }

    /// The values that came.
    fn values(&self) -> BTreeSet<u32> {
        let lines = self.lines();
        let values = lines.iter().filter_map(|line| {
            let payload = line.split_once(TOPIC)?.1;
            let payload: Value = serde_json::from_str(payload).unwrap();
            Some(payload["fields"]["value"].as_f64().unwrap() as u32)
        });
        values.collect()
    }
}

/// A server that publishes at an address.
fn serve(data: &Path, url: &str, more: &[&str]) -> Server {
    let url = format!("sinks.mqtt.url={url}");
    let more = [&["--set", &url] as &[&str], more].concat();
    Server::start_by(Command::new(SERVER), data, "127.0.0.1:0", &more)
}

async fn say(client: &mut Client, numbers: std::ops::Range<u32>) {
    for number in numbers {
        let value = Temperature { value: number as f32 };
        client.say(&packet(OTTER, CONSOLE, START_S + f64::from(number), value)).await;
    }
}

/// Waits until the server has so many packets on its disk.
async fn recorded(data: &Path, count: usize) {
    until("recorded", || {
        let is_there = archive_of(data, OTTER).iter().all(|log| log.exists());
        (is_there && archived_packets(data, OTTER).len() == count).then_some(())
    })
    .await;
}

/// Waits until everything is published.
async fn caught_up(server: &Server) {
    until("caught up", || {
        let (_, figures) = ask(server.web, "/metrics");
        figures.contains("lutra_sink_waiting_bytes{sink=\"mqtt\"} 0\n").then_some(())
    })
    .await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn all_is_published_although_the_broker_is_slow_killed_and_emptied() {
    // Without limits of its own: everything it has confirmed was passed to the subscribers.
    let anonymous = "allow_anonymous true\nmax_inflight_messages 0\nmax_queued_messages 0";
    let Some(mut broker) = Broker::start(anonymous).await else { return };
    let scratch = TempDir::new().unwrap();
    let data = scratch.path().join("data");
    let line = Line::to(broker.address).await;
    let url = format!("mqtt://{}", line.address);
    let mut server = serve(&data, &url, &[]);
    let mut client = Client::connect(server.proxy).await;
    let subscriber = broker.subscribe().await;
    say(&mut client, 0..10).await;
    until("published", || (subscriber.values().len() == 10).then_some(())).await;

    // A slow broker delays nothing: everything is recorded long before it is published.
    line.carries(30_000);
    say(&mut client, 10..1_500).await;
    recorded(&data, 1_500).await;
    assert!(subscriber.values().len() < 1_500, "the broker was not slow");
    // Killed in the middle; a new, empty one is started only after more data.
    let mut heard = {
        broker.process.kill();
        line.cut();
        subscriber.values()
    };
    assert!(heard.len() < 1_500);
    say(&mut client, 1_500..1_600).await;
    recorded(&data, 1_600).await;
    until("noticed", || {
        ask(server.web, "/metrics").1.contains("lutra_sink_failures_total{sink=\"mqtt\"}").then_some(())
    })
    .await;
    let broker = Broker::start(anonymous).await.unwrap();
    let subscriber = broker.subscribe().await;
    line.carries(0);
    line.passes(broker.address);
    until("whole", || {
        heard.append(&mut subscriber.values());
        (heard.len() == 1_600).then_some(())
    })
    .await;
    caught_up(&server).await;
    assert_eq!(broker.retained(), 1_599);

    // After a restart it continues where it was, and late data are published without replacing newer retained values.
    server.process.terminate();
    drop(subscriber);
    let subscriber = broker.subscribe().await;
    let server = serve(&data, &url, &[]);
    let mut client = Client::connect(server.proxy).await;
    let late = packet(OTTER, CONSOLE, START_S - 5.0, Temperature { value: 5_000.0 });
    client.say(&late).await;
    until("published late", || subscriber.values().contains(&5_000).then_some(())).await;
    caught_up(&server).await;
    // Retained values come with the subscription.
    assert_eq!(subscriber.values(), BTreeSet::from([1_599, 5_000]));
    assert_eq!(broker.retained(), 1_599);
    say(&mut client, 1_600..1_601).await;
    until("retained", || (broker.retained() == 1_600).then_some(())).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_broker_with_certificate_and_passwords_gets_what_was_recorded_before_if_that_is_wanted() {
    let scratch = TempDir::new().unwrap();
    let at = |name: &str| scratch.path().join(name);
    let data = at("data");
    run(&data, &["tls", "init", "--name", "localhost"]);
    add_admin(&data, "nils", "seven small boats");
    let mut server = serve(&data, "", &[]);
    let mut client = Client::connect(server.proxy).await;
    say(&mut client, 0..20).await;
    recorded(&data, 20).await;
    server.process.terminate();

    let passwords = at("passwords");
    let mut command = Command::new("mosquitto_passwd");
    if command.args(["-b", "-c"]).arg(&passwords).args(["lutra", "right"]).status().is_err() {
        testkit::absent(testkit::Need::Mosquitto, "apt-get install mosquitto mosquitto-clients");
        return;
    }
    fs::write(at("rules"), "user lutra\ntopic readwrite lutra/#\n").unwrap();
    let tls = data.join("tls");
    let broker = Broker::start(&format!(
        "allow_anonymous false\npassword_file {}\nacl_file {}\ncertfile {}\nkeyfile {}",
        passwords.display(),
        at("rules").display(),
        tls.join("server.pem").display(),
        tls.join("server-key.pem").display()
    ))
    .await
    .unwrap();
    let url = format!("mqtts://localhost:{}", broker.address.port());
    let authority = format!("sinks.mqtt.ca_file={}", tls.join("ca.pem").display());
    let secret = format!("sinks.mqtt.password_file={}", at("secret").display());
    let known = ["--set", &authority, "--set", "sinks.mqtt.user=lutra", "--set", &secret];
    let known = [&known as &[&str], &["--set", "sinks.mqtt.from_beginning=true"]].concat();
    // Errors are shown on the page, and a start with a correct configuration publishes everything.
    let troubles = [
        ("wrong", "lutra", "it does not let the server in; look at sinks.mqtt.user and password_file"),
        ("right", "elsewhere", "it does not let the server publish to elsewhere/#"),
    ];
    for (password, topic, trouble) in troubles {
        fs::write(at("secret"), password).unwrap();
        let topic = format!("sinks.mqtt.topic={topic}");
        let mut server = serve(&data, &url, &[&known as &[&str], &["--set", &topic]].concat());
        let mut person = Browser::log_in(&server.web.to_string(), "nils", "seven small boats");
        until(trouble, || person.get("/admin/storage").contains(trouble).then_some(())).await;
        assert!(person.get("/admin/storage").contains(&format!("MQTT {url} topic ")));
        server.process.terminate();
    }
    let server = serve(&data, &url, &known);
    caught_up(&server).await;
    let (_, figures) = ask(server.web, "/metrics");
    assert!(figures.contains("lutra_sink_lines_total{sink=\"mqtt\",what=\"kept\"} 20\n"), "{figures}");
}

/// Mosquitto refuses messages that are too large or not allowed: these are skipped, and publishing continues. It takes some
/// ten connections to find the first that is too large.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_a_broker_refuses_for_good_holds_up_nothing_and_a_broker_that_moved_gets_the_rest() {
    let scratch = TempDir::new().unwrap();
    let data = scratch.path().join("data");
    let rules = scratch.path().join("rules");
    fs::write(&rules, "topic readwrite #\ntopic deny lutra/0x2810/Pressure/#\n").unwrap();
    let acl = format!("acl_file {}", rules.display());
    let strict = format!(
        "allow_anonymous true\nmax_inflight_messages 0\nmax_queued_messages 100000\nmessage_size_limit 2000\nretain_available false\n{acl}"
    );
    let Some(mut broker) = Broker::start(&strict).await else { return };
    let mut server = serve(&data, &format!("mqtt://{}", broker.address), &[]);
    let mut client = Client::connect(server.proxy).await;
    let subscriber = broker.subscribe().await;
    say(&mut client, 0..300).await;
    for number in 0..3 {
        let text = "x".repeat(5_000).as_str().into();
        let entry = LogBookEntry { text, ..LogBookEntry::default() };
        client.say(&packet(OTTER, CONSOLE, START_S + f64::from(number), entry)).await;
        client.say(&packet(OTTER, CONSOLE, START_S + f64::from(number), Pressure { value: 1.0 })).await;
    }
    say(&mut client, 300..600).await;
    recorded(&data, 606).await;
    caught_up(&server).await;
    until("published", || (subscriber.values().len() == 600).then_some(())).await;
    let lines = subscriber.lines();
    assert!(lines.iter().all(|line| line.starts_with("0 ") && !line.contains("Pressure")), "not retained");
    // A message is at its subscribers before the broker's answer is counted.
    until("counted", || {
        let (_, figures) = ask(server.web, "/metrics");
        let has = |figure: &str| {
            figures.contains(&format!("lutra_sink_lines_total{{sink=\"mqtt\",what={figure}\n"))
        };
        (has("\"kept\"} 600") && has("\"refused\"} 6")).then_some(())
    })
    .await;
    let log = server.log();
    assert_eq!(log.matches("the broker retains nothing").count(), 1, "{log}");
    for (topic, why) in
        [("LogBookEntry", "more than the broker takes"), ("Pressure", "does not let the server publish")]
    {
        let said = log.lines().filter(|line| line.contains(topic) && line.contains(why));
        assert!(said.count() >= 1, "{topic} in {log}");
    }

    // The broker moves while messages are queued.
    broker.process.kill();
    say(&mut client, 600..650).await;
    recorded(&data, 656).await;
    server.process.terminate();
    let broker = Broker::start("allow_anonymous true").await.unwrap();
    let subscriber = broker.subscribe().await;
    let server = serve(&data, &format!("mqtt://{}", broker.address), &[]);
    caught_up(&server).await;
    until("published", || (subscriber.values().len() >= 50).then_some(())).await;
    assert!((600..650).all(|number| subscriber.values().contains(&number)));
}

/// Packets of the vessel with the lower address come first at each look: while they are denied the other one is published, also by a
/// server that was just started.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_vessel_that_the_broker_denies_holds_up_no_other_over_a_restart() {
    const OTHER: Address = Address(OTTER.0 + 1);
    let scratch = TempDir::new().unwrap();
    let data = scratch.path().join("data");
    let rules = scratch.path().join("rules");
    fs::write(&rules, "topic readwrite #\ntopic deny lutra/0x2810/#\n").unwrap();
    let Some(broker) = Broker::start(&format!("allow_anonymous true\nacl_file {}", rules.display())).await
    else {
        return;
    };
    let url = format!("mqtt://{}", broker.address);
    let mut server = serve(&data, &url, &[]);
    let subscriber = broker.subscribe().await;
    // In the first round the broker takes something first.
    let (kept, refused) = ((OTHER, "kept"), (OTTER, "refused"));
    for (round, vessels) in [[kept, refused], [refused, kept]].into_iter().enumerate() {
        let mut client = Client::connect(server.proxy).await;
        for (vessel, what) in vessels {
            let value = Temperature { value: round as f32 };
            client.say(&packet(vessel, CONSOLE, START_S + round as f64, value)).await;
            let figure = format!("lutra_sink_lines_total{{sink=\"mqtt\",what=\"{what}\"}} 1\n");
            until(what, || ask(server.web, "/metrics").1.contains(&figure).then_some(())).await;
        }
        server.process.terminate();
        server = serve(&data, &url, &[]);
    }
    let came =
        |value: &str| subscriber.lines().iter().any(|line| line.contains("/0x2811/") && line.contains(value));
    until("published", || (came(r#""value":0"#) && came(r#""value":1"#)).then_some(())).await;
    assert!(subscriber.lines().iter().all(|line| !line.contains("/0x2810/")));
}
