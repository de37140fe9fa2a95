//! A slow and lossy connection to a server, as TCP over a bad mobile network: everything arrives, in order, late and in
//! bursts.

use std::net::SocketAddr;
use std::time::Duration;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::net::{TcpSocket, TcpStream};
use tokio::sync::{mpsc, watch};
use tokio::time::{Instant, sleep_until};

/// One-way delay; the round trip is 300 ms.
const DELAY: Duration = Duration::from_millis(150);
/// A lost segment is sent again after this time, then after twice as long, and so on; later ones wait.
const AGAIN: Duration = Duration::from_millis(500);
/// One in so many segments is lost.
const LOST_OF: u64 = 10;
const SEGMENT: usize = 1_448;
/// Segments on the way at once.
const WINDOW: usize = 16;
/// Small, so that buffers do not hide the slow connection.
const BUFFER: u32 = 16 * 1024;

/// The relay; it lasts as long as the program.
pub(crate) struct SlowLine {
    pub(crate) address: SocketAddr,
    cut: watch::Sender<bool>,
}

impl SlowLine {
    pub(crate) fn to(server: SocketAddr) -> Self {
        let socket = TcpSocket::new_v4().unwrap();
        socket.set_recv_buffer_size(BUFFER).unwrap();
        socket.bind("127.0.0.1:0".parse().unwrap()).unwrap();
        let listener = socket.listen(64).unwrap();
        let address = listener.local_addr().unwrap();
        let (cut, watching) = watch::channel(false);
        tokio::spawn(async move {
            let mut seed = 1;
            while let Ok((stream, _)) = listener.accept().await {
                seed += 2;
                if !*watching.borrow() {
                    tokio::spawn(connect(stream, server, seed, watching.clone()));
                }
            }
        });
        Self { address, cut }
    }

    /// Closes all connections and accepts no others, or accepts them again.
    pub(crate) fn cut(&self, is: bool) {
        self.cut.send_replace(is);
    }
}

async fn connect(browser: TcpStream, server: SocketAddr, seed: u64, mut cut: watch::Receiver<bool>) {
    let socket = TcpSocket::new_v4().unwrap();
    socket.set_recv_buffer_size(BUFFER).unwrap();
    let Ok(shore) = socket.connect(server).await else { return };
    browser.set_nodelay(true).unwrap();
    shore.set_nodelay(true).unwrap();
    let ((from_browser, to_browser), (from_shore, to_shore)) = (browser.into_split(), shore.into_split());
    tokio::select! {
        () = carry(from_browser, to_shore, seed) => {}
        () = carry(from_shore, to_browser, seed + 1_000_000) => {}
        _ = cut.wait_for(|cut| *cut) => {}
    }
}

async fn carry(mut from: OwnedReadHalf, mut to: OwnedWriteHalf, seed: u64) {
    let (send, mut on_the_way) = mpsc::channel::<(Instant, Vec<u8>)>(WINDOW);
    let reading = async move {
        let mut buffer = vec![0; SEGMENT];
        while let Ok(length @ 1..) = from.read(&mut buffer).await {
            if send.send((Instant::now() + DELAY, buffer[..length].to_vec())).await.is_err() {
                return;
            }
        }
    };
    let writing = async move {
        let mut chance = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        while let Some((mut due, segment)) = on_the_way.recv().await {
            let mut again = AGAIN;
            while lost(&mut chance) {
                due = due.max(Instant::now()) + again;
                again *= 2;
            }
            sleep_until(due).await;
            if to.write_all(&segment).await.is_err() {
                return;
            }
        }
    };
    tokio::join!(reading, writing);
}

/// Xorshift (Marsaglia 2003): the same losses in each run.
fn lost(chance: &mut u64) -> bool {
    *chance ^= *chance << 13;
    *chance ^= *chance >> 7;
    *chance ^= *chance << 17;
    chance.is_multiple_of(LOST_OF)
}
