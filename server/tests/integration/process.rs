//! The program itself: starting, stopping, the command line in parallel, and a browser.

use crate::support::program;
use rustls::pki_types::pem::PemObject as _;
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Output, Stdio};
use std::time::{Duration, Instant};

const PROGRAM: &str = env!("CARGO_BIN_EXE_lutra-server");

struct Server {
    child: Child,
    lines: BufReader<ChildStdout>,
    url: String,
}

impl Server {
    fn start(data: &Path, arguments: &[&str]) -> Self {
        Self::start_at("127.0.0.1:0", data, arguments)
    }

    fn start_at(listen: &str, data: &Path, arguments: &[&str]) -> Self {
        let mut child = Command::new(PROGRAM)
            .args(["serve", "--listen", listen, "--data"])
            .arg(data)
            .args(arguments)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap());
        let mut server = Self { child, lines, url: String::new() };
        let line = server.line();
        let url = line.strip_prefix("listening ");
        url.unwrap_or_else(|| panic!("{line:?}")).clone_into(&mut server.url);
        server
    }

    fn line(&mut self) -> String {
        let mut line = String::new();
        self.lines.read_line(&mut line).unwrap();
        line.trim_end().to_owned()
    }

    fn one_time_password(&mut self) -> String {
        self.line().rsplit(' ').next().unwrap().to_owned()
    }

    fn get(&self, path: &str) -> String {
        let host = self.url.split("://").nth(1).unwrap();
        let mut stream = TcpStream::connect(host).unwrap();
        write!(stream, "GET {path} HTTP/1.1\r\nhost: {host}\r\nconnection: close\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    }

    fn terminate(mut self) -> std::process::ExitStatus {
        Command::new("kill").arg(self.child.id().to_string()).status().unwrap();
        self.child.wait().unwrap()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }
}

fn run(data: &Path, arguments: &[&str]) -> Output {
    Command::new(PROGRAM).args(arguments).arg("--data").arg(data).output().unwrap()
}

fn printed(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

#[test]
fn the_service_manager_is_told_that_it_is_ready_lives_and_ends() {
    let (folder, manager) = (tempfile::tempdir().unwrap(), testkit::ServiceManager::start());
    let mut command = Command::new(PROGRAM);
    manager.watches(&mut command, Duration::from_millis(400));
    let mut server = program::Server::start_by(command, &folder.path().join("data"), "127.0.0.1:0", &[]);
    manager.waits_for("READY=1");
    for _ in 0..3 {
        assert_eq!(manager.told(), "WATCHDOG=1");
    }
    server.process.terminate();
    manager.waits_for("STOPPING=1");
}

#[test]
fn manual_pages_and_completions_are_written_from_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    assert!(Command::new(PROGRAM).arg("manual").arg(folder.path()).status().unwrap().success());
    let page = std::fs::read_to_string(folder.path().join("man/lutra-server-backup.1")).unwrap();
    assert!(page.contains("also while the server runs"), "{page}");
    assert!(folder.path().join("zsh/_lutra-server").exists());
    assert!(!folder.path().join("man/lutra-server-manual.1").exists(), "for packages only");
}

#[test]
fn it_starts_answers_and_ends_on_sigterm() {
    let folder = tempfile::tempdir().unwrap();
    let begun = Instant::now();
    let mut server = Server::start(folder.path(), &[]);
    assert!(server.get("/healthz").starts_with("HTTP/1.1 200"));
    println!("start to first answer: {} ms (first start, unoptimised)", begun.elapsed().as_millis());
    assert!(server.one_time_password().len() > 15);
    let status = std::fs::read_to_string(format!("/proc/{}/status", server.child.id())).unwrap();
    println!("{}", status.lines().find(|line| line.starts_with("VmRSS")).unwrap());
    let figures = server.get("/metrics");
    for figure in [
        "lutra_http_requests_total",
        "lutra_recording_trouble 0",
        "lutra_history_behind 0",
        "lutra_waiting_bytes 0",
        "lutra_transport_peers{transport=\"link\"} 0",
        "lutra_relay_packets_total{what=\"received\"} ",
    ] {
        assert!(figures.contains(figure), "{figure} is not in {figures}");
    }
    assert!(server.terminate().success());
    let again = Instant::now();
    let server = Server::start(folder.path(), &[]);
    assert!(server.get("/healthz").starts_with("HTTP/1.1 200"));
    println!("start to first answer: {} ms", again.elapsed().as_millis());
}

#[test]
fn the_command_line_manages_people_without_and_beside_a_server() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path();
    assert_eq!(printed(&run(data, &["user", "add", "nils", "--role", "admin"])).len(), 19);
    printed(&run(data, &["vessel", "add", "otter-1", "0x0814"]));
    assert_eq!(printed(&run(data, &["vessel", "list"])), "otter-1\t0x0814");
    assert!(printed(&run(data, &["token", "create", "--link", "otter-1"])).starts_with("lutra_link_"));
    printed(&run(data, &["user", "add", "anna"]));
    let mut passwd = Command::new(PROGRAM);
    passwd.args(["user", "passwd", "anna", "--password-stdin", "--data"]).arg(data).stdin(Stdio::piped());
    let mut passwd = passwd.spawn().unwrap();
    passwd.stdin.take().unwrap().write_all(b"seven small boats\n").unwrap();
    assert!(passwd.wait().unwrap().success());
    printed(&run(data, &["user", "add", "ola", "--role", "none"]));
    assert_eq!(
        printed(&run(data, &["user", "list"])),
        "anna\tviewer\nnils\tadmin\tone-time password\nola\tnone\tone-time password"
    );

    let server = Server::start(data, &[]);
    let token = printed(&run(data, &["token", "create", "--person", "anna", "--label", "R"]));
    let host = server.url.split("://").nth(1).unwrap();
    let me = || {
        let mut stream = TcpStream::connect(host).unwrap();
        let head = format!(
            "GET /api/v1/me HTTP/1.1\r\nhost: a\r\nconnection: close\r\nauthorization: Bearer {token}"
        );
        write!(stream, "{head}\r\n\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    };
    assert!(me().contains("\"name\":\"anna\""), "{}", me());
    let list = printed(&run(data, &["token", "list"]));
    let id = list.lines().find(|line| line.contains("anna")).unwrap().split('\t').next().unwrap();
    printed(&run(data, &["token", "revoke", id]));
    // The running server follows within a second or so.
    let end = std::time::Instant::now() + std::time::Duration::from_secs(30);
    while !me().starts_with("HTTP/1.1 401") {
        assert!(std::time::Instant::now() < end, "a revoked token still opens the transport");
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
}

#[test]
fn mistakes_are_told_with_their_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let wrong = |arguments: &[&str], text: &str| {
        let output = run(folder.path(), arguments);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && told.contains(text), "{arguments:?}: {told}");
    };
    wrong(&["user", "add", "a b", "--role", "admin"], "1 to 64 letters");
    wrong(&["user", "add", "ola", "--role", "none"], "The server needs an admin");
    wrong(&["user", "add", "ola", "--role", "captain"], "operator or admin, or none for no role");
    wrong(&["user", "passwd", "nobody"], "There is no person nobody");
    wrong(&["token", "create", "--link", "otter"], "lutra-server vessel list");
    wrong(&["serve", "--listen", "0.0.0.0:0"], "beyond loopback");
    wrong(&["serve", "--set", "http.listn=1"], "nearest is http.listen");
    wrong(&["serve", "--config", "/nowhere.toml"], "/nowhere.toml");
    let nowhere = folder.path().join("slip");
    for command in [
        &["user", "list"] as &[&str],
        &["user", "passwd", "nils"],
        &["user", "role", "nils", "admin"],
        &["user", "remove", "nils"],
        &["vessel", "list"],
        &["vessel", "remove", "otter-1"],
        &["token", "list"],
        &["token", "create", "--link", "0x0814"],
        &["register", "export", "tag"],
    ] {
        let output = run(&nowhere, command);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && told.contains("slip has no app.db"), "{command:?}: {told}");
    }
    for command in [
        &["reindex"] as &[&str],
        &["export"],
        &["import", "/nowhere.lsf"],
        &["backup", "/tmp"],
        &["prune", "--archive-before", "2020-01-01"],
    ] {
        let output = run(&nowhere, command);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            !output.status.success() && told.contains("slip is not a data folder"),
            "{command:?}: {told}"
        );
    }
    assert!(!nowhere.exists(), "nothing is made where nothing was");
}

