//! `lutra-server tls`.

use super::Common;
use super::say::say;
use crate::tls;
use anyhow::Context as _;
use clap::Subcommand;
use shore::clock;

#[derive(Debug, Subcommand)]
pub(super) enum TlsCommand {
    /// Make a small authority (once) and a certificate for this server, in DATA/tls.
    Init {
        /// A name or address under which the server is reached; may be repeated. [default: this machine's
        /// name, localhost, 127.0.0.1 and ::1]
        #[arg(long = "name", value_name = "NAME")]
        names: Vec<String>,
        /// Replace the server's certificate, with the same authority.
        #[arg(long)]
        renew: bool,
    },
}

/// Does as told.
pub(super) fn tls(common: &Common, command: TlsCommand) -> anyhow::Result<()> {
    let TlsCommand::Init { mut names, renew } = command;
    if names.is_empty() {
        let own = std::fs::read_to_string("/proc/sys/kernel/hostname")
            .context("cannot read this machine's name")?;
        names = [own.trim(), "localhost", "127.0.0.1", "::1"].map(str::to_owned).to_vec();
        names.dedup();
    }
    let folder = common.load_to_write()?.data.join("tls");
    let made = tls::make(&folder, &names, renew)?;
    say!("# for {}, until {}", names.join(", "), clock::written(made.until));
    say!("# browsers and vessels must trust {}", made.authority.display());
    say!("[tls]\ncertificate = {:?}\nkey = {:?}", made.certificate, made.key);
    Ok(())
}
