//! Long answers in parts, so that none takes more memory than its asker allowed.

use std::ops::ControlFlow;

/// Which part of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Page {
    /// Messages to pass over.
    pub skip: usize,
    /// Most messages.
    pub rows: usize,
    /// The page ends after the message that reaches so many bytes of text and raw data.
    pub bytes: usize,
}

impl Page {
    /// The first messages, however long.
    pub fn first(rows: usize) -> Self {
        Self { skip: 0, rows, bytes: usize::MAX }
    }
}

/// A part of an answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Paged<T> {
    /// What was asked for, in the order asked for; of time where none was.
    pub items: Vec<T>,
    /// Where the rest begins; `None` when this is all.
    pub next: Option<Next>,
}

/// Where the rest of an answer begins: the same question from this time on, or, the newest first, up to and with this
/// time, passing over so many messages. What comes late can shift it by as many as came for this very microsecond.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Next {
    /// Time of the first message that is missing (µs since 1970-01-01 UTC).
    pub time_us: i64,
    /// Messages of the same time before it.
    pub skip: usize,
}

/// Counts messages in order of time, or against it.
#[derive(Debug)]
pub(super) struct Pager {
    page: Page,
    passed: usize,
    taken: usize,
    bytes: usize,
    /// The time of the last message and how many of that time there were.
    last: (i64, usize),
    next: Option<Next>,
}

impl Pager {
    pub(super) fn new(page: Page) -> Self {
        Self { page, passed: 0, taken: 0, bytes: 0, last: (i64::MIN, 0), next: None }
    }

    /// Looks at the next message, which `take` gets if it is within the page and says how long it was. Whether
    /// the page goes on.
    pub(super) fn step(
        &mut self,
        time_us: i64,
        take: impl FnOnce() -> rusqlite::Result<usize>,
    ) -> rusqlite::Result<ControlFlow<()>> {
        let before = if self.last.0 == time_us { self.last.1 } else { 0 };
        if self.passed < self.page.skip {
            self.passed += 1;
        } else if self.taken < self.page.rows && self.bytes < self.page.bytes {
            self.bytes = self.bytes.saturating_add(take()?);
            self.taken += 1;
        } else {
            self.next = Some(Next { time_us, skip: before });
            return Ok(ControlFlow::Break(()));
        }
        self.last = (time_us, before + 1);
        Ok(ControlFlow::Continue(()))
    }

    /// Ends the page before its time: it goes on at this one.
    pub(super) fn stop(&mut self, time_us: i64) {
        self.next = Some(Next { time_us, skip: 0 });
    }

    pub(super) fn end<T>(self, items: Vec<T>) -> Paged<T> {
        Paged { items, next: self.next }
    }
}