#[test]
fn options_of_tables_are_refused_for_a_log() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("archive")).unwrap();
    let output = run(folder.path(), &["export", "--format", "lsf", "--degrees", "--field", "psi"]);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    let said = "a log has the packets as they came: leave --field, --degrees out, or write another --format";
    assert!(!output.status.success() && told.contains(said), "{told}");
}

#[test]
fn a_first_start_that_fails_leaves_the_password_to_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let (taken, transport) = (
        taken.local_addr().unwrap().to_string(),
        format!("transports.imcproxy.listen={}", taken.local_addr().unwrap()),
    );
    assert!(!run(folder.path(), &["serve", "--listen", &taken]).status.success());
    assert!(!run(folder.path(), &["serve", "--listen", "127.0.0.1:0", "--set", &transport]).status.success());
    let mut server = Server::start(folder.path(), &[]);
    assert!(server.line().contains("one-time password"));
}

/// A stranger's connections that send a login's body one byte at a time.
#[test]
fn one_address_cannot_keep_everybody_else_out() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &["--set", "http.max_connections=32"]);
    let host: std::net::SocketAddr = server.url.split("://").nth(1).unwrap().parse().unwrap();
    let from = |address: [u8; 4]| {
        let socket = socket2::Socket::new(socket2::Domain::IPV4, socket2::Type::STREAM, None).unwrap();
        socket.bind(&std::net::SocketAddr::from((address, 0)).into()).unwrap();
        socket.connect(&host.into()).unwrap();
        let mut stream = TcpStream::from(socket);
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        stream.write_all(b"POST /login HTTP/1.1\r\nhost: a\r\ncontent-length: 60000\r\n").ok();
        stream.write_all(b"content-type: application/x-www-form-urlencoded\r\n\r\nn").ok();
        stream
    };
    let mut held: Vec<TcpStream> = (0..64).map(|_| from([127, 0, 0, 1])).collect();
    let hung_up = |stream: &mut TcpStream| match stream.read(&mut [0; 100]) {
        Ok(read) => read == 0,
        Err(error) => error.kind() == std::io::ErrorKind::ConnectionReset,
    };
    assert!(hung_up(held.last_mut().unwrap()), "it has its share");
    let mut other = from([127, 0, 0, 2]);
    other.write_all(&vec![b'n'; 59_999]).unwrap();
    let mut status = [0; 12];
    other.read_exact(&mut status).unwrap();
    assert!(status.starts_with(b"HTTP/1.1 "), "{}", String::from_utf8_lossy(&status));
}

