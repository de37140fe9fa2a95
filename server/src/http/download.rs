//! Files that are written while they are sent: whole, a part of one, or visibly cut.
//!
//! The same query on the same data gives the same bytes, identified by the `ETag`; so an interrupted download can be
//! resumed (`Range`, `If-Range`). A part is written from the beginning too, and the bytes before it are skipped; to find
//! its length, the file is written once more before, to a null sink. The last bytes of a part are sent only if the data
//! still match the tag.

use crate::AppState;
use crate::web::ApiError;
use api::say;
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
use tokio::sync::mpsc;
use tokio_util::sync::CancellationToken;

/// Bytes that are handed to the connection at once.
const CHUNK: usize = 64 * 1024;
/// Chunks that may wait for a slow reader; the export waits with them.
const CHUNKS: usize = 4;
/// A reader that takes nothing for this long is disconnected: an export holds a place and a snapshot of the database.
const PATIENCE: Duration = Duration::from_mins(1);

/// Writes a file from a data folder; called more than once where a part is asked for.
pub(super) type Writer = Arc<dyn Fn(&Path, &mut dyn Write) -> store::Result<()> + Send + Sync>;
/// Version of the data that it would be written from.
pub(super) type Version = Arc<dyn Fn(&Path) -> store::Result<u64> + Send + Sync>;

/// Limits how many files are written at once; released when dropped.
pub(super) type Place = Box<dyn Send>;

/// A file that can be downloaded.
pub(super) struct Download {
    pub(super) name: String,
    pub(super) media: &'static str,
    /// Whether it is a gzip file.
    pub(super) gzip: bool,
    /// The query as a text that differs whenever the bytes may differ.
    pub(super) question: String,
    pub(super) write: Writer,
    pub(super) version: Version,
}

impl Download {
    /// The answer to a request with these headers.
    pub(super) async fn answer(self, state: &AppState, asked: &HeaderMap) -> Result<Response, ApiError> {
        let Ok(place) = Arc::clone(&state.shore.history.exports).try_acquire_owned() else {
            return Err(ApiError::busy(say("Too many exports are running; try again in a moment.")));
        };
        self.answer_in(Box::new(place), state, asked).await
    }

    /// The answer, for which a place is held until it is sent.
    pub(super) async fn answer_in(
        self,
        mut place: Place,
        state: &AppState,
        asked: &HeaderMap,
    ) -> Result<Response, ApiError> {
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
                // If the client is gone, the computation is cancelled; the place is held until it has ended.
                let given_up = CancellationToken::new();
                let _here = given_up.clone().drop_guard();
                let reckon = move || Ok((place, length(gzip, given_up, |out| write(&data, out))?));
                let (still, total) = blocking(reckon).await?;
                place = still;
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
        // Compression on the way changes the bytes, so no ranges of them can be requested.
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

    /// The body, sent while it is written: all, or a part of a version's file.
    async fn body(self, state: &AppState, place: Place, part: Option<(Part, u64)>) -> Result<Body, ApiError> {
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
            let (mut out, written) = finish(out, self.gzip, |out| (self.write)(&data, out));
            let unchanged = || match part {
                Some((_, version)) if (self.version)(&data)? != version => Err(StoreError::Cancelled),
                _ => Ok(()),
            };
            let whole = written.and_then(|()| unchanged());
            // The end of a part is sent only when all of it is known to be of one version.
            let sent = if whole.is_ok() || part.is_none() { out.send().map_err(unwritable) } else { Ok(()) };
            if let Err(error) = whole.and(sent) {
                tracing::info!(%error, "an export was cut or refused");
                // Ends the connection without the end mark of a complete answer, so that no client takes it for one.
                runtime.block_on(tokio::time::timeout(PATIENCE, chunks.send(Err(error)))).ok();
            }
        });
        first_then_rest(taken).await
    }
}

/// Runs work that waits for the disk.
async fn blocking<T: Send + 'static>(
    work: impl FnOnce() -> store::Result<T> + Send + 'static,
) -> Result<T, ApiError> {
    let done = tokio::task::spawn_blocking(work).await.map_err(|error| ApiError::internal(&error))?;
    Ok(done?)
}

/// A header's value from characters that are known to be valid.
fn value(text: &str) -> HeaderValue {
    HeaderValue::from_str(text).unwrap_or(HeaderValue::from_static(""))
}

fn accepts_gzip(asked: &HeaderMap) -> bool {
    asked
        .get_all(header::ACCEPT_ENCODING)
        .iter()
        .any(|one| one.to_str().is_ok_and(|text| text.contains("gzip")))
}

