//! Sizes of the pages of a Parquet file, from the headers before them: a file of some kilobytes can say that a page unpacks to two
//! gigabytes, and the library makes room for what a header says.
//!
//! A header is a struct in Thrift's compact protocol (parquet.thrift, `PageHeader`): field 2 is the size unpacked, field 3 the
//! size in the file. One page of each column is in memory at a time, and its dictionary.

use parquet::file::metadata::{ColumnChunkMetaData, ParquetMetaData};
use parquet::file::reader::ChunkReader;
use std::io::{self, Read};

/// Bytes of a page, unpacked. Writers make pages of 1 MiB, and dictionaries up to the same; ours may add 1,024 cells of 8 KiB.
const PAGE: i64 = 16 << 20;
/// Bytes of all pages of a column in one row group, unpacked.
const CHUNK: i64 = 1 << 30;
/// Row groups. We write one for each 32,768 rows.
const GROUPS: usize = 20_000;
/// Columns; ours has some thirty.
const COLUMNS: usize = 200;
/// Bytes of a page's header, which may hold least and greatest values.
const HEADER: u64 = 1 << 20;
/// Structs within structs of a header.
const DEPTH: u8 = 8;

/// Whether what the file's pages unpack to fits into a bounded memory.
///
/// # Errors
/// It does not, or a header is damaged; with what to do.
pub(super) fn measure<R: ChunkReader>(input: &R, footer: &ParquetMetaData) -> io::Result<()> {
    let groups = footer.row_groups();
    if groups.len() > GROUPS {
        return Err(too_large(&format!("{} row groups, at most {GROUPS}", groups.len())));
    }
    let mut first = 1;
    for group in groups {
        if group.num_columns() > COLUMNS {
            return Err(too_large(&format!("{} columns, at most {COLUMNS}", group.num_columns())));
        }
        let last = first + group.num_rows().max(1) - 1;
        for column in group.columns() {
            chunk(input, column).map_err(|error| {
                let place = format!("column {}, rows {first} to {last}", column.column_path().string());
                io::Error::new(error.kind(), format!("{place}: {error}"))
            })?;
        }
        first = last + 1;
    }
    Ok(())
}

/// The pages of one column in one row group.
fn chunk<R: ChunkReader>(input: &R, column: &ColumnChunkMetaData) -> io::Result<()> {
    let (mut at, end) = {
        let begin = column.dictionary_page_offset().unwrap_or_else(|| column.data_page_offset());
        let (begin, bytes) = (u64::try_from(begin).ok(), u64::try_from(column.compressed_size()).ok());
        let (begin, bytes) = begin.zip(bytes).ok_or_else(damaged)?;
        (begin, begin.checked_add(bytes).filter(|end| *end <= input.len()).ok_or_else(damaged)?)
    };
    let mut unpacked = 0_i64;
    while at < end {
        let header = header(&mut input.get_read(at).map_err(io::Error::other)?.take(HEADER))?;
        if !(0..=PAGE).contains(&header.unpacked) {
            let (mib, most) = (header.unpacked >> 20, PAGE >> 20);
            return Err(too_large(&format!("a page of {mib} MiB, at most {most}")));
        }
        unpacked += header.unpacked;
        if unpacked > CHUNK {
            let most = CHUNK >> 20;
            return Err(too_large(&format!("more than {most} MiB in one row group")));
        }
        let packed = u64::try_from(header.packed).map_err(|_| damaged())?;
        at = at.checked_add(header.bytes).and_then(|at| at.checked_add(packed)).ok_or_else(damaged)?;
    }
    Ok(())
}

/// What a page's header says.
struct Header {
    /// Its own length.
    bytes: u64,
    /// Bytes of the page, unpacked.
    unpacked: i64,
    /// Bytes of the page in the file.
    packed: i64,
}

fn header(input: &mut impl Read) -> io::Result<Header> {
    let mut thrift = Thrift { input, bytes: 0 };
    let (mut unpacked, mut packed, mut last) = (None, None, 0);
    while let Some((field, kind)) = thrift.field(last)? {
        last = field;
        match (field, kind) {
            (2, Thrift::<&[u8]>::I32) => unpacked = Some(thrift.number()?),
            (3, Thrift::<&[u8]>::I32) => packed = Some(thrift.number()?),
            _ => thrift.skip(kind, DEPTH)?,
        }
    }
    let (unpacked, packed) = unpacked.zip(packed).ok_or_else(damaged)?;
    Ok(Header { bytes: thrift.bytes, unpacked, packed })
}

/// Thrift's compact protocol, as far as it takes to pass over a struct.
struct Thrift<R> {
    input: R,
    bytes: u64,
}

impl<R: Read> Thrift<R> {
    const I32: u8 = 5;

    fn byte(&mut self) -> io::Result<u8> {
        let mut byte = [0];
        self.input.read_exact(&mut byte).map_err(|_| damaged())?;
        self.bytes += 1;
        Ok(byte[0])
    }

    fn unsigned(&mut self) -> io::Result<u64> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7F) << shift;
            if byte & 0x80 == 0 {
                return Ok(value);
            }
        }
        Err(damaged())
    }

    /// Zigzag: the sign is the lowest bit.
    fn number(&mut self) -> io::Result<i64> {
        let value = self.unsigned()?;
        Ok((value >> 1) as i64 ^ -((value & 1) as i64))
    }

    /// The next field of a struct and its type; `None` at its end.
    fn field(&mut self, last: i64) -> io::Result<Option<(i64, u8)>> {
        let byte = self.byte()?;
        let (delta, kind) = (byte >> 4, byte & 0x0F);
        if kind == 0 {
            return Ok(None);
        }
        let field = if delta == 0 { self.number()? } else { last.saturating_add(delta.into()) };
        Ok(Some((field, kind)))
    }

    fn skip(&mut self, kind: u8, depth: u8) -> io::Result<()> {
        let depth = depth.checked_sub(1).ok_or_else(damaged)?;
        match kind {
            // Booleans are their types.
            1 | 2 => {}
            3 => drop(self.byte()?),
            4..=6 => drop(self.unsigned()?),
            7 => self.pass(8)?,
            8 => {
                let bytes = self.unsigned()?;
                self.pass(bytes)?;
            }
            9 | 10 => self.skip_list(depth)?,
            12 => {
                let mut last = 0;
                while let Some((field, kind)) = self.field(last)? {
                    last = field;
                    self.skip(kind, depth)?;
                }
            }
            _ => return Err(damaged()),
        }
        Ok(())
    }

    fn skip_list(&mut self, depth: u8) -> io::Result<()> {
        let byte = self.byte()?;
        let count = if byte >> 4 == 15 { self.unsigned()? } else { u64::from(byte >> 4) };
        for _ in 0..count {
            match byte & 0x0F {
                // In a list a boolean has a byte.
                1 | 2 => drop(self.byte()?),
                kind => self.skip(kind, depth)?,
            }
        }
        Ok(())
    }

    fn pass(&mut self, bytes: u64) -> io::Result<()> {
        let passed = io::copy(&mut self.input.by_ref().take(bytes), &mut io::sink())?;
        self.bytes += passed;
        if passed == bytes { Ok(()) } else { Err(damaged()) }
    }
}

fn too_large(what: &str) -> io::Error {
    let text = format!(
        "this Parquet file has {what}: it is not one that Lutra wrote; download it again with format=parquet, or as CSV"
    );
    io::Error::new(io::ErrorKind::InvalidData, text)
}

fn damaged() -> io::Error {
    io::Error::new(
        io::ErrorKind::InvalidData,
        "this is not a whole file of Parquet, download it again (the header of a page is damaged)",
    )
}
