//! Certificates that are renewed and replaced under a running server, with a real vessel that trusts one authority.

use crate::support::ashore::archived_bytes;
use crate::support::program::{
    Agent, Line, Process, SERVER, Server, add_admin, agent_program, link_token, run, script_token, until,
};
use crate::support::trusting::{Trusting, ask_on};
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

/// A server with a certificate that its own authority made for this computer.
fn serve(data: &Path) -> Server {
    let made = run(data, &["tls", "init", "--name", "127.0.0.1", "--name", "localhost"]);
    let config = data.join("server.toml");
    fs::write(&config, made).unwrap();
    Server::start_by(Command::new(SERVER), data, "127.0.0.1:0", &["--config", config.to_str().unwrap()])
}

fn hang_up(process: &Process) {
    let status = Command::new("kill").args(["-HUP", &process.0.id().to_string()]).status().unwrap();
    assert!(status.success());
}

/// Key first, as renewal programs write them; in between they do not match.
fn put(from: &Path, to: &Path) {
    for file in ["server-key.pem", "server.pem"] {
        let part = to.join("part");
        fs::copy(from.join(file), &part).unwrap();
        fs::rename(part, to.join(file)).unwrap();
    }
}

/// Has the vessel reconnect: its connection is cut until it has requested another.
async fn cut(line: &Line, server: &Server) {
    let asked = line.accepted();
    line.cut();
    until("asked for another connection", || (line.accepted() > asked).then_some(())).await;
    line.passes(server.web);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_vessel_takes_a_renewed_certificate_as_it_is_and_refuses_a_foreign_one() {
    let Some(program) = agent_program() else { return };
    let scratch = tempfile::tempdir().unwrap();
    let at = |name: &str| scratch.path().join(name);
    let (data, aboard) = (at("data"), at("aboard"));
    fs::create_dir(&aboard).unwrap();
    let token = link_token(&data, "otter-1", "0x2810");
    let mut server = serve(&data);
    let tls = data.join("tls");
    // As from a bundle: a copy that is not changed again.
    fs::copy(tls.join("ca.pem"), aboard.join("ca.pem")).unwrap();
    let ours = Trusting::new(&aboard.join("ca.pem"));
    let served = |who: &Trusting| who.certificate(server.web, "127.0.0.1").ok();
    let first = served(&ours).unwrap();
    let line = Line::to(server.web).await;
    let agent = Agent::start_encrypted(&program, &aboard, line.address, &token, &aboard.join("ca.pem"));
    let more_ashore = async |what: &str| {
        let more = archived_bytes(&data);
        until(what, || (archived_bytes(&data) > more).then_some(())).await;
    };
    more_ashore("ashore by an encrypted link").await;
    let mut kept = ours.connect(server.web, "127.0.0.1").unwrap();
    assert_eq!(ask_on(&mut kept, "/readyz"), "200");

    // The renewed certificate is used automatically, and connected clients notice nothing.
    let told = run(&data, &["tls", "renew"]);
    assert!(told.contains("server.pem is renewed until") && told.contains("127.0.0.1, localhost"), "{told}");
    until("served with the renewed one", || served(&ours).filter(|now| *now != first)).await;
    more_ashore("ashore by the same connection").await;
    assert_eq!((line.accepted(), ask_on(&mut kept, "/readyz").as_str()), (1, "200"));
    // A vessel that reconnects accepts it.
    cut(&line, &server).await;
    more_ashore("ashore again").await;
    assert!(line.accepted() >= 2);
    assert!(!agent.errors().contains("certificate"), "{}", agent.errors());

    // A certificate of another authority is served, since it is valid, and the vessel refuses it.
    let (other, own) = (at("other"), at("own"));
    run(&other, &["tls", "init", "--name", "127.0.0.1"]);
    fs::create_dir(&own).unwrap();
    put(&tls, &own);
    put(&other.join("tls"), &tls);
    hang_up(&server.process);
    let theirs = Trusting::new(&other.join("tls/ca.pem"));
    until("served with the foreign one", || served(&theirs)).await;
    assert!(served(&ours).is_none(), "who trusts the fleet's authority refuses it");
    cut(&line, &server).await;
    until("refused aboard", || agent.errors().contains("certificate").then_some(())).await;
    let refused_at = archived_bytes(&data);
    let told = Command::new(SERVER).args(["tls", "renew", "--data"]).arg(&data).output().unwrap();
    let told = String::from_utf8_lossy(&told.stderr).into_owned();
    assert!(told.contains("was not made by") && told.contains("renew it where it was made"), "{told}");
    // Nothing of that reached the shore.
    assert_eq!(archived_bytes(&data), refused_at);

    // With the fleet's own it connects again automatically.
    put(&own, &tls);
    hang_up(&server.process);
    until("served with the own one", || served(&ours)).await;
    until("ashore again", || (archived_bytes(&data) > refused_at).then_some(())).await;
    server.process.terminate();
}

/// A browser that offers HTTP/2 gets HTTP/1.1, whose connections the pages share so that one is free for STOP.
#[test]
fn an_encrypted_server_speaks_http1_alone() {
    let scratch = tempfile::tempdir().unwrap();
    let data = scratch.path().join("data");
    let mut server = serve(&data);
    let ours = Trusting::new(&data.join("tls/ca.pem"));
    let chosen = |offered: &[&str]| ours.protocol(server.web, "localhost", offered);
    assert_eq!(chosen(&["h2", "http/1.1"]).as_deref(), Some("http/1.1"));
    assert_eq!(chosen(&[]), None);
    server.process.terminate();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn stop_gets_through_in_a_browser_whose_connections_all_hang() {
    let Some(program) = agent_program() else { return };
    if !testkit::browser::is_there() {
        return;
    }
    let scratch = tempfile::tempdir().unwrap();
    let at = |name: &str| scratch.path().join(name);
    let (data, aboard) = (at("data"), at("aboard"));
    fs::create_dir(&aboard).unwrap();
    let token = link_token(&data, "otter-1", "0x2810");
    add_admin(&data, "nils", "seven small boats");
    let script = script_token(&data);
    let mut server = serve(&data);
    let _agent = Agent::start_encrypted(&program, &aboard, server.web, &token, &data.join("tls/ca.pem"));
    let url = format!("https://127.0.0.1:{}", server.web.port());
    testkit::browser::run("held.mjs", &[&url, "0", &script, "seven small boats", "http/1.1"], |_| {});
    server.process.terminate();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_cannot_be_served_with_is_told_and_the_earlier_pair_stays() {
    let scratch = tempfile::tempdir().unwrap();
    let data = scratch.path().join("data");
    let mut server = serve(&data);
    let tls = data.join("tls");
    let ours = Trusting::new(&tls.join("ca.pem"));
    let first = ours.certificate(server.web, "localhost").unwrap();
    for (file, wrong) in
        [("server.pem", fs::read(tls.join("ca.pem")).unwrap()), ("server-key.pem", b"x".to_vec())]
    {
        let whole = fs::read(tls.join(file)).unwrap();
        fs::write(tls.join(file), wrong).unwrap();
        hang_up(&server.process);
        let is_told = || {
            let log = server.log();
            let line = log
                .lines()
                .find(|line| line.contains("a new certificate cannot be used") && line.contains(file));
            line.map(str::to_owned)
        };
        let line = until("told", is_told).await;
        assert!(line.contains("WARN") && (line.contains("put both") || line.contains("tls init")), "{line}");
        assert_eq!(ours.certificate(server.web, "localhost").unwrap(), first);
        fs::write(tls.join(file), whole).unwrap();
        hang_up(&server.process);
        let again = "certificate and key were read again";
        let times = server.log().matches(again).count();
        until("read again", || (server.log().matches(again).count() > times || times > 0).then_some(()))
            .await;
    }
    server.process.terminate();
}

#[test]
fn two_programs_do_not_make_certificates_at_once() {
    let scratch = tempfile::tempdir().unwrap();
    let data = scratch.path().join("data");
    run(&data, &["tls", "init", "--name", "localhost"]);
    let tls = data.join("tls");
    let command = |arguments: &[&str]| {
        let mut command = Command::new(SERVER);
        command.arg("tls").args(arguments).arg("--data").arg(&data);
        command.stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    };
    let both = [&["init", "--renew", "--name", "localhost"] as &[&str], &["renew"]];
    let read = || ["server.pem", "server-key.pem", "ca.pem"].map(|file| fs::read(tls.join(file)).unwrap());
    // While this process holds the lock, others change nothing and report the process.
    let lock = fs::File::options().write(true).open(tls.join("making.lock")).unwrap();
    lock.try_lock().unwrap();
    fs::write(tls.join("making.lock"), std::process::id().to_string()).unwrap();
    let before = read();
    for arguments in both {
        let output = command(arguments).output().unwrap();
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        let holder = format!("(process {})", std::process::id());
        assert!(output.status.code() == Some(1) && told.contains(&holder), "{told}");
    }
    assert!(read() == before);
    drop(lock);
    // Both at once, as a timer and a person: each is done or refused, one at least is done, and the pair fits.
    for _ in 0..5 {
        let running = both.map(|arguments| command(arguments).spawn().unwrap());
        let outputs = running.map(|child| child.wait_with_output().unwrap());
        for output in &outputs {
            let told = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.success() || told.contains("another `lutra-server tls`"), "{told}");
        }
        assert!(outputs.iter().any(|output| output.status.success()));
        let config = data.join("server.toml");
        let [certificate, key] = ["server.pem", "server-key.pem"].map(|file| tls.join(file));
        fs::write(&config, format!("[tls]\ncertificate = {certificate:?}\nkey = {key:?}\n")).unwrap();
        let told = run_doctor(&data, &config);
        assert!(told.contains("ok    encryption"), "{told}");
    }
}

fn run_doctor(data: &Path, config: &Path) -> String {
    let mut command = Command::new(SERVER);
    command.args(["doctor", "--set", "http.listen=127.0.0.1:0", "--config"]).arg(config);
    let output = command.arg("--data").arg(data).output().unwrap();
    String::from_utf8_lossy(&output.stdout).into_owned()
}