/// The answer for a range that does not exist.
fn beyond(total: u64, tag: &str) -> Response {
    let headers = [(header::CONTENT_RANGE, value(&format!("bytes */{total}"))), (header::ETAG, value(tag))];
    let text = say("Range: the file has {total} bytes; ask for a part of them, or leave Range out");
    let error = ApiError::new(StatusCode::RANGE_NOT_SATISFIABLE, "no_such_range", text.with("total", total));
    (headers, error).into_response()
}

/// The requested part of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Wanted {
    Whole,
    /// The client has it already.
    Nothing,
    Part(Span),
}

/// A requested range.
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

/// By RFC 9110: for several ranges, or if the client has another version, the whole file is sent.
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

/// The length of the file; the computation can be cancelled.
fn length(
    gzip: bool,
    given_up: CancellationToken,
    write: impl FnOnce(&mut dyn Write) -> store::Result<()>,
) -> store::Result<u64> {
    let mut counted = Counted { bytes: 0, given_up };
    if gzip {
        let mut packed = Packed::new(&mut counted);
        write(&mut packed)?;
        packed.gzip.finish().map_err(unwritable)?;
    } else {
        write(&mut counted)?;
    }
    Ok(counted.bytes)
}

/// A sink that only counts bytes.
struct Counted {
    bytes: u64,
    given_up: CancellationToken,
}

impl Write for Counted {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.flush()?;
        self.bytes += bytes.len() as u64;
        Ok(bytes.len())
    }

    /// Fails once the length is given up, by which what is read for it ends too.
    fn flush(&mut self) -> io::Result<()> {
        if self.given_up.is_cancelled() {
            return Err(io::Error::new(
                io::ErrorKind::BrokenPipe,
                "the client no longer waits for the export",
            ));
        }
        Ok(())
    }
}

/// Packs what is written. It is flushed only to ask whether the file is still waited for: what is packed stays the same, however often
/// that is asked.
struct Packed<'p, W: Write> {
    gzip: GzEncoder<&'p mut W>,
    /// Whether anything was written.
    is_begun: bool,
}

impl<'p, W: Write> Packed<'p, W> {
    fn new(out: &'p mut W) -> Self {
        // The quickest: the link is seldom as slow as a better one would be.
        Self { gzip: GzEncoder::new(out, Compression::fast()), is_begun: false }
    }
}

impl<W: Write> Write for Packed<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.is_begun |= !bytes.is_empty();
        self.gzip.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.gzip.get_mut().flush()
    }
}

fn unwritable(source: io::Error) -> StoreError {
    StoreError::Io { path: "the export".into(), source }
}

/// Writes, compressed if requested, up to the last chunk, which is not sent yet. A cut file gets no end mark, so that
/// decompressors notice.
fn finish(
    mut out: Chunks,
    gzip: bool,
    write: impl FnOnce(&mut dyn Write) -> store::Result<()>,
) -> (Chunks, store::Result<()>) {
    let written = if gzip {
        let mut packed = Packed::new(&mut out);
        match write(&mut packed) {
            Ok(()) => packed.gzip.finish().map(drop).map_err(unwritable),
            Err(error) => {
                // Of a file that was refused before its first byte nothing goes out, so that the reason does.
                if packed.is_begun {
                    packed.gzip.flush().ok();
                }
                // The encoder ends the file when it is dropped.
                packed.gzip.get_mut().is_cut = true;
                Err(error)
            }
        }
    } else {
        write(&mut out)
    };
    // Once the part is complete, the rest is not written.
    let written = if out.left == 0 { Ok(()) } else { written };
    (out, written)
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
    // The compression layer polls again after the end.
    Ok(Body::from_stream(rest.fuse()))
}

/// Writes into the channel, and waits while it is full.
struct Chunks {
    buffer: Vec<u8>,
    sender: mpsc::Sender<Chunk>,
    runtime: Handle,
    /// Whether nothing may follow.
    is_cut: bool,
    /// Bytes before the requested part.
    skip: u64,
    /// Bytes of that part.
    left: u64,
}