#[test]
fn garbage_is_refused_and_disturbs_nobody() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let host = server.url.split("://").nth(1).unwrap();
    let long = "x".repeat(200_000);
    let form = "POST /login HTTP/1.1\r\nhost: a\r\ncontent-type: application/x-www-form-urlencoded\r\n";
    let cases = [
        ("\0\u{1}\u{2} garbage \r\n\r\n".to_owned(), "400"),
        (format!("GET /{long} HTTP/1.1\r\nhost: a\r\n\r\n"), "414|431|400"),
        (format!("GET / HTTP/1.1\r\nhost: a\r\nx: {long}\r\n\r\n"), "431|400"),
        (format!("{form}content-length: 200000\r\n\r\n{long}"), "413"),
        (format!("{form}content-length: 5\r\n\r\n%%%=%"), "400|422"),
        ("GET /static/..%2f..%2fCargo.toml HTTP/1.1\r\nhost: a\r\n\r\n".to_owned(), "404"),
        ("GET /api/v1/vessels/99999/track?from_us=0&to_us=1 HTTP/1.1\r\nhost: a\r\n\r\n".to_owned(), "401"),
        ("GET / HTTP/1.1\r\nhost: a\r\ncookie: lutra_session=%00;;=;\r\n\r\n".to_owned(), "303"),
        ("GET /api/v1/me HTTP/1.1\r\nhost: a\r\nauthorization: Basic YTpi\r\n\r\n".to_owned(), "401"),
    ];
    for (request, statuses) in cases {
        let mut stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        // The server may answer and close the connection before it has read everything.
        stream.write_all(request.as_bytes()).ok();
        let mut status = [0; 12];
        stream.read_exact(&mut status).unwrap();
        let status = String::from_utf8_lossy(&status[9..]).into_owned();
        let start: String = request.chars().take(60).collect();
        assert!(statuses.contains(&status), "{status} for {start}");
    }
    // A head that is not much too large is refused in words.
    let mut stream = TcpStream::connect(host).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    let large = format!("GET / HTTP/1.1\r\nhost: a\r\nconnection: close\r\nx: {}\r\n\r\n", &long[..40_000]);
    stream.write_all(large.as_bytes()).unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert!(answer.starts_with("HTTP/1.1 431") && answer.contains("more than 32768 bytes"), "{answer}");
    assert!(server.get("/healthz").starts_with("HTTP/1.1 200"));
}

