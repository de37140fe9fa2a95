//! One open port of any kind: bytes in, bytes out, without blocking.

use super::bus_lock::BusLock;
use super::open_error::OpenError;
use super::place::Place;
use super::serial::Serial;
use rustix::net::sockopt;
use socketcan::{CanSocket, Socket as _};
use std::fs::File;
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::net::{TcpStream, ToSocketAddrs as _, UdpSocket};
use std::os::fd::{AsFd, BorrowedFd};
use std::time::{Duration, Instant};

/// Time limit for connecting.
const CONNECT: Duration = Duration::from_secs(2);
/// TCP keepalive of a silent connection: idle time, interval and number of probes. A device that lost its power, or an
/// unplugged cable, does not close the connection.
const ASK_AFTER: Duration = Duration::from_secs(5);
const ASK_EVERY: Duration = Duration::from_secs(2);
const ASKED: u32 = 3;
/// Bytes that are not acknowledged for this long end a connection (ms).
const UNACKNOWLEDGED_MS: u32 = 10_000;
/// Bits on a line for one byte: start, eight data, stop.
const BITS_PER_BYTE: f64 = 10.0;

/// Result of a read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Got {
    /// So many bytes.
    Bytes(usize),
    /// Nothing yet.
    Nothing,
    /// The other end is gone.
    Ended,
}

/// An open port.
#[derive(Debug)]
pub(crate) enum Port {
    /// A serial port.
    Serial(Serial),
    /// A stream.
    Tcp(TcpStream),
    /// Datagrams.
    Udp(UdpSocket),
    /// A recording.
    Recording(Recording),
    /// A raw socket of a CAN interface, whose bytes are the kernel's frames of 16, locked against other programs of Lutra.
    Can(CanSocket, #[expect(dead_code, reason = "it is held, not asked")] BusLock),
    /// Scripted by a test.
    #[cfg(test)]
    Scripted(std::sync::Arc<std::sync::Mutex<Script>>),
}

/// A port that takes as many bytes as a test lets it.
#[cfg(test)]
#[derive(Debug, Default)]
pub(super) struct Script {
    pub(super) takes: usize,
    pub(super) taken: Vec<u8>,
    /// How often it was offered bytes.
    pub(super) offers: usize,
}

#[cfg(test)]
impl Script {
    fn write(&mut self, bytes: &[u8]) -> usize {
        let count = bytes.len().min(self.takes);
        self.takes -= count;
        self.offers += 1;
        self.taken.extend(&bytes[..count]);
        count
    }
}

/// A recording, played at a line's speed.
#[derive(Debug)]
pub(crate) struct Recording {
    file: File,
    begun: Instant,
    bytes_per_s: f64,
    /// Bytes given so far.
    given: u64,
}

impl Port {
    /// Opens a port.
    ///
    /// # Errors
    /// When it cannot be opened: the text names the place and the remedy.
    pub(crate) fn open(place: &Place) -> Result<Self, OpenError> {
        let because = |error: io::Error, remedy: &str| OpenError(format!("{place}: {error}; {remedy}"));
        match place {
            Place::Serial { path, baud } => Serial::open(path, *baud).map(Self::Serial),
            Place::Tcp(host) => {
                let stream = connect(host)
                    .map_err(|error| because(error, "is the device's server on, and reached from here?"))?;
                Ok(Self::Tcp(stream))
            }
            Place::Udp(address) => {
                let socket = UdpSocket::bind(address)
                    .and_then(|socket| socket.set_nonblocking(true).map(|()| socket))
                    .map_err(|error| {
                        because(error, "another program may use that port (`ss -ulnp` shows it)")
                    })?;
                Ok(Self::Udp(socket))
            }
            Place::Recording { path, baud } => {
                let file =
                    File::open(path).map_err(|error| because(error, "give the path of a recording"))?;
                let bytes_per_s = f64::from(*baud) / BITS_PER_BYTE;
                Ok(Self::Recording(Recording { file, begun: Instant::now(), bytes_per_s, given: 0 }))
            }
            Place::Can(interface) => {
                let remedy = format!(
                    "`ip link show {interface}` shows whether it is there; `sudo ip link set {interface} up type can bitrate 500000` \
                     brings it up; an adapter on a serial port is written as slcan:/dev/..."
                );
                let lock = BusLock::take(interface)?;
                let socket = CanSocket::open(interface)
                    .and_then(|socket| socket.set_nonblocking(true).map(|()| socket))
                    .map_err(|error| because(error, &remedy))?;
                Ok(Self::Can(socket, lock))
            }
        }
    }

    /// Reads what is there; never waits.
    ///
    /// # Errors
    /// When the port is lost.
    pub(crate) fn read(&mut self, buffer: &mut [u8]) -> io::Result<Got> {
        let read = match self {
            Self::Serial(serial) => rustix::io::read(serial.as_fd(), buffer).map_err(io::Error::from),
            Self::Can(fd, _) => rustix::io::read(fd.as_fd(), buffer).map_err(io::Error::from),
            Self::Tcp(stream) => stream.read(buffer),
            // An empty datagram is not the end.
            Self::Udp(socket) => match socket.recv(buffer) {
                Ok(0) => return Ok(Got::Nothing),
                read => read,
            },
            Self::Recording(recording) => return recording.read(buffer),
            #[cfg(test)]
            Self::Scripted(_) => return Ok(Got::Nothing),
        };
        match read {
            Ok(0) => Ok(Got::Ended),
            Ok(count) => Ok(Got::Bytes(count)),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {
                Ok(Got::Nothing)
            }
            Err(error) => Err(error),
        }
    }

