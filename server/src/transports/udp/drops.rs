//! Datagrams that the kernel dropped because its buffer for the socket was full, as `/proc/net/udp` counts them.

use std::fs;
use std::net::UdpSocket;
use std::os::fd::AsRawFd as _;
use std::os::unix::fs::MetadataExt as _;

/// A socket in the kernel's table.
#[derive(Debug, Clone, Copy)]
pub(super) struct Counted {
    inode: u64,
}

impl Counted {
    /// `None` where there is no `/proc`.
    pub(super) fn of(socket: &UdpSocket) -> Option<Self> {
        let file = fs::metadata(format!("/proc/self/fd/{}", socket.as_raw_fd())).ok()?;
        Some(Self { inode: file.ino() })
    }

    /// Datagrams dropped since the socket was opened.
    pub(super) fn drops(self) -> Option<u64> {
        drops(&fs::read_to_string("/proc/self/net/udp").ok()?, self.inode)
    }
}

/// The last column of the socket's row; the inode is the tenth.
fn drops(table: &str, inode: u64) -> Option<u64> {
    let inode = inode.to_string();
    let row = table.lines().skip(1).find(|row| row.split_whitespace().nth(9) == Some(&inode))?;
    row.split_whitespace().nth(12)?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_full_buffer_drops_is_counted() {
        let receiver = UdpSocket::bind("127.0.0.1:0").unwrap();
        let counted = Counted::of(&receiver).unwrap();
        assert_eq!(counted.drops(), Some(0));
        socket2::SockRef::from(&receiver).set_recv_buffer_size(4_096).unwrap();
        let sender = UdpSocket::bind("127.0.0.1:0").unwrap();
        for _ in 0..200 {
            sender.send_to(&[0; 1_000], receiver.local_addr().unwrap()).unwrap();
        }
        receiver.set_nonblocking(true).unwrap();
        let received = std::iter::from_fn(|| receiver.recv(&mut [0; 1_000]).ok()).count() as u64;
        assert_eq!(counted.drops(), Some(200 - received));
        assert_eq!(drops("sl local\n", 7), None);
    }
}
