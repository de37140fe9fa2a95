//! Files that are written while they are sent: whole, a part of one, or visibly cut.
//!
//! The same question to the same data gives the same bytes, which its `ETag` stands for; so a download that broke off goes on
//! (`Range`, `If-Range`). A part is written from the beginning too, and what was sent before is passed over; for its length
//! the file is written once more before, to nowhere.

use crate::AppState;
use crate::web::ApiError;
use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse as _, Response};
use flate2::Compression;
use flate2::write::GzEncoder;
use futures_util::StreamExt as _;
use sha2::{Digest as _, Sha256};
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use store::StoreError;
use tokio::runtime::Handle;
use tokio::sync::{OwnedSemaphorePermit, mpsc};

/// Bytes that are handed to the connection at once.
const CHUNK: usize = 64 * 1024;
/// Chunks that may wait for a slow reader; the export waits with them.
const CHUNKS: usize = 4;
/// A reader that takes nothing for so long is let go: an export holds a place and a view of the database.
const PATIENCE: Duration = Duration::from_mins(1);

/// Writes a file from a data folder; called more than once where a part is asked for.
pub(super) type Writer = Arc<dyn Fn(&Path, &mut dyn Write) -> store::Result<()> + Send + Sync>;
/// Which state of the data it would be written from.
pub(super) type Version = Arc<dyn Fn(&Path) -> store::Result<u64> + Send + Sync>;

/// A file that can be asked for.
pub(super) struct Download {
    pub(super) name: String,
    pub(super) media: &'static str,
    /// Whether it is packed as a file.
    pub(super) gzip: bool,
    /// What was asked, in words that differ when the bytes may.
    pub(super) question: String,
    pub(super) write: Writer,
    pub(super) version: Version,
}

impl Download {
    /// The answer to a request with these headers.
    pub(super) async fn answer(self, state: &AppState, asked: &HeaderMap) -> Result<Response, ApiError> {
        let Ok(place) = Arc::clone(&state.shore.history.exports).try_acquire_owned() else {
            return Err(ApiError::busy("As many exports as may are running; try again in a moment."));
        };
        let (data, version) = (state.shore.history.data().to_owned(), Arc::clone(&self.version));
        let version = blocking(move || version(&data)).await?;
        let tag = self.tag(version);
        let wanted = wanted(asked, &tag);
        if let Wanted::Nothing = wanted {
            return Ok((StatusCode::NOT_MODIFIED, [(header::ETAG, value(&tag))]).into_response());
        }
        let packed_on_its_way = !self.gzip && accepts_gzip(asked);
        let (status, part) = match wanted {
            Wanted::Part(span) => {
                let (data, write, gzip) =
                    (state.shore.history.data().to_owned(), Arc::clone(&self.write), self.gzip);
                let total = blocking(move || length(gzip, |out| write(&data, out))).await?;
                let Some(part) = span.within(total) else { return Ok(beyond(total, &tag)) };
                (StatusCode::PARTIAL_CONTENT, Some(part))
            }
            Wanted::Whole | Wanted::Nothing => (StatusCode::OK, None),
        };
        let media = if self.gzip { "application/gzip" } else { self.media };
        let disposition = format!("attachment; filename=\"{}\"", self.name);
        let body = self.body(state, place, part.map(|part| (part, version))).await?;
        let mut response = (status, body).into_response();
        let headers = response.headers_mut();
        headers.insert(header::CONTENT_TYPE, HeaderValue::from_static(media));
        headers.insert(header::CONTENT_DISPOSITION, value(&disposition));
        if let Some(part) = part {
            headers.insert(header::CONTENT_LENGTH, part.bytes().into());
            headers.insert(header::CONTENT_RANGE, value(&part.told()));
        }
        // What is packed on its way has other bytes, of which no part can be asked for.
        let tag = if packed_on_its_way && part.is_none() { format!("W/{tag}") } else { tag };
        headers.insert(header::ETAG, value(&tag));
        headers.insert(header::ACCEPT_RANGES, HeaderValue::from_static("bytes"));
        Ok(response)
    }

    fn tag(&self, version: u64) -> String {
        let program = env!("CARGO_PKG_VERSION");
        let text = format!("{program}|{}|{}|{version}", self.question, self.gzip);
        format!("\"{}\"", hex::encode(&Sha256::digest(text)[..12]))
    }