#[test]
fn it_serves_encrypted_with_a_certificate_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let made = printed(&run(folder.path(), &["tls", "init", "--name", "localhost"]));
    let config = folder.path().join("server.toml");
    std::fs::write(&config, made).unwrap();
    let server = Server::start(folder.path(), &["--config", config.to_str().unwrap()]);
    let port = server.url.strip_prefix("https://127.0.0.1:").unwrap();
    let mut roots = rustls::RootCertStore::empty();
    let authority = folder.path().join("tls/ca.pem");
    roots.add(rustls::pki_types::CertificateDer::from_pem_file(authority).unwrap()).unwrap();
    let provider = std::sync::Arc::new(rustls::crypto::ring::default_provider());
    let client =
        rustls::ClientConfig::builder_with_provider(provider).with_safe_default_protocol_versions().unwrap();
    let client = std::sync::Arc::new(client.with_root_certificates(roots).with_no_client_auth());
    let ask = |name: &str| {
        let name = rustls::pki_types::ServerName::try_from(name.to_owned()).unwrap();
        let session = rustls::ClientConnection::new(std::sync::Arc::clone(&client), name).unwrap();
        let socket = TcpStream::connect(format!("127.0.0.1:{port}")).unwrap();
        let mut stream = rustls::StreamOwned::new(session, socket);
        stream.write_all(b"GET /login HTTP/1.1\r\nhost: shore\r\nconnection: close\r\n\r\n")?;
        let mut answer = String::new();
        stream.read_to_string(&mut answer).map(|_| answer)
    };
    let answer = ask("localhost").unwrap();
    assert!(
        answer.contains("strict-transport-security") && answer.contains("__Host-lutra_login="),
        "{answer}"
    );
    assert!(answer.contains("; Secure"));
    assert!(ask("elsewhere").is_err(), "the certificate is for localhost only");
}

#[test]
fn the_doctor_names_what_is_not_well() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("app.db"),
        "this is not a database, but long enough to be taken for one",
    )
    .unwrap();
    let output = run(folder.path(), &["doctor", "--set", "http.listen=127.0.0.1:0"]);
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(!output.status.success() && told.contains("BAD   people: app.db"), "{told}");
    assert!(told.contains("ok    clock"));
}

#[test]
fn the_doctor_tells_monitoring_by_codes_and_gives_no_value_of_a_broken_configuration_away() {
    let folder = tempfile::tempdir().unwrap();
    let doctor = |more: &[&str]| {
        let output = run(folder.path(), &[&["doctor", "--json"], more].concat());
        let told: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        (output.status.code(), told)
    };
    let status = |told: &serde_json::Value, code: &str| {
        let checks = told["checks"].as_array().unwrap();
        let one =
            checks.iter().find(|one| one["code"] == code).unwrap_or_else(|| panic!("no {code}: {told}"));
        one["status"].as_str().unwrap().to_owned()
    };
    let (code, told) = doctor(&["--set", "http.listen=127.0.0.1:0"]);
    let expected = match told["status"].as_str() {
        Some("ok") => 0,
        Some("warn") => 1,
        other => panic!("{other:?}: {told}"),
    };
    assert_eq!(code, Some(expected));
    for known in ["configuration", "clock", "encryption", "people"] {
        assert_eq!(status(&told, known), "ok", "{told}");
    }
    let config = folder.path().join("server.toml");
    std::fs::write(&config, "[http]\npasswort = \"hush-hush\"\n").unwrap();
    let (code, told) = doctor(&["--config", config.to_str().unwrap()]);
    assert_eq!((code, status(&told, "configuration")), (Some(2), "fail".to_owned()));
    assert!(!told.to_string().contains("hush") && told.to_string().contains("line 2"), "{told}");
}

