//! The command `imc`: IMC packets, logs and links from the shell.
//!
//! One module per subcommand. Each prints to [`output::Output`] and says with an [`outcome::Outcome`]
//! whether its input was sound; an error stands for misuse. [`run`] and [`main`] turn these into the exit
//! status: 0 for sound, 1 for damaged, 2 for misuse. A reader that closes the pipe early, as `head` does,
//! is no error.

mod address;
mod decode;
mod encode;
mod info;
mod input;
mod json_lines;
mod list;
mod listen;
mod lsf;
mod net;
mod outcome;
mod output;
mod pick;
mod record;
mod report;
mod send;
mod sink;
mod style;
mod table;

use clap::{CommandFactory as _, Parser, Subcommand};
use outcome::Outcome;
use output::Output;
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  imc decode Data.lsf.gz | head            the first packets of a log, one JSON object a line
  imc decode log.imc | imc encode > copy   the same bytes again
  imc info EstimatedState                  what a message's fields mean
  imc list salinity                        which messages speak of it
  imc lsf info Data.lsf.gz                 what is in a log: span, sources, counts, rates, damage
  imc lsf csv Data.lsf.gz -m GpsFix --degrees > fixes.csv
  imc address ntnu-otter-01                0x2810
  imc listen udp --to 127.0.0.1            what a simulated vehicle tells a console
  imc send tcp 10.0.10.60:6003 --dst ntnu-otter-01 --message Abort

Every subcommand has more under `imc SUBCOMMAND --help`.

Exit status: 0 all well, 1 some input was damaged or nothing matched, 2 misuse (bad flags, no such file).
Colour is used only on a terminal and never with NO_COLOR set.";

/// IMC packets, logs and links from the shell.
///
/// IMC (Inter-Module Communication) is what the vehicles, consoles and logs of LSTS speak. This command
/// shows it as JSON and back, explains its messages, listens and talks to vehicles.
#[derive(Debug, Parser)]
#[command(name = "imc", version, after_help = EXAMPLES, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Decode(decode::Decode),
    Encode(encode::Encode),
    Info(info::Info),
    List(list::List),
    Address(address::Lookup),
    Listen(listen::Listen),
    Send(send::Send),
    Lsf(lsf::Lsf),
    /// Write manual pages and completions for shells, for packages.
    #[command(hide = true)]
    Manual(manual::ManualArguments),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let mut out = Output::stdout();
    let result = run(&cli.command, &mut out).and_then(|outcome| {
        out.finish()?;
        Ok(outcome)
    });
    match result {
        Ok(outcome) => outcome.into(),
        Err(error) if output::is_closed(&error) => ExitCode::SUCCESS,
        Err(error) => {
            report::error(&error);
            ExitCode::from(2)
        }
    }
}

fn run(command: &Command, out: &mut Output) -> anyhow::Result<Outcome> {
    match command {
        Command::Decode(decode) => decode.run(out),
        Command::Encode(encode) => encode.run(out),
        Command::Info(info) => info.run(out),
        Command::List(list) => list.run(out),
        Command::Address(lookup) => lookup.run(out),
        Command::Listen(listen) => listen.run(out),
        Command::Send(send) => send.run(out),
        Command::Lsf(lsf) => lsf.run(out),
        Command::Manual(arguments) => {
            manual::write(&Cli::command(), &arguments.folder)?;
            Ok(Outcome::Sound)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_of_the_manual_is_one_that_the_program_takes() {
        let wrong = testkit::manual::commands_of("imc").into_iter().filter_map(|said| {
            let why = manual::accepts(&Cli::command(), &said.words, said.is_whole).err()?;
            Some(format!("{}: {}\n{why}", said.place, said.words.join(" ")))
        });
        let wrong: Vec<_> = wrong.collect();
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }
}
