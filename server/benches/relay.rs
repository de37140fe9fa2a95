//! How fast the IMCProxy transport relays between real sockets, and how late: `cargo bench -p server --bench relay`.
//!
//! Clients and server share the machine. The clients do as little as can be (frames are counted, not decoded), so
//! that what is measured is the server. Set SECONDS to measure longer than 3 s each.

#![expect(clippy::unwrap_used, reason = "a benchmark ends where it unwraps nothing")]

mod support;

use imc::messages::EstimatedState;
use imc::{Address, Header};
use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};
use support::{config, connect};

/// Packets written at once by a sender that goes as fast as it can.
const BURST: usize = 64;

/// A frame of a boat's state at a time.
fn frame(out: &mut Vec<u8>, timestamp: f64, state: &EstimatedState) {
    let header = Header { timestamp, src: Address(0x2810), src_ent: 42, ..Header::default() };
    support::frame(out, &header, state);
}

/// Reads frames and passes on each packet's bytes.
fn read_frames(stream: &mut TcpStream, mut each: impl FnMut(&[u8])) {
    let (mut buffer, mut filled) = (vec![0; 256 * 1024], 0);
    loop {
        let Ok(read @ 1..) = stream.read(&mut buffer[filled..]) else { return };
        filled += read;
        let mut at = 0;
        while filled - at >= 2 {
            let length = usize::from(buffer[at + 1] & 0x7F);
            if filled - at < 2 + length {
                break;
            }
            each(&buffer[at + 2..at + 2 + length]);
            at += 2 + length;
        }
        buffer.copy_within(at..filled, 0);
        filled -= at;
    }
}

fn main() {
    let span = std::env::var("SECONDS").ok().and_then(|text| text.parse().ok()).unwrap_or(3);
    let span = Duration::from_secs(span);
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build().unwrap();
    let data = tempfile::tempdir().unwrap();
    let serving = runtime.block_on(server::serve(config(data.path()))).unwrap();
    let at = serving.transports.imcproxy.unwrap();
    for receivers in [1, 20] {
        let rate = throughput(at, receivers, span);
        println!(
            "relay, one to {receivers}: {rate:.0} deliveries/s (EstimatedState, 110 bytes, archive and history on)"
        );
    }
    let quiet = latency(at, span);
    println!("relay at 10 000 msg/s: {quiet}");
    let deaf = connect(at);
    let disturbed = latency(at, span);
    println!("the same beside a client that does not read: {disturbed}");
    drop(deaf);
    runtime.block_on(serving.stop());
}

/// Deliveries per second when one sends as fast as it can.
fn throughput(at: SocketAddr, receivers: usize, span: Duration) -> f64 {
    let count = Arc::new(AtomicU64::new(0));
    let clients: Vec<TcpStream> = (0..receivers).map(|_| connect(at)).collect();
    let readers: Vec<_> = clients
        .iter()
        .map(|client| {
            let (mut stream, count) = (client.try_clone().unwrap(), Arc::clone(&count));
            thread::spawn(move || {
                let mut local = 0;
                read_frames(&mut stream, |_| {
                    local += 1;
                    if local % 256 == 0 {
                        count.fetch_add(256, Ordering::Relaxed);
                    }
                });
            })
        })
        .collect();
    let mut sender = connect(at);
    let stop = Arc::new(AtomicBool::new(false));
    let writer = {
        let stop = Arc::clone(&stop);
        thread::spawn(move || {
            let (state, mut burst, mut n) = (EstimatedState::default(), Vec::new(), 0_u32);
            while !stop.load(Ordering::Relaxed) {
                burst.clear();
                for _ in 0..BURST {
                    n += 1;
                    frame(&mut burst, 1.6e9 + f64::from(n) * 1e-3, &state);
                }
                if sender.write_all(&burst).is_err() {
                    return;
                }
            }
        })
    };
    thread::sleep(Duration::from_millis(500));
    let (start, before) = (Instant::now(), count.load(Ordering::Relaxed));
    thread::sleep(span);
    let rate = (count.load(Ordering::Relaxed) - before) as f64 / start.elapsed().as_secs_f64();
    stop.store(true, Ordering::Relaxed);
    for client in &clients {
        client.shutdown(std::net::Shutdown::Both).ok();
    }
    writer.join().unwrap();
    for reader in readers {
        reader.join().unwrap();
    }
    rate
}

/// How late packets are at 10 000 a second.
fn latency(at: SocketAddr, span: Duration) -> String {
    let origin = Instant::now();
    let client = connect(at);
    let mut stream = client.try_clone().unwrap();
    let reader = thread::spawn(move || {
        let mut late_us = Vec::new();
        read_frames(&mut stream, |packet| {
            let sent = imc::PacketView::unchecked(packet).unwrap().timestamp();
            late_us.push(((origin.elapsed().as_secs_f64() - sent) * 1e6) as u32);
        });
        late_us
    });
    let mut sender = connect(at);
    let (state, mut burst) = (EstimatedState::default(), Vec::new());
    while origin.elapsed() < span {
        burst.clear();
        // Each packet has its own time, or it would be a duplicate of the previous one.
        for n in 0..10 {
            frame(&mut burst, origin.elapsed().as_secs_f64() + f64::from(n) * 1e-9, &state);
        }
        sender.write_all(&burst).unwrap();
        thread::sleep(Duration::from_millis(1));
    }
    thread::sleep(Duration::from_millis(200));
    client.shutdown(std::net::Shutdown::Both).ok();
    let mut late_us = reader.join().unwrap();
    late_us.sort_unstable();
    let share = |share: f64| f64::from(late_us[((late_us.len() - 1) as f64 * share) as usize]) / 1e3;
    let (p50, p99, most) = (share(0.5), share(0.99), share(1.0));
    let rate = late_us.len() as f64 / span.as_secs_f64();
    format!("p50 {p50:.2} ms, p99 {p99:.2} ms, most {most:.1} ms ({rate:.0} msg/s came)")
}
