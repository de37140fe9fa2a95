//! Rows as CSV: RFC 4180, by the dialect that all tables of Lutra have.

use api::{TableDetection, TableRow};
use tables::{Dialect, Format};

const DIALECT: Dialect = Dialect::Plain;

/// A row that can be written as CSV.
pub trait CsvRow {
    /// The header line.
    const HEAD: &'static str;
    /// Appends the row without its end.
    fn write(&self, out: &mut Vec<u8>);
}

/// A header and all rows.
pub fn csv<R: CsvRow>(rows: &[R]) -> Vec<u8> {
    let mut out = format!("{}\n", R::HEAD).into_bytes();
    for row in rows {
        row.write(&mut out);
        out.push(b'\n');
    }
    out
}

/// Appends text that people or vessels wrote, and the separator.
fn text(out: &mut Vec<u8>, text: &str) {
    tables::text(out, text.as_bytes(), Format::default());
    out.push(DIALECT.separator());
}

/// Appends a number or an empty cell.
fn maybe(out: &mut Vec<u8>, value: Option<f64>) {
    if let Some(value) = value {
        tables::double(out, value, DIALECT);
    }
}

impl CsvRow for TableRow {
    const HEAD: &'static str = "time,vessel,series,entity,unit,min,mean,max,count";

    fn write(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(self.time.as_bytes());
        out.push(DIALECT.separator());
        for cell in [&self.vessel, &self.series, &self.entity, &self.unit] {
            text(out, cell);
        }
        for value in [Some(self.min), self.mean, Some(self.max)] {
            maybe(out, value);
            out.push(DIALECT.separator());
        }
        tables::integer(out, i64::try_from(self.count).unwrap_or(i64::MAX));
    }
}

impl CsvRow for TableDetection {
    const HEAD: &'static str = "time,vessel,tag,data,latitude,longitude,snr_db";

    fn write(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(self.time.as_bytes());
        out.push(DIALECT.separator());
        text(out, &self.vessel);
        text(out, &self.tag);
        if let Some(data) = self.data {
            tables::integer(out, data.into());
        }
        out.push(DIALECT.separator());
        for value in [self.latitude, self.longitude] {
            maybe(out, value);
            out.push(DIALECT.separator());
        }
        if let Some(snr_db) = self.snr_db {
            tables::integer(out, snr_db.into());
        }
    }
}