    /// Writes as much as the port accepts at once; never waits. Ports without a writable other end discard everything.
    ///
    /// # Errors
    /// When the port is lost.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = match self {
            Self::Serial(serial) => rustix::io::write(serial.as_fd(), bytes).map_err(io::Error::from),
            Self::Can(fd, _) => write_frames(fd, bytes),
            Self::Tcp(stream) => stream.write(bytes),
            Self::Udp(_) | Self::Recording(_) => Ok(bytes.len()),
            #[cfg(test)]
            Self::Scripted(script) => {
                Ok(script.lock().unwrap_or_else(std::sync::PoisonError::into_inner).write(bytes))
            }
        };
        match written {
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => Ok(0),
            other => other,
        }
    }

    /// Changes the line's speed (bit/s), if it is a serial line.
    ///
    /// # Errors
    /// When the port is lost, or has no such speed.
    pub(super) fn set_speed(&self, baud: u32) -> io::Result<()> {
        match self {
            Self::Serial(serial) => serial.set_speed(baud).map_err(io::Error::from),
            Self::Can(..) | Self::Tcp(_) | Self::Udp(_) | Self::Recording(_) => Ok(()),
            #[cfg(test)]
            Self::Scripted(_) => Ok(()),
        }
    }

    /// The file descriptor to poll; `None` if there is none.
    pub(super) fn waits_at(&self) -> Option<BorrowedFd<'_>> {
        match self {
            Self::Serial(serial) => Some(serial.as_fd()),
            Self::Can(fd, _) => Some(fd.as_fd()),
            Self::Tcp(stream) => Some(stream.as_fd()),
            Self::Udp(socket) => Some(socket.as_fd()),
            Self::Recording(_) => None,
            #[cfg(test)]
            Self::Scripted(_) => None,
        }
    }
}

/// The kernel takes whole frames, one at a time.
fn write_frames(fd: &CanSocket, bytes: &[u8]) -> io::Result<usize> {
    const FRAME: usize = 16;
    let mut written = 0;
    for frame in bytes.chunks_exact(FRAME) {
        match rustix::io::write(fd, frame) {
            Ok(count) => written += count,
            // A full queue of the interface has its own error code.
            Err(rustix::io::Errno::NOBUFS | rustix::io::Errno::AGAIN) => break,
            Err(error) => return Err(error.into()),
        }
    }
    Ok(written)
}