#[test]
fn people_are_managed_in_a_browser() {
    if !testkit::browser::is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut server = Server::start(folder.path(), &[]);
    let password = server.one_time_password();
    testkit::browser::run("admin.mjs", &[&server.url, &password], |_| {});
}

/// Runs a script against a server that holds the demonstration's chart.
fn before_the_chart(script: &str) {
    if !testkit::browser::is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let cells = folder.path().join("cells");
    std::fs::create_dir(&cells).unwrap();
    for cell in charts::demo::archipelago().unwrap() {
        std::fs::write(cells.join(cell.name), cell.bytes).unwrap();
    }
    let data = folder.path().join("data");
    let import =
        Command::new(PROGRAM).args(["chart", "import"]).arg(&cells).arg("--data").arg(&data).output();
    let import = import.unwrap();
    assert!(import.status.success(), "{}", String::from_utf8_lossy(&import.stderr));
    let mut server = Server::start(&data, &[]);
    let password = server.one_time_password();
    testkit::browser::run(script, &[&server.url, &password], |_| {});
}

#[test]
fn the_chart_is_drawn_in_a_browser_and_a_plan_over_a_shoal_refused_where_it_is() {
    before_the_chart("chart.mjs");
}

#[test]
fn whole_maneuvers_are_moved_turned_and_drawn_in_a_browser() {
    before_the_chart("maneuvers.mjs");
}

#[test]
fn plans_are_drawn_in_a_browser_and_outlive_a_killed_server() {
    if !testkit::browser::is_there() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let mut server = Server::start(folder.path(), &[]);
    let (password, url) = (server.one_time_password(), server.url.clone());
    let listen = url.split("://").nth(1).unwrap().to_owned();
    testkit::browser::run("plans.mjs", &[&url, &password], |line| match line {
        "kill the server" => {
            server.child.kill().unwrap();
            server.child.wait().unwrap();
        }
        "start the server" => server = Server::start_at(&listen, folder.path(), &[]),
        _ => {}
    });
}

/// The program as a user who may read the folder but not write it; root may write everything.
fn as_reader(data: &Path, arguments: &[&str]) -> Output {
    let mut command = if rustix::process::geteuid().is_root() {
        let mut command = Command::new("setpriv");
        command.args(["--reuid=65534", "--regid=65534", "--clear-groups", PROGRAM]);
        command
    } else {
        Command::new(PROGRAM)
    };
    command.args(arguments).arg("--data").arg(data).output().unwrap()
}

