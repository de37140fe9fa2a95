//! The whole configuration: files, profiles, typed sections, and every problem found on the way.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::ini::{Ini, IniSection};
use crate::problem::Report;
use crate::profile::Profiles;
use crate::schema::general;
use crate::section::Section;
use crate::spec::SectionSpec;

/// A configuration in force. It always exists; whether it may be used, its report says.
#[derive(Clone, Debug)]
pub struct Config {
    pub(crate) ini: Ini,
    pub(crate) files: Vec<Arc<str>>,
    pub(crate) profiles: Profiles,
    pub(crate) sections: Vec<Section>,
    pub(crate) report: Report,
    pub(crate) main: PathBuf,
    /// The folder of what was saved while running; `None` for that of the main file.
    pub(crate) saved_in: Option<PathBuf>,
}

impl Config {
    /// Everything found while reading; with errors in it the configuration must not be used.
    pub const fn report(&self) -> &Report {
        &self.report
    }

    /// The sections as text, with the history of every value.
    pub const fn ini(&self) -> &Ini {
        &self.ini
    }

    /// The files read, in the order in which they were opened.
    pub fn files(&self) -> &[Arc<str>] {
        &self.files
    }

    /// The profiles known and selected.
    pub const fn profiles(&self) -> &Profiles {
        &self.profiles
    }

    /// All sections of the files, ordered by name, those that Lutra does not know included.
    pub fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// A section by its name in the file.
    pub fn section(&self, name: &str) -> Option<&Section> {
        self.sections.iter().find(|section| section.name == name)
    }

    /// The same, to change its values while the program runs.
    pub fn section_mut(&mut self, name: &str) -> Option<&mut Section> {
        self.sections.iter_mut().find(|section| section.name == name)
    }

    /// The instances of a task that run with the selected profiles, ordered by name.
    pub fn running(&self, spec: &'static SectionSpec) -> impl Iterator<Item = &Section> {
        self.sections.iter().filter(move |section| section.runs && section.is(spec))
    }

    /// The running task with this entity label.
    pub fn by_label(&self, label: &str) -> Option<&Section> {
        self.sections.iter().find(|section| section.runs && section.label() == Some(label))
    }

    /// The section `General`, which is all defaults when the files have none.
    pub fn general(&self) -> Section {
        let given = self.section(general::GENERAL.name()).cloned();
        given.unwrap_or_else(|| Section::defaults(&general::GENERAL))
    }

    /// The vessel's name; empty when the files give none.
    pub fn vehicle(&self) -> &str {
        self.ini.value(general::GENERAL.name(), general::VEHICLE.spec.name).unwrap_or_default()
    }

    /// The IMC address of the vessel.
    pub fn address(&self) -> Option<u16> {
        self.addresses().get(self.vehicle()).copied()
    }

    /// The IMC addresses of all systems, by name.
    pub fn addresses(&self) -> BTreeMap<&str, u16> {
        let section = self.ini.section(general::IMC_ADDRESSES.name());
        let all = section.into_iter().flat_map(IniSection::settings);
        all.filter_map(|(name, setting)| {
            let number = crate::value::parse_int(setting.value()).ok()?;
            Some((name, u16::try_from(number.value).ok()?))
        })
        .collect()
    }

    /// Where values changed while running are saved, once the vessel has a name that can be one of a file.
    pub fn saved_path(&self) -> Option<PathBuf> {
        let beside = self.saved_beside()?;
        match (&self.saved_in, beside.file_name()) {
            (Some(folder), Some(name)) => Some(folder.join(name)),
            _ => Some(beside),
        }
    }

    /// The same beside the main file: earlier versions saved there, and a prepared vessel may have one there. It is read
    /// only if the data folder has no such file.
    pub fn saved_beside(&self) -> Option<PathBuf> {
        saved_path(&self.main, self.vehicle())
    }
}

impl Section {
    /// Whether `spec` describes this section, running or not.
    pub fn is(&self, spec: &'static SectionSpec) -> bool {
        self.spec.is_some_and(|own| std::ptr::eq(own, spec))
    }
}

/// `<vehicle>-saved.ini` in the folder of the main file.
fn saved_path(main: &Path, vehicle: &str) -> Option<PathBuf> {
    let plain = !vehicle.is_empty() && !vehicle.starts_with('.') && !vehicle.contains(['/', '\\', '\0']);
    plain.then(|| main.with_file_name(format!("{vehicle}-saved.ini")))
}
