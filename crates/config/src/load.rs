//! Reading a configuration from its files, with what was saved while the vessel ran.

use crate::config::Config;
use crate::ini::Ini;
use crate::overlay::Overlay;
use crate::parser::{Need, Parser};
use crate::problem::Report;
use crate::resolve::resolve;
use crate::source::FileSource;
use std::path::Path;

impl Ini {
    /// Reads `path` and everything it requires or includes, without looking at what the sections mean.
    pub fn read(source: &impl FileSource, path: &Path) -> (Self, Report) {
        let mut parser = Parser::new(source);
        parser.file(path, None, Need::Required);
        let (ini, report, _) = parser.finish();
        (ini, report)
    }
}

impl Config {
    /// Reads `path`, everything it requires or includes and the vessel's `-saved.ini` beside it, and gives
    /// every section that Lutra knows its typed values for the selected profiles.
    ///
    /// Nothing in the saved file can make a good configuration a bad one: a value that would is dropped with
    /// a warning, and the one of the other files stays in force.
    pub fn load(source: &impl FileSource, path: &Path, selected: &[&str]) -> Self {
        let mut parser = Parser::new(source);
        parser.file(path, None, Need::Required);
        let read = parser.finish();
        let config = resolve(read.clone(), selected, path);
        let Some(saved) = config.saved_path() else { return config };
        let mut parser = Parser::new(source);
        if !parser.file_if_present(&saved) {
            return config;
        }
        Overlay { base: config, read, selected, main: path }.with(&saved, parser.finish())
    }
}
