//! Manual pages (`man lutra-server-backup`) and completions for shells, made from the program's own command line, so that they
//! cannot differ from it. Packages carry what [`write()`] writes.

use clap::{Args, Command};
use clap_complete::Shell;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The shells that get completions, and the folder of each.
const SHELLS: [(Shell, &str); 3] = [(Shell::Bash, "bash"), (Shell::Zsh, "zsh"), (Shell::Fish, "fish")];

/// The hidden command `manual FOLDER`.
#[derive(Debug, Args)]
pub struct ManualArguments {
    /// Where to write: `man/`, `bash/`, `zsh/` and `fish/`.
    pub folder: PathBuf,
}

/// Writes `man/` with a page for the program and for each of its commands, and `bash/`, `zsh/` and `fish/` with completions.
///
/// # Errors
/// The folder cannot be written.
pub fn write(program: &Command, folder: &Path) -> io::Result<()> {
    let pages = folder.join("man");
    fs::create_dir_all(&pages)?;
    clap_mangen::generate_to(program.clone(), pages)?;
    for (shell, name) in SHELLS {
        let folder = folder.join(name);
        fs::create_dir_all(&folder)?;
        clap_complete::generate_to(shell, &mut program.clone(), program.get_name(), folder)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Arg;

    #[test]
    fn every_command_that_is_shown_has_a_page_and_is_completed() {
        let program = Command::new("boat")
            .about("Sails.")
            .subcommand(Command::new("sail").about("Sail there.").arg(Arg::new("speed").long("speed")))
            .subcommand(Command::new("secret").hide(true));
        let folder = tempfile::tempdir().unwrap();
        write(&program, folder.path()).unwrap();
        let read = |path: &str| fs::read_to_string(folder.path().join(path)).unwrap();
        assert!(read("man/boat.1").contains("Sails."));
        assert!(read("man/boat-sail.1").contains("speed"));
        assert!(!folder.path().join("man/boat-secret.1").exists());
        for path in ["bash/boat.bash", "zsh/_boat", "fish/boat.fish"] {
            assert!(read(path).contains("speed"), "{path}");
        }
    }
}