impl Write for Chunks {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.is_cut || self.left == 0 {
            return Err(io::ErrorKind::BrokenPipe.into());
        }
        let skipped = usize::try_from(self.skip).unwrap_or(usize::MAX).min(bytes.len());
        self.skip -= skipped as u64;
        let wanted = &bytes[skipped..];
        let wanted = &wanted[..usize::try_from(self.left).unwrap_or(usize::MAX).min(wanted.len())];
        self.left -= wanted.len() as u64;
        self.buffer.extend_from_slice(wanted);
        if self.buffer.len() >= CHUNK && self.left > 0 {
            self.send()?;
        }
        Ok(bytes.len())
    }

    /// An incomplete chunk waits for more, or for the end. Fails once the file is not read any more, which ends its making too.
    fn flush(&mut self) -> io::Result<()> {
        if self.sender.is_closed() {
            return Err(io::Error::new(io::ErrorKind::BrokenPipe, "the client no longer reads the export"));
        }
        Ok(())
    }
}

impl Chunks {
    /// Sends the chunk.
    fn send(&mut self) -> io::Result<()> {
        if self.buffer.is_empty() {
            return Ok(());
        }
        let full = std::mem::replace(&mut self.buffer, Vec::with_capacity(CHUNK));
        let sending = tokio::time::timeout(PATIENCE, self.sender.send(Ok(full.into())));
        match self.runtime.block_on(sending) {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) => {
                Err(io::Error::new(io::ErrorKind::BrokenPipe, "the client reads the export no longer"))
            }
            Err(_) => Err(io::Error::new(
                io::ErrorKind::TimedOut,
                "the client took nothing of the export for a minute",
            )),
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

    /// A file of ten bytes; with `changes` the data have another version at each check.
    fn ten_bytes(changes: bool) -> Download {
        let looks = std::sync::atomic::AtomicU64::new(0);
        let version = move |_: &Path| {
            Ok(if changes { looks.fetch_add(1, std::sync::atomic::Ordering::Relaxed) } else { 7 })
        };
        let write = |_: &Path, out: &mut dyn Write| {
            out.write_all(b"01234").and_then(|()| out.write_all(b"56789")).map_err(unwritable)
        };
        Download {
            name: "ten".to_owned(),
            media: "text/plain",
            gzip: false,
            question: "ten".to_owned(),
            write: Arc::new(write),
            version: Arc::new(version),
        }
    }

    #[tokio::test]
    async fn the_end_of_a_part_is_kept_back_where_the_data_changed_meanwhile() {
        let shore = crate::http::tests::Shore::with(|_| ()).await;
        let headers = [(header::RANGE, HeaderValue::from_static("bytes=2-6"))].into_iter().collect();
        let answer = ten_bytes(false).answer(&shore.state, &headers).await.unwrap();
        assert_eq!(answer.headers()[header::CONTENT_RANGE], "bytes 2-6/10");
        assert_eq!(&axum::body::to_bytes(answer.into_body(), 100).await.unwrap()[..], b"23456");
        // Nothing was sent before: it is an error with its reason instead of bytes of two versions.
        assert!(ten_bytes(true).answer(&shore.state, &headers).await.is_err());
        let whole = ten_bytes(true).answer(&shore.state, &HeaderMap::new()).await.unwrap();
        assert_eq!(&axum::body::to_bytes(whole.into_body(), 100).await.unwrap()[..], b"0123456789");
    }

    #[test]
    fn a_length_that_nobody_waits_for_is_not_reckoned_to_the_end() {
        let (given_up, mut written) = (CancellationToken::new(), 0);
        given_up.cancel();
        let write = |out: &mut dyn Write| {
            for _ in 0..1_000 {
                out.write_all(b"x").map_err(unwritable)?;
                written += 1;
            }
            Ok(())
        };
        assert!(length(false, given_up.clone(), write).is_err());
        assert_eq!(written, 0);
        // Also where nothing is written before the end.
        for gzip in [false, true] {
            assert!(length(gzip, given_up.clone(), |out| out.flush().map_err(unwritable)).is_err());
        }
    }

    /// A file that was cancelled, or refused, before its first byte.
    #[tokio::test]
    async fn what_is_not_read_any_more_ends_when_it_is_flushed() {
        for gzip in [false, true] {
            let (sender, taken) = mpsc::channel(CHUNKS);
            let out = Chunks {
                buffer: Vec::new(),
                sender,
                runtime: Handle::current(),
                is_cut: false,
                skip: 0,
                left: u64::MAX,
            };
            let mut taken = Some(taken);
            let write = |out: &mut dyn Write| {
                out.flush().map_err(unwritable)?;
                taken = None;
                out.flush().map_err(unwritable)
            };
            let (out, written) = finish(out, gzip, write);
            assert!(written.is_err() && out.buffer.is_empty(), "{gzip}");
            assert!(taken.is_none());
        }
    }
}
