//! Standard output: buffered, and closed without an error when its reader is gone.

use std::fmt;
use std::io::{self, BufWriter, StdoutLock, Write};

/// Standard output of this process.
pub(crate) struct Output {
    writer: BufWriter<StdoutLock<'static>>,
}

/// The reader of standard output has gone. Apart from other broken pipes, such as a lost connection.
#[derive(Debug)]
struct Closed;

impl fmt::Display for Closed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("standard output was closed")
    }
}

impl std::error::Error for Closed {}

impl Output {
    /// Takes standard output.
    pub(crate) fn stdout() -> Self {
        Self { writer: BufWriter::with_capacity(1 << 16, io::stdout().lock()) }
    }

    /// Writes out the buffer; to be called once at the end, where an error can still be reported.
    pub(crate) fn finish(&mut self) -> io::Result<()> {
        self.flush()
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.write(bytes).map_err(told)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush().map_err(told)
    }
}

/// The error with standard output named in it.
fn told(error: io::Error) -> io::Error {
    match error.kind() {
        io::ErrorKind::BrokenPipe => io::Error::other(Closed),
        io::ErrorKind::Interrupted => error,
        kind => io::Error::new(kind, format!("writing to standard output: {error}")),
    }
}

/// Whether an error only means that the reader of standard output is gone.
pub(crate) fn is_closed(error: &anyhow::Error) -> bool {
    let causes = error.chain().filter_map(|cause| cause.downcast_ref::<io::Error>());
    causes.filter_map(io::Error::get_ref).any(<dyn std::error::Error + Send + Sync>::is::<Closed>)
}
