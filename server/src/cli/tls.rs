//! `lutra-server tls`.

use super::Common;
use super::say::{complain, say};
use crate::config::{Config, Tls};
use crate::tls::authority::{self, Renewal};
use anyhow::Context as _;
use clap::Subcommand;
use shore::clock;
use std::path::Path;
use std::process::ExitCode;

#[derive(Debug, Subcommand)]
pub(super) enum TlsCommand {
    /// Make a small authority (once) and a certificate for this server, in DATA/tls.
    Init {
        /// A name or address under which the server is reached; may be repeated. [default: this machine's
        /// name, localhost, 127.0.0.1 and ::1]
        #[arg(long = "name", value_name = "NAME")]
        names: Vec<String>,
        /// Replace the server's certificate and its key, with the same authority.
        #[arg(long)]
        renew: bool,
    },
    /// Renew the server's certificate with the authority of `tls init` that made it; its key and names stay.
    ///
    /// A running server takes it within seconds. Boats and browsers that trust the authority accept it as it is.
    Renew {
        /// Names and addresses of the new one; may be repeated. [default: those of the old one]
        #[arg(long = "name", value_name = "NAME")]
        names: Vec<String>,
        /// Only if it ends within so many days: for a timer that runs every day.
        #[arg(long, value_name = "DAYS")]
        within: Option<u32>,
        /// Only end with 0 if a certificate that `tls init` made is to be renewed, with 1 if not, with 255 if that cannot
        /// be determined.
        #[arg(long, requires = "within", conflicts_with = "names")]
        check: bool,
    },
}

/// Runs the command.
pub(super) fn tls(common: &Common, command: TlsCommand) -> ExitCode {
    let (outcome, trouble) = match command {
        TlsCommand::Init { names, renew } => (init(common, names, renew).map(|()| true), 1),
        TlsCommand::Renew { within: Some(within), check: true, .. } => (is_due(common, within), super::LOOK),
        TlsCommand::Renew { names, within, .. } => (renew(common, names, within).map(|()| true), 1),
    };
    match outcome {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            complain!("lutra-server: {}", super::told(&error));
            ExitCode::from(trouble)
        }
    }
}

fn is_due(common: &Common, within: u32) -> anyhow::Result<bool> {
    let config = common.load_to_write()?;
    let folder = config.data.join("tls");
    authority::is_due(&folder, &named(config, &folder), within, clock::now())
}

/// The configured certificate, or the one that `tls init` made if none is configured yet.
fn named(config: Config, folder: &Path) -> Tls {
    if config.tls.is_given() {
        return config.tls;
    }
    Tls { certificate: folder.join("server.pem"), key: folder.join("server-key.pem") }
}

fn init(common: &Common, mut names: Vec<String>, renew: bool) -> anyhow::Result<()> {
    if names.is_empty() {
        let own = std::fs::read_to_string("/proc/sys/kernel/hostname")
            .context("cannot read this machine's name")?;
        names = [own.trim(), "localhost", "127.0.0.1", "::1"].map(str::to_owned).to_vec();
        names.dedup();
    }
    let folder = common.load_to_write()?.data.join("tls");
    let made = authority::make(&folder, &names, renew, clock::now())?;
    say!("# for {}, until {}", names.join(", "), clock::written(made.until));
    say!("# browsers and vessels must trust {}", made.authority.display());
    say!("[tls]\ncertificate = {:?}\nkey = {:?}", made.certificate, made.key);
    Ok(())
}

fn renew(common: &Common, names: Vec<String>, within: Option<u32>) -> anyhow::Result<()> {
    let config = common.load_to_write()?;
    let folder = config.data.join("tls");
    let tls = named(config, &folder);
    let file = tls.certificate.display();
    match authority::renew(&folder, &tls, names, within, clock::now())? {
        Renewal::NotDue { until } => say!("{file} lasts until {}: nothing is renewed", clock::written(until)),
        Renewal::Renewed { names, until } => {
            say!("{file} is renewed until {}, for {}", clock::written(until), names.join(", "));
            say!(
                "a running server takes it within seconds; who trusts {} accepts it",
                folder.join("ca.pem").display()
            );
        }
    }
    Ok(())
}