/// As in the API: `project` and `area`, and their errors.
#[test]
fn detections_of_projects_and_areas_are_exported() {
    let parent = tempfile::tempdir().unwrap();
    let data = parent.path().join("data");
    let mut store = store::Store::open(&data).unwrap();
    // South of the equator, so that corners begin with a minus.
    for (tag_id, lat_deg, after_s) in [(101, -33.0, 0), (102, -33.0, 1), (101, -34.0, 2)] {
        let seconds = 1_800_000_000 + after_s;
        let received = units::UtcTime::from_micros(i64::from(seconds) * 1_000_000);
        let header = imc::Header {
            timestamp: received.seconds(),
            src: imc::Address(0x2810),
            ..imc::Header::default()
        };
        let tag = imc::messages::TBRFishTag {
            serial_no: 1_024,
            unix_timestamp: seconds,
            trans_id: tag_id,
            lat: Some(f64::to_radians(lat_deg)),
            lon: Some(0.3),
            ..Default::default()
        };
        let packet = imc::Packet::new(header, tag).encode().unwrap();
        let accepted =
            store::Accepted { packet: &packet, received, transport: store::Transport::Tcp, link: None };
        store.accept(&accepted).unwrap();
    }
    store.close().unwrap();
    let rows = |more: &[&str]| {
        let output = run(&data, &[&["detections", "export"], more].concat());
        assert!(output.status.success(), "{more:?}: {}", String::from_utf8_lossy(&output.stderr));
        printed(&output).lines().count() - 1
    };
    let protocol = {
        let all = printed(&run(&data, &["detections", "export", "--format", "lutra"]));
        let mut lines = all.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let at = lines.next().unwrap().iter().position(|column| *column == "protocol").unwrap();
        lines.next().unwrap()[at].to_owned()
    };
    for (kind, table) in [
        ("project", "name\nSalmon\nTrout\nCod\n".to_owned()),
        (
            "tag",
            format!("name,protocol,tag_id,project\none,{protocol},101,Salmon\nother,{protocol},102,Trout\n"),
        ),
    ] {
        let file = parent.path().join(kind);
        std::fs::write(&file, table).unwrap();
        let output = run(&data, &["register", "import", kind, file.to_str().unwrap(), "--yes"]);
        assert!(output.status.success(), "{kind}: {}", String::from_utf8_lossy(&output.stderr));
    }
    let area = ["--area", "-33.5,17;-32.5,17;-32.5,18;-33.5,18"];
    assert_eq!(rows(&[]), 3);
    assert_eq!(rows(&["--project", "Salmon"]), 2);
    assert_eq!(rows(&["--project", "Salmon", "--project", "trout"]), 3);
    assert_eq!(rows(&["--project", "Cod"]), 0);
    assert_eq!(rows(&area), 2);
    assert_eq!(rows(&[&["--project", "Salmon"], &area[..]].concat()), 1);
    for (more, text) in [
        (["--project", "Perch"], "project: the register has no project `Perch`"),
        (["--project", ""], "project: a name is empty"),
        (["--project", "Salmon;Trout"], "project: the register has no project `Salmon;Trout`"),
        (["--area", " "], "area: it is empty"),
        (["--area", "1,2"], "area:"),
        (["--area", "63,10;64,11;64,10;63,11"], "area: the sides from corner 1"),
    ] {
        let output = run(&data, &[&["detections", "export"], &more[..]].concat());
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && told.contains(text), "{more:?}: {told}");
    }
}

#[test]
fn what_nobody_may_write_can_be_exported_from() {
    let parent = tempfile::tempdir().unwrap();
    let data = parent.path().join("data");
    let mut store = store::Store::open(&data).unwrap();
    let header = imc::Header { timestamp: 1.8e9, src: imc::Address(0x2810), ..imc::Header::default() };
    let mut packet = Vec::new();
    imc::encode_into(&mut packet, &header, &imc::messages::Temperature { value: 8.5 }).unwrap();
    let received = units::UtcTime::from_micros(1_800_000_000_500_000);
    let accepted =
        store::Accepted { packet: &packet, received, transport: store::Transport::Tcp, link: None };
    store.accept(&accepted).unwrap();
    store.close().unwrap();
    let chmod = |mode: &str, path: &Path| {
        assert!(Command::new("chmod").args(["-R", mode]).arg(path).status().unwrap().success());
    };
    chmod("a+rX,a-w", parent.path());
    let export = ["export", "--message", "Temperature"];
    let output = as_reader(&data, &export);
    assert!(printed(&output).lines().nth(1).unwrap().ends_with(",8.5"), "{output:?}");
    let slip = as_reader(&data, &["export", "--message", "Temprature"]);
    let told = String::from_utf8_lossy(&slip.stderr).into_owned();
    assert!(!slip.status.success() && told.contains("did you mean `Temperature`?"), "{told}");

    // Missing or unreadable parts are reported.
    let refused = |words: &str| {
        let output = as_reader(&data, &export);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && told.contains(words), "{words}: {told}");
    };
    let month = data.join("history/2027-01.sqlite");
    let log = data.join("history/2027-01.sqlite-wal");
    chmod("u+w", parent.path());
    std::fs::write(&log, "not yet written into it").unwrap();
    chmod("a-w", parent.path());
    refused("copy the data folder to where it can");
    chmod("u+w", parent.path());
    std::fs::remove_file(&log).unwrap();
    chmod("000", &month);
    chmod("a-w", parent.path());
    refused("let the user who runs this read it");
    chmod("u+w", parent.path());
    chmod("000", &data);
    refused("let the user who runs this read the folder");
    chmod("u+rwX", parent.path());
}
