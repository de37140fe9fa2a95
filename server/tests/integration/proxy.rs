//! Behind nginx as configured by `deploy/proxy/nginx.conf`: pages, sockets, large uploads, and the trusted client address.

use crate::support::ashore::archived_bytes;
use crate::support::program::{
    Agent, Process, SERVER, Server, add_admin, agent_program, link_token, run, script_token, until,
};
use crate::support::trusting::Trusting;
use std::io::{Read as _, Write as _};
use std::net::{Ipv4Addr, SocketAddr, TcpListener};
use std::path::Path;
use std::process::{Command, Stdio};

const NAME: &str = "boats.example.no";

/// The example of the repository, with ports and certificate of this test.
fn configuration(folder: &Path, ports: [u16; 2], server: SocketAddr) -> String {
    let example = testkit::repository().join("deploy/proxy/nginx.conf");
    let mut text = std::fs::read_to_string(example).unwrap();
    let tls = folder.join("data/tls");
    for (usual, here) in [
        ("listen 80;", format!("listen 127.0.0.1:{};", ports[0])),
        ("listen 443 ssl", format!("listen 127.0.0.1:{} ssl", ports[1])),
        ("/etc/letsencrypt/live/boats.example.no/fullchain.pem", format!("{}/server.pem", tls.display())),
        ("/etc/letsencrypt/live/boats.example.no/privkey.pem", format!("{}/server-key.pem", tls.display())),
        ("http://127.0.0.1:8080", format!("http://{server}")),
    ] {
        assert!(text.contains(usual), "the example has no {usual:?}");
        text = text.replace(usual, &here);
    }
    let at = |name: &str| folder.join(name).display().to_string();
    let temporary: String = ["client_body", "proxy", "fastcgi", "uwsgi", "scgi"]
        .map(|what| format!("{what}_temp_path {};\n", at(&format!("nginx-{what}"))))
        .concat();
    // Its workers must reach the folder of the test.
    let user = if is_root() { "user root;\n" } else { "" };
    format!(
        "daemon off;\n{user}worker_processes 1;\npid {};\nerror_log stderr;\nevents {{}}\nhttp {{\naccess_log off;\n{temporary}{text}}}\n",
        at("nginx.pid")
    )
}

fn is_root() -> bool {
    let id = Command::new("id").arg("-u").output().unwrap();
    id.stdout.trim_ascii() == b"0"
}

