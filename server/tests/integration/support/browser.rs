//! A minimal browser with cookies, and requests without authentication.

use serde_json::Value;
use std::collections::BTreeMap;
use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};

/// A minimal browser with cookies.
pub(crate) struct Browser {
    host: String,
    cookies: BTreeMap<String, String>,
}

impl Browser {
    /// Head and body of the answer.
    pub(crate) fn ask(&mut self, request: &str, more: &str, body: &str) -> (String, String) {
        let cookies: Vec<String> =
            self.cookies.iter().map(|(name, value)| format!("{name}={value}")).collect();
        let (host, length) = (&self.host, body.len());
        let mut stream = TcpStream::connect(host).unwrap();
        // The older version has whole bodies only.
        let head = format!(
            "{request} HTTP/1.0\r\nhost: {host}\r\norigin: http://{host}\r\ncookie: {}\r\n",
            cookies.join("; ")
        );
        write!(stream, "{head}{more}content-length: {length}\r\n\r\n{body}").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap();
        for cookie in head.lines().filter_map(|line| line.strip_prefix("set-cookie: ")) {
            let (name, value) = cookie.split(';').next().unwrap().split_once('=').unwrap();
            self.cookies.insert(name.to_owned(), value.to_owned());
        }
        (head.to_owned(), body.to_owned())
    }

    pub(crate) fn get(&mut self, path: &str) -> String {
        let (head, body) = self.ask(&format!("GET {path}"), "", "");
        assert!(head.contains(" 200 "), "{path}: {head}\n{body}");
        body
    }

    pub(crate) fn log_in(host: &str, name: &str, password: &str) -> Self {
        let mut browser = Self { host: host.to_owned(), cookies: BTreeMap::new() };
        let page = browser.get("/login");
        let token = page.split_once("name=\"csrf\" value=\"").unwrap().1.split('"').next().unwrap();
        let form = "content-type: application/x-www-form-urlencoded\r\n";
        let body = format!("name={name}&password={password}&csrf={token}&next=");
        let (head, _) = browser.ask("POST /login", form, &body);
        assert!(head.contains(" 303 ") && head.contains("location: /\r\n"), "{head}");
        browser
    }
}

/// Status and body of the answer to a request without authentication.
pub(crate) fn ask(server: SocketAddr, path: &str) -> (u16, String) {
    let mut stream = TcpStream::connect(server).unwrap();
    write!(stream, "GET {path} HTTP/1.0\r\nhost: {server}\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    (head.split(' ').nth(1).unwrap().parse().unwrap(), body.to_owned())
}

/// The answer to a request of a script, which is accepted.
pub(crate) fn post(server: SocketAddr, path: &str, token: &str, body: &Value) -> Value {
    let (mut stream, body) = (TcpStream::connect(server).unwrap(), body.to_string());
    write!(
        stream,
        "POST /api/v1{path} HTTP/1.0\r\nhost: {server}\r\nauthorization: Bearer {token}\r\n\
         content-type: application/json\r\ncontent-length: {}\r\n\r\n{body}",
        body.len()
    )
    .unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    assert!(head.starts_with("HTTP/1.0 20"), "{path}: {head}\n{body}");
    serde_json::from_str(body).unwrap()
}