fn connect(host: &str) -> io::Result<TcpStream> {
    let mut last = io::Error::new(ErrorKind::NotFound, "the name has no address");
    for address in host.to_socket_addrs()? {
        match TcpStream::connect_timeout(&address, CONNECT) {
            Ok(stream) => {
                stream.set_nodelay(true)?;
                stream.set_nonblocking(true)?;
                watch_over(&stream)?;
                return Ok(stream);
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}

/// Enables keepalive, to detect that the other end is gone.
fn watch_over(stream: &TcpStream) -> io::Result<()> {
    sockopt::set_socket_keepalive(stream, true)?;
    sockopt::set_tcp_keepidle(stream, ASK_AFTER)?;
    sockopt::set_tcp_keepintvl(stream, ASK_EVERY)?;
    sockopt::set_tcp_keepcnt(stream, ASKED)?;
    sockopt::set_tcp_user_timeout(stream, UNACKNOWLEDGED_MS)?;
    Ok(())
}

impl Recording {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<Got> {
        // A recording of days at the fastest line stays far below 2⁵² bytes.
        let come = (self.begun.elapsed().as_secs_f64() * self.bytes_per_s) as u64;
        let room = usize::try_from(come.saturating_sub(self.given)).unwrap_or(usize::MAX).min(buffer.len());
        if room == 0 {
            return Ok(Got::Nothing);
        }
        match self.file.read(&mut buffer[..room])? {
            0 => Ok(Got::Ended),
            count => {
                self.given += count as u64;
                Ok(Got::Bytes(count))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::Pty;
    use std::net::TcpListener;

    /// Reads until so many bytes are there, or the end.
    fn read_to(port: &mut Port, wanted: usize) -> (Vec<u8>, bool) {
        let until = Instant::now() + Duration::from_secs(20);
        let (mut all, mut buffer) = (Vec::new(), [0; 64]);
        while all.len() < wanted && Instant::now() < until {
            match port.read(&mut buffer) {
                Ok(Got::Bytes(count)) => all.extend(&buffer[..count]),
                Ok(Got::Nothing) => std::thread::yield_now(),
                Ok(Got::Ended) | Err(_) => return (all, true),
            }
        }
        (all, false)
    }

    #[test]
    fn a_serial_port_carries_every_byte_both_ways_and_tells_when_the_device_is_gone() {
        let Some(mut pty) = Pty::for_test() else { return };
        let mut port = Port::open(&Place::Serial { path: pty.path().to_owned(), baud: 19_200 }).unwrap();
        assert_eq!(pty.baud(), Some(19_200));
        assert_eq!(port.read(&mut [0; 8]).unwrap(), Got::Nothing);
        let all: Vec<u8> = (0..=255).collect();
        assert_eq!(pty.write(&all).unwrap(), 256);
        assert_eq!(read_to(&mut port, 256), (all.clone(), false));
        assert_eq!(port.write(&all).unwrap(), 256);
        let mut back = vec![0; 256];
        assert_eq!(pty.read(&mut back).unwrap(), Some(256));
        assert_eq!(back, all);
        pty.write(b"still there").unwrap();
        port.set_speed(4_800).unwrap();
        assert_eq!(pty.baud(), Some(4_800));
        assert_eq!(read_to(&mut port, 11), (b"still there".to_vec(), false));
        drop(pty);
        assert_eq!(read_to(&mut port, 1), (Vec::new(), true));
    }

    #[test]
    fn streams_and_datagrams_are_ports_too() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let host = listener.local_addr().unwrap().to_string();
        let mut port = Port::open(&Place::Tcp(host.clone())).unwrap();
        let Port::Tcp(stream) = &port else { panic!("{port:?}") };
        assert!(sockopt::socket_keepalive(stream).unwrap());
        assert_eq!(sockopt::tcp_user_timeout(stream).unwrap(), UNACKNOWLEDGED_MS);
        assert_eq!(sockopt::tcp_keepidle(stream).unwrap(), ASK_AFTER);
        let mut device = listener.accept().unwrap().0;
        device.write_all(b"$GPGGA").unwrap();
        assert_eq!(read_to(&mut port, 6), (b"$GPGGA".to_vec(), false));
        drop((device, listener));
        assert_eq!(read_to(&mut port, 1), (Vec::new(), true));
        let refused = Port::open(&Place::Tcp(host.clone())).unwrap_err().to_string();
        assert!(refused.contains(&host) && refused.contains("is the device's server on"), "{refused}");

        let mut port = Port::open(&Place::Udp("127.0.0.1:0".to_owned())).unwrap();
        let Port::Udp(socket) = &port else { panic!("{port:?}") };
        let to = socket.local_addr().unwrap();
        let device = UdpSocket::bind("127.0.0.1:0").unwrap();
        device.send_to(&[], to).unwrap();
        device.send_to(b"$HEHDT", to).unwrap();
        assert_eq!(read_to(&mut port, 6), (b"$HEHDT".to_vec(), false));
    }

    #[test]
    fn a_recording_comes_no_faster_than_its_line_and_ends() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), [7; 3000]).unwrap();
        let place = Place::Recording { path: file.path().to_owned(), baud: 115_200 };
        let begun = Instant::now();
        let (all, ended) = read_to(&mut Port::open(&place).unwrap(), usize::MAX);
        assert!(ended && all == [7; 3000]);
        // 3000 bytes at 11520 a second.
        assert!(begun.elapsed() >= Duration::from_millis(260), "{:?}", begun.elapsed());
    }

    #[test]
    fn a_socket_of_frames_takes_and_gives_them_whole_and_waits_for_nobody() {
        // A socket pair that keeps message boundaries and has a bounded queue replaces the bus: many kernels have none, not
        // even a virtual one.
        use rustix::net::{AddressFamily, SocketFlags, SocketType, socketpair};
        let (own, card) =
            socketpair(AddressFamily::UNIX, SocketType::SEQPACKET, SocketFlags::NONBLOCK, None).unwrap();
        let interface = format!("test-{}", std::process::id());
        let mut port = Port::Can(CanSocket::from(own), BusLock::take(&interface).unwrap());
        let frames: Vec<u8> = (0..48).collect();
        assert_eq!(port.write(&frames[..40]).unwrap(), 32, "of what is not a whole frame nothing leaves");
        let mut frame = [0; 64];
        for wanted in frames[..32].chunks(16) {
            assert_eq!(rustix::io::read(&card, &mut frame).unwrap(), 16);
            assert_eq!(&frame[..16], wanted);
        }
        assert_eq!(port.read(&mut [0; 64]).unwrap(), Got::Nothing);
        rustix::io::write(&card, &frames[16..32]).unwrap();
        assert_eq!(read_to(&mut port, 16), (frames[16..32].to_vec(), false));
        let mut taken = 0;
        while port.write(&frames).unwrap() == 48 {
            taken += 48;
            assert!(taken < 1 << 20, "a queue that nobody empties is full at some time");
        }
        drop(card);
        assert_eq!(read_to(&mut port, 16), (Vec::new(), true), "a bus that goes away is a lost port");
    }

    #[test]
    fn an_interface_that_is_not_there_is_named_with_what_to_do() {
        let error = Port::open(&Place::Can("can7".to_owned())).unwrap_err().to_string();
        assert!(error.contains("can7") && error.contains("ip link") && error.contains("slcan:"), "{error}");
    }
}