fn nginx(folder: &Path, server: SocketAddr) -> Option<(Process, [SocketAddr; 2])> {
    let free = || TcpListener::bind("127.0.0.1:0").unwrap();
    let (plain, encrypted) = (free(), free());
    let addresses = [plain.local_addr().unwrap(), encrypted.local_addr().unwrap()];
    let file = folder.join("nginx.conf");
    std::fs::write(&file, configuration(folder, addresses.map(|one| one.port()), server)).unwrap();
    drop((plain, encrypted));
    let errors = std::fs::File::create(folder.join("nginx.log")).unwrap();
    let spawned = Command::new("nginx")
        .arg("-c")
        .arg(&file)
        .arg("-p")
        .arg(folder)
        .stdout(Stdio::null())
        .stderr(errors)
        .spawn();
    let Ok(child) = spawned else {
        testkit::absent(testkit::Need::Nginx, "apt-get install nginx-light");
        return None;
    };
    Some((Process(child), addresses))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn behind_nginx_pages_sockets_and_uploads_work_and_the_last_address_counts() {
    let Some(program) = agent_program() else { return };
    let scratch = tempfile::tempdir().unwrap();
    let (data, aboard) = (scratch.path().join("data"), scratch.path().join("aboard"));
    std::fs::create_dir(&aboard).unwrap();
    add_admin(&data, "nils", "seven small boats");
    let token = link_token(&data, "otter-1", "0x2810");
    let script = script_token(&data);
    run(&data, &["tls", "init", "--name", NAME, "--name", "127.0.0.1"]);
    let origin = format!("http.origins=https://{NAME}");
    let settings = ["--set", "http.trusted_proxies=127.0.0.1", "--set", &origin];
    let mut server = Server::start_by(Command::new(SERVER), &data, "127.0.0.1:0", &settings);
    let Some((_nginx, [plain, encrypted])) = nginx(scratch.path(), server.web) else { return };
    let told = || std::fs::read_to_string(scratch.path().join("nginx.log")).unwrap();
    let ours = Trusting::new(&data.join("tls/ca.pem")).at(Ipv4Addr::new(127, 0, 0, 2));
    let ask = |head: &str, body: &[u8]| {
        ours.ask(encrypted, NAME, head, body).unwrap_or_else(|error| panic!("{error}: {}", told()))
    };
    until("nginx listens", || std::net::TcpStream::connect(encrypted).ok()).await;

    // Unencrypted requests are redirected to https.
    let mut stream = std::net::TcpStream::connect(plain).unwrap();
    write!(stream, "GET /fleet HTTP/1.0\r\nhost: {NAME}\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert!(
        answer.contains(" 301 ") && answer.contains("Location: https://boats.example.no/fleet"),
        "{answer}"
    );
    // The server knows that the browser's connection is encrypted.
    let (head, _) = ask("GET /login HTTP/1.1\r\n", b"");
    assert!(
        head.contains(" 200 ") && head.contains("__Host-lutra_login=") && head.contains("Secure"),
        "{head}"
    );

    // A log of several MiB, above nginx's default limit; and a forged client address precedes the one that nginx saw, which
    // counts.
    let bearer = format!("authorization: Bearer {script}\r\n");
    let log = large_log();
    let head = format!(
        "POST /api/v1/import?name=large.lsf HTTP/1.1\r\n{bearer}x-forwarded-for: 198.51.100.9\r\ncontent-length: {}\r\n",
        log.len()
    );
    let (head, answer) = ask(&head, &log);
    assert!(head.contains(" 200 "), "{head}\n{answer}");
    let (_, audit) = ask(&format!("GET /api/v1/audit HTTP/1.1\r\n{bearer}"), b"");
    let imported = audit.split('{').find(|entry| entry.contains("log.import"));
    assert!(imported.is_some_and(|entry| entry.contains("\"127.0.0.2\"")), "{audit}");

    // A live page's socket, and a vessel's link.
    let head = format!(
        "GET /api/live HTTP/1.1\r\n{bearer}host: {NAME}\r\norigin: https://{NAME}\r\nconnection: Upgrade\r\nupgrade: websocket\r\n\
         sec-websocket-version: 13\r\nsec-websocket-key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    );
    let mut socket = ours.connect(encrypted, NAME).unwrap();
    socket.write_all(head.as_bytes()).unwrap();
    let mut answer = [0; 12];
    socket.read_exact(&mut answer).unwrap();
    assert_eq!(String::from_utf8_lossy(&answer), "HTTP/1.1 101");
    let before = archived_bytes(&data);
    let _agent = Agent::start_encrypted(&program, &aboard, encrypted, &token, &data.join("tls/ca.pem"));
    until("ashore through nginx", || (archived_bytes(&data) > before).then_some(())).await;
    server.process.terminate();
}

/// By HTTP/2 a browser puts all requests on one connection. While that one is dead STOP goes by the live socket, which nginx
/// leaves on a connection of its own.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn stop_gets_through_in_a_browser_whose_connection_to_nginx_hangs() {
    let Some(program) = agent_program() else { return };
    if !testkit::browser::is_there() {
        return;
    }
    let scratch = tempfile::tempdir().unwrap();
    let (data, aboard) = (scratch.path().join("data"), scratch.path().join("aboard"));
    std::fs::create_dir(&aboard).unwrap();
    add_admin(&data, "nils", "seven small boats");
    let token = link_token(&data, "otter-1", "0x2810");
    let script = script_token(&data);
    run(&data, &["tls", "init", "--name", NAME, "--name", "127.0.0.1"]);
    // The browser's way to nginx has a port of its own, which its origin names.
    let way = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let origin = format!("http.origins=https://127.0.0.1:{way}");
    let settings = ["--set", "http.trusted_proxies=127.0.0.1", "--set", &origin];
    let mut server = Server::start_by(Command::new(SERVER), &data, "127.0.0.1:0", &settings);
    let Some((_nginx, [_, encrypted])) = nginx(scratch.path(), server.web) else { return };
    until("nginx listens", || std::net::TcpStream::connect(encrypted).ok()).await;
    let _agent = Agent::start_encrypted(&program, &aboard, encrypted, &token, &data.join("tls/ca.pem"));
    let (url, way) = (format!("https://127.0.0.1:{}", encrypted.port()), way.to_string());
    testkit::browser::run("held.mjs", &[&url, &way, &script, "seven small boats", "h2"], |_| {});
    server.process.terminate();
}

/// Six MiB of packets, all of them different.
fn large_log() -> Vec<u8> {
    let mut log = Vec::new();
    let mut number = 0;
    while log.len() < 6 << 20 {
        number += 1;
        let header = imc::Header {
            timestamp: 1.795e9 + f64::from(number) / 1e3,
            src: imc::Address(0x2811),
            src_ent: 5,
            ..imc::Header::default()
        };
        imc::encode_into(&mut log, &header, &imc::messages::Temperature { value: number as f32 }).unwrap();
    }
    log
}
