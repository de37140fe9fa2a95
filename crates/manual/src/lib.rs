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

/// Whether a program takes a command that a document names, `words[0]` being the program. In running text (not `is_whole`) only
/// subcommands and flags are looked at: what must follow may be left out, and `NAME` or `…` may stand for it.
///
/// # Errors
/// Why the program does not take it.
pub fn accepts(program: &Command, words: &[String], is_whole: bool) -> Result<(), String> {
    if !is_whole {
        return knows(program, words);
    }
    match program.clone().try_get_matches_from(words) {
        Err(error) if error.use_stderr() => Err(error.to_string()),
        _ => Ok(()),
    }
}

/// Whether the subcommands and flags of a command are known.
fn knows(program: &Command, words: &[String]) -> Result<(), String> {
    let mut program = program.clone();
    program.build();
    let mut command = &program;
    let stands_for = |word: &str| word.contains(['…', '|', '.']) || word.chars().any(char::is_uppercase);
    for word in words.iter().skip(1) {
        if let Some(flag) = word.strip_prefix("--") {
            let name = flag.split('=').next().unwrap_or_default();
            let known = command.get_arguments().any(|one| one.get_long() == Some(name));
            if !known && name != "help" && !stands_for(name) {
                return Err(format!("{} has no flag --{name}", command.get_name()));
            }
        } else if let Some(next) = command.find_subcommand(word) {
            command = next;
        } else if command.has_subcommands() && !word.starts_with('-') && !stands_for(word) {
            return Err(format!("{} has no command {word}", command.get_name()));
        }
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

    #[test]
    fn a_command_that_the_program_does_not_take_is_refused_with_the_reason() {
        let place = Arg::new("place").required(true);
        let speed = Arg::new("speed").long("speed").value_parser(clap::value_parser!(u8));
        let program = Command::new("boat")
            .subcommand_required(true)
            .subcommand(Command::new("sail").arg(place).arg(speed));
        let judge = |line: &str, is_whole| {
            let words: Vec<_> = line.split(' ').map(str::to_owned).collect();
            accepts(&program, &words, is_whole)
        };
        for good in ["boat sail home", "boat sail home --speed 2", "boat --help", "boat sail --help"] {
            assert_eq!(judge(good, true), Ok(()), "{good}");
        }
        for bad in
            ["boat", "boat sail", "boat swim", "boat sail home --spede 2", "boat sail home --speed fast"]
        {
            assert!(judge(bad, true).is_err(), "{bad}");
        }
        for good in ["boat", "boat sail", "boat sail --speed", "boat COMMAND", "boat … --help"] {
            assert_eq!(judge(good, false), Ok(()), "{good}");
        }
        for bad in ["boat swim", "boat sail --spede"] {
            assert!(judge(bad, false).is_err(), "{bad}");
        }
    }
}
