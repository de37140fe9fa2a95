//! The file `<vehicle>-saved.ini`: values changed while running that survive a restart.
//!
//! It lies beside the main file and overrides all others. It is written whole and put in place by renaming,
//! so that after a power cut either the old or the new one is there.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::Path;

use crate::ini::{Ini, Unwritable, write_header, write_setting};

/// The values of a saved file, by section and key.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Saved {
    sections: BTreeMap<String, BTreeMap<String, String>>,
}

impl Saved {
    /// The values of a saved file that was read.
    pub fn from_ini(ini: &Ini) -> Self {
        let mut saved = Self::default();
        for (section, settings) in ini.sections() {
            for (key, setting) in settings.settings() {
                saved.set(section, key, setting.value());
            }
        }
        saved
    }

    /// Saves a value, in place of one saved before.
    pub fn set(&mut self, section: &str, key: &str, value: &str) {
        let settings = self.sections.entry(section.to_owned()).or_default();
        settings.insert(key.to_owned(), value.to_owned());
    }

    /// Forgets a value, so that the other files decide again; returns whether it was saved.
    pub fn forget(&mut self, section: &str, key: &str) -> bool {
        self.sections.get_mut(section).is_some_and(|settings| settings.remove(key).is_some())
    }

    /// A saved value.
    pub fn get(&self, section: &str, key: &str) -> Option<&str> {
        self.sections.get(section)?.get(key).map(String::as_str)
    }

    /// The text of the file.
    ///
    /// # Errors
    /// When a name or value cannot be written in the dialect.
    pub fn to_text(&self) -> Result<String, Unwritable> {
        let mut text = String::from("# Values saved while running; they override the other files.\n");
        for (section, settings) in self.sections.iter().filter(|(_, settings)| !settings.is_empty()) {
            text.push('\n');
            write_header(&mut text, section)?;
            for (key, value) in settings {
                write_setting(&mut text, section, key, value)?;
            }
        }
        Ok(text)
    }
}

/// Writes `text` to `path` so that at any moment either the old or the new file is there, whole.
///
/// # Errors
/// What the file system says; the old file is then still there.
pub fn write_atomically(path: &Path, text: &str) -> io::Result<()> {
    let mut name = OsString::from(".");
    name.push(path.file_name().ok_or(io::ErrorKind::InvalidInput)?);
    name.push(".part");
    let part = path.with_file_name(name);
    let written = write_synced(&part, text).and_then(|()| fs::rename(&part, path));
    if let Err(error) = written {
        // The part is of no use; the error that matters is the one above.
        let _ = fs::remove_file(&part);
        return Err(error);
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    File::open(folder)?.sync_all()
}

fn write_synced(path: &Path, text: &str) -> io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(text.as_bytes())?;
    file.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::{Disk, InMemory};

    #[test]
    fn what_is_saved_reads_back() {
        let mut saved = Saved::default();
        saved.set("Control.Path.ILOS", "ILOS Integrator Gain", "0.4");
        saved.set("Simulators.Motor/Port", "Thruster Act to RPM Factor", "50, 1100");
        saved.set("Control.Path.ILOS", "Course Control", "true");
        assert!(saved.forget("Control.Path.ILOS", "Course Control"));
        let files = InMemory::new().with("s.ini", saved.to_text().unwrap());
        let (ini, report) = Ini::read(&files, Path::new("s.ini"));
        assert_eq!(report.counts(), crate::Counts::default());
        assert_eq!(Saved::from_ini(&ini).get("Control.Path.ILOS", "ILOS Integrator Gain"), Some("0.4"));
        assert_eq!(Saved::from_ini(&ini).get("Control.Path.ILOS", "Course Control"), None);
    }

    #[test]
    fn a_value_that_cannot_be_written_is_refused() {
        let mut saved = Saved::default();
        saved.set("General", "Vehicle", "a # b");
        assert!(matches!(saved.to_text(), Err(Unwritable::Value { .. })));
    }

    #[test]
    fn writing_replaces_the_file_and_leaves_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("v-saved.ini");
        write_atomically(&path, "[A]\nb = 1\n").unwrap();
        write_atomically(&path, "[A]\nb = 2\n").unwrap();
        let (ini, _) = Ini::read(&Disk, &path);
        assert_eq!(ini.value("A", "b"), Some("2"));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        assert!(write_atomically(Path::new("/"), "x").is_err());
    }
}
