//! A server on free ports and the transport that benchmarks use.

use imc::Header;
use imc::messages::Payload;
use server::config::Config;
use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;

/// A server with the IMCProxy transport open.
#[allow(dead_code, reason = "each benchmark uses what it needs")]
pub(crate) fn config(data: &Path) -> Config {
    let mut config = Config { data: data.to_owned(), ..Config::default() };
    config.http.listen = "127.0.0.1:0".parse().unwrap();
    config.imc.active = false;
    config.transports.imcproxy.listen = "127.0.0.1:0".to_owned().try_into().unwrap();
    config
}

/// A connection to the transport after its handshake.
pub(crate) fn connect(to: SocketAddr) -> TcpStream {
    let mut stream = TcpStream::connect(to).unwrap();
    stream.set_nodelay(true).unwrap();
    let request = "GET / HTTP/1.1\r\nHost: x\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
                   Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n";
    stream.write_all(request.as_bytes()).unwrap();
    let mut head = Vec::new();
    while !head.ends_with(b"\r\n\r\n") {
        let mut byte = [0];
        stream.read_exact(&mut byte).unwrap();
        head.push(byte[0]);
    }
    stream
}

/// A client's frame of a packet; the mask is zero, which leaves the bytes as they are.
pub(crate) fn frame<T: Payload>(out: &mut Vec<u8>, header: &Header, message: &T) {
    let start = out.len();
    out.extend_from_slice(&[0x82, 0x80, 0, 0, 0, 0]);
    imc::encode_into(out, header, message).unwrap();
    let length = out.len() - start - 6;
    assert!(length < 126, "the short frame of the protocol");
    out[start + 1] |= length as u8;
}
