//! The cells of a row.

use super::columns::{Value, digits};
use tables::{Dialect, Format, IsoTime};
use units::UtcTime;

/// Cells one after another.
pub(super) struct Cells<'o> {
    out: &'o mut Vec<u8>,
    format: Format,
    absent: &'static str,
    is_first: bool,
}

impl<'o> Cells<'o> {
    pub(super) fn new(out: &'o mut Vec<u8>, dialect: Dialect, absent: &'static str) -> Self {
        Self { out, format: Format { dialect, ..Format::default() }, absent, is_first: true }
    }

    /// Cells that go on with a row.
    pub(super) fn further(out: &'o mut Vec<u8>, dialect: Dialect, absent: &'static str) -> Self {
        Self { is_first: false, ..Self::new(out, dialect, absent) }
    }

    fn next(&mut self) {
        if !std::mem::replace(&mut self.is_first, false) {
            self.format.next(self.out);
        }
    }

    /// A value as our own table has it.
    pub(super) fn value(&mut self, value: Value<'_>) {
        match value {
            Value::Text(text) => self.text(text),
            Value::Whole(value) => self.whole(value),
            Value::Real(value) => self.real(value),
            Value::Degrees(value) => self.degrees(value),
            Value::Number(value) => self.number(value),
            Value::Thousandths(seconds, millis) => self.decimals(&format!("{seconds}.{millis:03}")),
            Value::Millis(time) => self.iso_ms(time.map(UtcTime::micros)),
            Value::Micros(time) => self.iso_us(time),
        }
    }

    /// Nothing is known.
    pub(super) fn nothing(&mut self) {
        self.next();
        self.out.extend_from_slice(self.absent.as_bytes());
    }

    /// As [`Self::nothing`], so many times.
    pub(super) fn nothings(&mut self, cells: usize) {
        (0..cells).for_each(|_| self.nothing());
    }

    /// A text; an empty one is not known.
    pub(super) fn text(&mut self, value: &str) {
        if value.is_empty() {
            return self.nothing();
        }
        self.next();
        tables::text(self.out, value.as_bytes(), self.format);
    }

    /// A text that may be there.
    pub(super) fn maybe(&mut self, value: Option<&str>) {
        self.text(value.unwrap_or_default());
    }

    pub(super) fn whole(&mut self, value: Option<i64>) {
        let Some(value) = value else { return self.nothing() };
        self.next();
        tables::integer(self.out, value);
    }

    /// A number with as many digits as tell it from all others, always as a real.
    pub(super) fn real(&mut self, value: Option<f64>) {
        let Some(value) = value else { return self.nothing() };
        self.next();
        tables::double(self.out, value, self.format.dialect);
    }

    /// A number with the digits that it needs: `12`, `0.2`; see [`digits`].
    pub(super) fn number(&mut self, value: Option<f64>) {
        let Some(value) = value.filter(|value| value.is_finite()) else { return self.nothing() };
        self.decimals(&digits(value));
    }

    /// Degrees with eight decimals.
    pub(super) fn degrees(&mut self, value: Option<f64>) {
        let Some(value) = value else { return self.nothing() };
        self.decimals(&format!("{value:.8}"));
    }

    /// A number whose decimals are written already.
    pub(super) fn decimals(&mut self, text: &str) {
        self.next();
        tables::real(self.out, text, self.format.dialect);
    }

    /// `2026-11-21T08:00:00.007Z`.
    pub(super) fn iso_ms(&mut self, time: Option<i64>) {
        self.written(time, |out, time_us| IsoTime::new().write_ms(out, time_us));
    }

    /// `2026-11-21T08:00:00.000007Z`.
    pub(super) fn iso_us(&mut self, time: Option<UtcTime>) {
        self.written(time.map(UtcTime::micros), |out, time_us| IsoTime::new().write(out, time_us));
    }

    /// `2026-11-21T08:00:00Z`.
    pub(super) fn iso_s(&mut self, time: Option<i64>) {
        self.written(time, |out, time_us| {
            IsoTime::new().write(out, time_us);
            out.truncate(out.len() - ".000000Z".len());
            out.push(b'Z');
        });
    }

    /// `2026-11-21 08:00:00.007`.
    pub(super) fn blank_ms(&mut self, time: Option<i64>) {
        self.written(time, |out, time_us| {
            IsoTime::new().write_ms(out, time_us);
            blank(out, "Z".len());
        });
    }

    /// `2026-11-21 08:00:00`.
    pub(super) fn blank_s(&mut self, time: Option<i64>) {
        self.written(time, |out, time_us| {
            IsoTime::new().write(out, time_us);
            blank(out, ".000000Z".len());
        });
    }

    fn written(&mut self, time_us: Option<i64>, write: impl FnOnce(&mut Vec<u8>, i64)) {
        let Some(time_us) = time_us else { return self.nothing() };
        self.next();
        write(self.out, time_us);
    }
}

/// Takes so many letters off the end, and makes the `T` before the time of day a blank.
fn blank(out: &mut Vec<u8>, off: usize) {
    out.truncate(out.len() - off);
    if let Some(at) = out.iter().rposition(|byte| *byte == b'T') {
        out[at] = b' ';
    }
}