    /// What is sent, while it is written: all, or a part of what the data of a version give.
    async fn body(
        self,
        state: &AppState,
        place: OwnedSemaphorePermit,
        part: Option<(Part, u64)>,
    ) -> Result<Body, ApiError> {
        let data = state.shore.history.data().to_owned();
        let (chunks, taken) = mpsc::channel(CHUNKS);
        let runtime = Handle::current();
        tokio::task::spawn_blocking(move || {
            let _place = place;
            let bounds = part.map_or((0, u64::MAX), |(part, _)| (part.first, part.bytes()));
            let out = Chunks {
                buffer: Vec::with_capacity(CHUNK),
                sender: chunks.clone(),
                runtime: runtime.clone(),
                is_cut: false,
                skip: bounds.0,
                left: bounds.1,
            };
            let written = finish(out, self.gzip, |out| (self.write)(&data, out));
            let unchanged = || match part {
                Some((_, version)) if (self.version)(&data)? != version => Err(StoreError::Cancelled),
                _ => Ok(()),
            };
            if let Err(error) = written.and_then(|()| unchanged()) {
                tracing::info!(%error, "an export was cut or refused");
                // Ends the connection without the mark of a whole answer, so that nobody takes it for one.
                runtime.block_on(tokio::time::timeout(PATIENCE, chunks.send(Err(error)))).ok();
            }
        });
        first_then_rest(taken).await
    }
}

/// Work that waits for the disk.
async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> store::Result<T> + Send + 'static,
) -> Result<T, ApiError> {
    let done = tokio::task::spawn_blocking(work).await.map_err(|error| ApiError::internal(&error))?;
    Ok(done?)
}

/// A header's value of letters that are known to be fit for one.
fn value(text: &str) -> HeaderValue {
    HeaderValue::from_str(text).unwrap_or(HeaderValue::from_static(""))
}

fn accepts_gzip(asked: &HeaderMap) -> bool {
    asked
        .get_all(header::ACCEPT_ENCODING)
        .iter()
        .any(|one| one.to_str().is_ok_and(|text| text.contains("gzip")))
}

/// There is no such part.
fn beyond(total: u64, tag: &str) -> Response {
    let headers = [(header::CONTENT_RANGE, value(&format!("bytes */{total}"))), (header::ETAG, value(tag))];
    (StatusCode::RANGE_NOT_SATISFIABLE, headers).into_response()
}

/// What of a file is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Wanted {
    Whole,
    /// Who asks has it.
    Nothing,
    Part(Span),
}

/// A part as it is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Span {
    /// From a byte on, up to another that belongs to it, or to the end.
    From(u64, Option<u64>),
    /// So many bytes at the end.
    Last(u64),
}

/// A part of a file of known length.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Part {
    first: u64,
    last: u64,
    total: u64,
}

impl Part {
    fn bytes(self) -> u64 {
        self.last - self.first + 1
    }

    fn told(self) -> String {
        format!("bytes {}-{}/{}", self.first, self.last, self.total)
    }
}

impl Span {
    fn within(self, total: u64) -> Option<Part> {
        let end = total.checked_sub(1)?;
        let (first, last) = match self {
            Self::From(first, last) => (first, last.map_or(end, |last| last.min(end))),
            Self::Last(0) => return None,
            Self::Last(bytes) => (total.saturating_sub(bytes), end),
        };
        (first <= last).then_some(Part { first, last, total })
    }
}

/// By RFC 9110: of several parts, or of another state than the one that is had, all is given.
fn wanted(asked: &HeaderMap, tag: &str) -> Wanted {
    let text = |name| asked.get(name).and_then(|value: &HeaderValue| value.to_str().ok());
    let same = |one: &str| one == "*" || one.trim().trim_start_matches("W/") == tag;
    if text(header::IF_NONE_MATCH).is_some_and(|tags| tags.split(',').any(|one| same(one.trim()))) {
        return Wanted::Nothing;
    }
    if text(header::IF_RANGE).is_some_and(|had| had.trim() != tag) {
        return Wanted::Whole;
    }
    text(header::RANGE).and_then(span).map_or(Wanted::Whole, Wanted::Part)
}

fn span(text: &str) -> Option<Span> {
    let (first, last) = text.trim().strip_prefix("bytes=")?.trim().split_once('-')?;
    let number = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit()).then(|| text.parse().ok())?;
    match (first, last) {
        ("", last) => Some(Span::Last(number(last)?)),
        (first, "") => Some(Span::From(number(first)?, None)),
        (first, last) => {
            let (first, last) = (number(first)?, number(last)?);
            (first <= last).then_some(Span::From(first, Some(last)))
        }
    }
}

