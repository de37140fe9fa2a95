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
        Self::load_kept(source, path, selected, None)
    }

    /// As [`Self::load`], with what was saved while running in the folder `kept`, or beside the main file where there is
    /// nothing yet. A service may not write where its configuration is.
    pub fn load_aboard(source: &impl FileSource, path: &Path, selected: &[&str], kept: &Path) -> Self {
        Self::load_kept(source, path, selected, Some(kept))
    }

    fn load_kept(source: &impl FileSource, path: &Path, selected: &[&str], kept: Option<&Path>) -> Self {
        let mut parser = Parser::new(source);
        parser.file(path, None, Need::Required);
        let read = parser.finish();
        let mut config = resolve(read.clone(), selected, path);
        config.saved_in = kept.map(Path::to_owned);
        for saved in [config.saved_path(), config.saved_beside()].into_iter().flatten() {
            let mut parser = Parser::new(source);
            if parser.file_if_present(&saved) {
                let mut config =
                    Overlay { base: config, read, selected, main: path }.with(&saved, parser.finish());
                config.saved_in = kept.map(Path::to_owned);
                return config;
            }
        }
        config
    }
}
