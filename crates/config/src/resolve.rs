//! From what was read to the typed values of the selected profiles, checked as a whole.

use crate::check;
use crate::config::Config;
use crate::ini::Ini;
use crate::problem::Report;
use crate::profile::Profiles;
use crate::schema::general;
use crate::typed;
use std::path::Path;
use std::sync::Arc;

/// The result of a parser: settings, problems, files.
pub(crate) type Read = (Ini, Report, Vec<Arc<str>>);

/// The configuration that was read from `path` and what it names, for the selected profiles.
pub(crate) fn resolve((ini, mut report, files): Read, selected: &[&str], path: &Path) -> Config {
    let profiles = Profiles::new(&ini, selected, &mut report);
    let vehicle_type = ini.value(general::GENERAL.name(), general::VEHICLE_TYPE.spec.name);
    let sections = typed::sections(&ini, &profiles, vehicle_type.unwrap_or_default(), &mut report);
    let mut config = Config { ini, files, profiles, sections, report, main: path.to_owned(), saved_in: None };
    check::all(&mut config);
    config
}
