//! Writing a log folder that other tools open.

use super::definitions_xml;
use crate::address::Address;
use crate::header::{Header, PacketView};
use crate::messages::{LoggingControl, LoggingControlOp};
use crate::packet;
use flate2::{Compression, GzBuilder, write::GzEncoder};
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use units::UtcTime;

/// Longest label in a folder name, in bytes.
const MAX_LABEL_BYTES: usize = 100;

/// The options of a log.
#[derive(Debug, Clone)]
pub struct LogOptions {
    /// The system that logs; the source of the first and last packet.
    pub system: Address,
    /// Its logging entity.
    pub entity: u8,
    /// Whether to write `Data.lsf.gz` rather than `Data.lsf`.
    pub compress: bool,
    /// The configuration to write beside the data as `Config.ini`; none when empty.
    pub config: String,
}

/// The name of a log below the base folder, in UTC: `20261121/074327_plan_label`.
///
/// Blanks, path separators and control characters of the label become `_`; a label that is too long is cut.
pub fn folder_name(time: UtcTime, label: &str) -> String {
    let c = time.civil();
    let mut name =
        format!("{:04}{:02}{:02}/{:02}{:02}{:02}", c.year, c.month, c.day, c.hour, c.minute, c.second);
    let keep =
        |letter: char| !(letter.is_whitespace() || letter.is_control() || "/\\:*?\"<>|".contains(letter));
    let label: String = label.chars().map(|letter| if keep(letter) { letter } else { '_' }).collect();
    let label = &label[..label.floor_char_boundary(MAX_LABEL_BYTES)];
    if !label.is_empty() {
        name.push('_');
        name.push_str(label);
    }
    name
}

/// An open log.
///
/// What was written before [`Self::flush`] can be read after a crash, also in a compressed log, whose reader
/// then reports the missing end.
#[derive(Debug)]
pub struct LogWriter {
    data: Data,
    output: BufWriter<File>,
    name: String,
    folder: PathBuf,
    options: LogOptions,
    buffer: Vec<u8>,
}

#[derive(Debug)]
enum Data {
    Plain(BufWriter<File>),
    Gzip(Box<GzEncoder<BufWriter<File>>>),
}

impl LogWriter {
    /// Makes the folder with its companion files and writes the packet that says so.
    ///
    /// So that the log explains itself, write next an `EntityInfo` of each entity or an `EntityList`, and the
    /// `TransportBindings`. A folder that is there already is left alone: the new one gets `_2`, `_3`, … after its name.
    ///
    /// # Errors
    /// When a folder or file cannot be made or written; the error names it.
    pub fn create(base: &Path, time: UtcTime, label: &str, options: LogOptions) -> io::Result<Self> {
        let (name, folder) =
            make_folder(base, &folder_name(time, label)).map_err(|error| named(base, &error))?;
        let file = |name: &str| {
            let path = folder.join(name);
            File::create_new(&path).map(BufWriter::new).map_err(|error| named(&path, &error))
        };
        let mut definitions = GzBuilder::new().write(file("IMC.xml.gz")?, Compression::default());
        definitions.write_all(definitions_xml().as_bytes())?;
        definitions.finish()?.flush()?;
        if !options.config.is_empty() {
            let mut config = file("Config.ini")?;
            config.write_all(options.config.as_bytes())?;
            config.flush()?;
        }
        let output = file("Output.txt")?;
        let data = if options.compress {
            Data::Gzip(Box::new(GzBuilder::new().write(file("Data.lsf.gz")?, Compression::fast())))
        } else {
            Data::Plain(file("Data.lsf")?)
        };
        let mut log = Self { data, output, name, folder, options, buffer: Vec::new() };
        log.control(time, LoggingControlOp::Started)?;
        Ok(log)
    }

    /// The name below the base folder.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Appends one packet unchanged.
    ///
    /// Log in one byte order, little-endian: the indexer of Neptus MRA gives up where both stand in one log.
    ///
    /// # Errors
    /// When the bytes are not just one packet, or the file cannot be written.
    pub fn write(&mut self, packet: &[u8]) -> io::Result<()> {
        match PacketView::unchecked(packet) {
            Ok(view) if view.bytes().len() == packet.len() => {}
            Ok(_) => return Err(io::Error::new(io::ErrorKind::InvalidInput, "more than one packet")),
            Err(error) => return Err(io::Error::new(io::ErrorKind::InvalidInput, error)),
        }
        match &mut self.data {
            Data::Plain(file) => file.write_all(packet),
            Data::Gzip(file) => file.write_all(packet),
        }
    }

    /// Appends one line to the console's text.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_line(&mut self, line: &str) -> io::Result<()> {
        writeln!(self.output, "{line}")
    }

    /// Hands everything written so far to the operating system.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn flush(&mut self) -> io::Result<()> {
        self.output.flush()?;
        match &mut self.data {
            Data::Plain(file) => file.flush(),
            Data::Gzip(file) => file.flush(),
        }
    }

    /// As [`Self::flush`], and waits until the data, the text and the folder that names them are on the disk.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn sync(&mut self) -> io::Result<()> {
        self.flush()?;
        self.output.get_ref().sync_data()?;
        match &self.data {
            Data::Plain(file) => file.get_ref().sync_data()?,
            Data::Gzip(file) => file.get_ref().get_ref().sync_data()?,
        }
        // A file whose folder entry was lost is lost itself; the day's folder may be new as well.
        self.folder.ancestors().take(3).try_for_each(|folder| File::open(folder)?.sync_all())
    }

    /// Writes the packet that ends a log and closes all files.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn finish(mut self, time: UtcTime) -> io::Result<()> {
        self.control(time, LoggingControlOp::Stopped)?;
        self.sync()?;
        match self.data {
            Data::Plain(file) => file.into_inner().map_err(io::IntoInnerError::into_error)?.sync_data(),
            Data::Gzip(file) => {
                file.finish()?.into_inner().map_err(io::IntoInnerError::into_error)?.sync_data()
            }
        }
    }

    fn control(&mut self, time: UtcTime, op: LoggingControlOp) -> io::Result<()> {
        let header = Header {
            timestamp: time.seconds(),
            src: self.options.system,
            src_ent: self.options.entity,
            ..Header::default()
        };
        let message = LoggingControl { op, name: self.name.as_str().into() };
        self.buffer.clear();
        packet::encode_into(&mut self.buffer, &header, &message).map_err(io::Error::other)?;
        let packet = std::mem::take(&mut self.buffer);
        self.write(&packet)?;
        self.buffer = packet;
        Ok(())
    }
}

/// The same error with the name of its file.
fn named(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}

/// Makes a folder that was not there, numbering its name if need be.
fn make_folder(base: &Path, name: &str) -> io::Result<(String, PathBuf)> {
    let mut number = 1;
    loop {
        let name = if number == 1 { name.to_owned() } else { format!("{name}_{number}") };
        let folder = base.join(&name);
        if let Some(day) = folder.parent() {
            fs::create_dir_all(day)?;
        }
        match fs::create_dir(&folder) {
            Ok(()) => return Ok((name, folder)),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => number += 1,
            Err(error) => return Err(error),
        }
    }
}