/// How long the file is.
fn length(gzip: bool, write: impl FnOnce(&mut dyn Write) -> store::Result<()>) -> store::Result<u64> {
    struct Counted(u64);
    impl Write for Counted {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0 += bytes.len() as u64;
            Ok(bytes.len())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    let mut counted = Counted(0);
    if gzip {
        let mut packed = GzEncoder::new(&mut counted, Compression::fast());
        write(&mut packed)?;
        packed.finish().map_err(unwritable)?;
    } else {
        write(&mut counted)?;
    }
    Ok(counted.0)
}

fn unwritable(source: io::Error) -> StoreError {
    StoreError::Io { path: "the export".into(), source }
}

/// Writes, packed if wanted. What was cut gets no ending, by which programs that unpack notice.
fn finish(
    mut out: Chunks,
    gzip: bool,
    write: impl FnOnce(&mut dyn Write) -> store::Result<()>,
) -> store::Result<()> {
    if !gzip {
        let written = write(&mut out);
        let flushed = out.flush().map_err(unwritable);
        return written.and(flushed);
    }
    // The quickest: the link is seldom as slow as a better one would be.
    let mut packed = GzEncoder::new(out, Compression::fast());
    if let Err(error) = write(&mut packed) {
        packed.flush().ok();
        // The encoder ends the file when it is dropped.
        packed.get_mut().is_cut = true;
        return Err(error);
    }
    packed.finish().and_then(|mut out| out.flush()).map_err(unwritable)
}

type Chunk = Result<Bytes, StoreError>;

/// An export that fails before its first byte is an ordinary error with its reason.
async fn first_then_rest(mut taken: mpsc::Receiver<Chunk>) -> Result<Body, ApiError> {
    let first = match taken.recv().await {
        Some(Err(error)) => return Err(error.into()),
        first => first,
    };
    let rest = futures_util::stream::unfold((first, taken), |(first, mut taken)| async move {
        let chunk = match first {
            Some(chunk) => chunk,
            None => taken.recv().await?,
        };
        Some((chunk, (None, taken)))
    });
    // The compression asks again after the end.
    Ok(Body::from_stream(rest.fuse()))
}

/// Writes into the channel, and waits while it is full.
struct Chunks {
    buffer: Vec<u8>,
    sender: mpsc::Sender<Chunk>,
    runtime: Handle,
    /// Whether nothing may follow.
    is_cut: bool,
    /// Bytes before the part that is wanted.
    skip: u64,
    /// Bytes of that part.
    left: u64,
}

impl Write for Chunks {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.is_cut {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        let skipped = usize::try_from(self.skip).unwrap_or(usize::MAX).min(bytes.len());
        self.skip -= skipped as u64;
        let wanted = &bytes[skipped..];
        let wanted = &wanted[..usize::try_from(self.left).unwrap_or(usize::MAX).min(wanted.len())];
        self.left -= wanted.len() as u64;
        self.buffer.extend_from_slice(wanted);
        if self.buffer.len() >= CHUNK {
            self.flush()?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.buffer.is_empty() {
            return Ok(());
        }
        let full = std::mem::replace(&mut self.buffer, Vec::with_capacity(CHUNK));
        let sending = tokio::time::timeout(PATIENCE, self.sender.send(Ok(full.into())));
        match self.runtime.block_on(sending) {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) => Err(io::Error::new(io::ErrorKind::BrokenPipe, "nobody reads the export any more")),
            Err(_) => Err(io::Error::new(io::ErrorKind::TimedOut, "nobody read the export for a minute")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(headers: &[(header::HeaderName, &str)]) -> Wanted {
        let headers = headers.iter().map(|(name, text)| (name.clone(), value(text))).collect();
        wanted(&headers, "\"a\"")
    }

    #[test]
    fn a_part_is_what_stands_in_the_range() {
        let part = |text: &str| match asked(&[(header::RANGE, text)]) {
            Wanted::Part(span) => span.within(10).map(|part| (part.first, part.last)),
            other => panic!("{other:?}"),
        };
        assert_eq!(part("bytes=0-"), Some((0, 9)));
        assert_eq!(part("bytes=4-5"), Some((4, 5)));
        assert_eq!(part("bytes=9-100"), Some((9, 9)));
        assert_eq!(part("bytes=-3"), Some((7, 9)));
        assert_eq!(part("bytes=-30"), Some((0, 9)));
        assert_eq!((part("bytes=10-"), part("bytes=-0")), (None, None));
        for text in ["bytes=5-4", "bytes=0-1,4-5", "lines=1-2", "bytes=a-", "bytes=", "bytes=+1-"] {
            assert_eq!(asked(&[(header::RANGE, text)]), Wanted::Whole, "{text}");
        }
        assert_eq!(Span::From(0, None).within(0), None);
    }

    #[test]
    fn a_part_of_another_state_is_not_given() {
        let with = |had: &str| asked(&[(header::RANGE, "bytes=1-"), (header::IF_RANGE, had)]);
        assert_eq!(with("\"a\""), Wanted::Part(Span::From(1, None)));
        // A weak tag, and a date, do not say that the bytes are the same.
        for had in ["\"b\"", "W/\"a\"", "Sat, 21 Nov 2026 08:00:00 GMT"] {
            assert_eq!(with(had), Wanted::Whole, "{had}");
        }
        for had in ["\"a\"", "\"b\", W/\"a\"", "*"] {
            assert_eq!(asked(&[(header::IF_NONE_MATCH, had)]), Wanted::Nothing, "{had}");
        }
        assert_eq!(asked(&[(header::IF_NONE_MATCH, "\"b\"")]), Wanted::Whole);
    }
}
