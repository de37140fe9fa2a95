//! Files and standard input, decompressed if gzip'd.

use anyhow::Context as _;
use flate2::bufread::MultiGzDecoder;
use std::fs::File;
use std::io::{self, BufReader, IsTerminal as _, Read};
use std::path::Path;

/// Bytes read at once.
pub(crate) const CHUNK: usize = 1 << 16;
const GZIP_MAGIC: [u8; 2] = [0x1F, 0x8B];

/// A stream of bytes with a name.
pub(crate) struct Input {
    name: String,
    /// Bytes that were peeked and not yet read.
    head: Vec<u8>,
    source: Box<dyn Read>,
    packed: bool,
}

impl Input {
    /// Opens a file, or standard input for `-`.
    ///
    /// # Errors
    /// When the file cannot be opened or read.
    pub(crate) fn open(path: &Path) -> anyhow::Result<Self> {
        if path == Path::new("-") {
            if io::stdin().is_terminal() {
                crate::report::note("reading from the terminal; end with Ctrl-D, or give a FILE");
            }
            return Self::unpacked("standard input".to_owned(), Box::new(io::stdin().lock()));
        }
        let name = path.display().to_string();
        let file = File::open(path).with_context(|| format!("cannot open {name}"))?;
        Self::unpacked(name, Box::new(file))
    }

    fn unpacked(name: String, source: Box<dyn Read>) -> anyhow::Result<Self> {
        let mut input = Self { name, head: Vec::new(), source, packed: false };
        let enough = |head: &[u8]| head.len() >= 2 || head.first().is_some_and(|&byte| byte != GZIP_MAGIC[0]);
        let packed = input.peek(enough)?.starts_with(&GZIP_MAGIC);
        if !packed {
            return Ok(input);
        }
        let name = input.name.clone();
        let source = MultiGzDecoder::new(BufReader::with_capacity(CHUNK, input));
        Ok(Self { name, head: Vec::new(), source: Box::new(source), packed })
    }

    /// Its name in messages.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Peeks until `enough` or the end; peeked bytes are read again.
    ///
    /// # Errors
    /// When it cannot be read.
    pub(crate) fn peek(&mut self, enough: impl Fn(&[u8]) -> bool) -> anyhow::Result<&[u8]> {
        let mut chunk = [0; 512];
        while !enough(&self.head) {
            match self.source.read(&mut chunk) {
                Ok(0) => break,
                Ok(count) => self.head.extend_from_slice(&chunk[..count]),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                // Damage of compressed data is reported again, in its place, when the head has been read.
                Err(error) if self.is_damage(&error) => break,
                Err(error) => return Err(error).with_context(|| format!("cannot read {}", self.name)),
            }
        }
        Ok(&self.head)
    }

    /// Whether a read error means that compressed bytes are damaged, not that reading failed.
    pub(crate) fn is_damage(&self, error: &io::Error) -> bool {
        use io::ErrorKind::{InvalidData, InvalidInput, UnexpectedEof};
        self.packed && matches!(error.kind(), InvalidData | InvalidInput | UnexpectedEof)
    }
}

impl Read for Input {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.head.is_empty() {
            return self.source.read(into);
        }
        let count = into.len().min(self.head.len());
        into[..count].copy_from_slice(&self.head[..count]);
        self.head.drain(..count);
        Ok(count)
    }
}
