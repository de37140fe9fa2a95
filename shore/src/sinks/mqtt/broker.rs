//! A broker for tests that answers each message as the test says, and writes down what it took.

use std::net::SocketAddr;
use std::sync::{Arc, Mutex};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _, BufReader};
use tokio::net::{TcpListener, TcpStream};

/// MQTT 5, 2.4: the reason codes *success*, *not authorized* and *packet too large*.
const SUCCESS: u8 = 0x00;
const NOT_AUTHORIZED: u8 = 0x87;
pub(super) const PACKET_TOO_LARGE: u8 = 0x95;

/// How a message is answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Answer {
    Take,
    Deny,
    /// By a DISCONNECT with this reason.
    Disconnect(u8),
    /// By nothing: the connection ends.
    Cut,
}

/// A message that was taken.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Taken {
    pub(super) topic: String,
    pub(super) payload: String,
    pub(super) retain: bool,
}

type Rule = Box<dyn FnMut(&str, &str) -> Answer + Send>;

struct State {
    rule: Rule,
    taken: Vec<Taken>,
    connections: usize,
}

pub(super) struct Broker {
    pub(super) address: SocketAddr,
    state: Arc<Mutex<State>>,
}

impl Broker {
    /// One that answers by topic and payload.
    pub(super) async fn start(rule: impl FnMut(&str, &str) -> Answer + Send + 'static) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let state = State { rule: Box::new(rule), taken: Vec::new(), connections: 0 };
        let state = Arc::new(Mutex::new(state));
        let its = Arc::clone(&state);
        tokio::spawn(async move {
            while let Ok((tcp, _)) = listener.accept().await {
                its.lock().unwrap().connections += 1;
                tokio::spawn(serve(tcp, Arc::clone(&its)));
            }
        });
        Self { address, state }
    }

    /// Answers otherwise from now on.
    pub(super) fn answers(&self, rule: impl FnMut(&str, &str) -> Answer + Send + 'static) {
        self.state.lock().unwrap().rule = Box::new(rule);
    }

    /// What it took since the last call.
    pub(super) fn taken(&self) -> Vec<Taken> {
        std::mem::take(&mut self.state.lock().unwrap().taken)
    }

    pub(super) fn connections(&self) -> usize {
        self.state.lock().unwrap().connections
    }
}

/// Answers until the other end goes, or an answer ends the connection.
async fn serve(tcp: TcpStream, state: Arc<Mutex<State>>) {
    let mut tcp = BufReader::new(tcp);
    while let Some((kind, body)) = packet(&mut tcp).await {
        let (answer, ends) = answer(kind, &body, &state);
        tcp.write_all(&answer).await.ok();
        if ends {
            tcp.shutdown().await.ok();
            // What was sent meanwhile is read, so that the answers before this one are not lost by a reset.
            while packet(&mut tcp).await.is_some() {}
            return;
        }
    }
}

async fn packet(tcp: &mut BufReader<TcpStream>) -> Option<(u8, Vec<u8>)> {
    let kind = tcp.read_u8().await.ok()?;
    let (mut length, mut shift) = (0, 0);
    loop {
        let byte = tcp.read_u8().await.ok()?;
        length |= usize::from(byte & 0x7F) << shift;
        shift += 7;
        if byte & 0x80 == 0 {
            break;
        }
    }
    let mut body = vec![0; length];
    tcp.read_exact(&mut body).await.ok()?;
    Some((kind, body))
}

/// The bytes to answer by, and whether the connection ends with them.
fn answer(kind: u8, body: &[u8], state: &Mutex<State>) -> (Vec<u8>, bool) {
    match kind & 0xF0 {
        0x10 => (vec![0x20, 3, 0, SUCCESS, 0], false),
        0x30 => published(kind, body, &mut state.lock().unwrap()),
        0x80 => (vec![0x90, 4, body[0], body[1], 0, SUCCESS], false),
        0xA0 => (vec![0xB0, 4, body[0], body[1], 0, SUCCESS], false),
        0xC0 => (vec![0xD0, 0], false),
        _ => (Vec::new(), false),
    }
}

fn published(kind: u8, body: &[u8], state: &mut State) -> (Vec<u8>, bool) {
    let (topic, rest) = body[2..].split_at(usize::from(u16::from_be_bytes([body[0], body[1]])));
    let (number, rest) = rest.split_at(2);
    // Without properties.
    assert_eq!(rest[0], 0);
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    let (topic, payload) = (text(topic), text(&rest[1..]));
    let answered = |reason| (vec![0x40, 3, number[0], number[1], reason], false);
    match (state.rule)(&topic, &payload) {
        Answer::Take => {
            state.taken.push(Taken { topic, payload, retain: kind & 1 == 1 });
            answered(SUCCESS)
        }
        Answer::Deny => answered(NOT_AUTHORIZED),
        Answer::Disconnect(reason) => (vec![0xE0, 2, reason, 0], true),
        Answer::Cut => (Vec::new(), true),
    }
}
