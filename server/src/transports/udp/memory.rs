//! Announced nodes, kept in a file, so that after a restart a streaming vessel is accepted at once and not only after its
//! next announcement.
//!
//! It holds only data of announcements, and is checked against the list of admitted networks when read.

use imc::Address;
use imc::messages::SystemType;
use serde::{Deserialize, Serialize};
use std::fs;
use std::io::{self, ErrorKind};
use std::net::SocketAddrV4;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tokio::task::JoinHandle;

/// How long the last writing may take when the server ends.
const LAST_WRITE: Duration = Duration::from_secs(1);

/// A node as it announced itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Announced {
    pub(super) address: u16,
    pub(super) name: String,
    /// Code of its system type.
    pub(super) kind: u8,
    pub(super) sockets: Vec<SocketAddrV4>,
}

impl Announced {
    pub(super) fn address(&self) -> Address {
        Address(self.address)
    }

    pub(super) fn kind(&self) -> SystemType {
        SystemType::from(self.kind)
    }
}

/// The file.
#[derive(Debug)]
pub(super) struct Memory {
    path: PathBuf,
    /// Its contents, including those being written.
    kept: Vec<Announced>,
    writing: Option<JoinHandle<()>>,
}

impl Memory {
    /// Reads the file in a data folder. An unreadable file counts as absent: nodes announce themselves again.
    pub(super) fn open(data: &Path) -> Self {
        let path = data.join("doors/udp.json");
        let kept = read(&path).unwrap_or_else(|error| {
            tracing::warn!(%error, path = %path.display(), "IMC nodes are heard when they announce themselves again");
            Vec::new()
        });
        Self { path, kept, writing: None }
    }

    pub(super) fn nodes(&self) -> &[Announced] {
        &self.kept
    }

    /// Begins to write these; false while the last writing is not done: a disk that hangs does not block.
    pub(super) fn keep(&mut self, nodes: impl FnOnce() -> Vec<Announced>) -> bool {
        if self.writing.as_ref().is_some_and(|writing| !writing.is_finished()) {
            return false;
        }
        let nodes = nodes();
        if nodes == self.kept {
            return true;
        }
        self.kept.clone_from(&nodes);
        let path = self.path.clone();
        self.writing = Some(tokio::task::spawn_blocking(move || {
            if let Err(error) = write(&path, &nodes) {
                tracing::warn!(%error, path = %path.display(), "after a restart IMC nodes must announce themselves");
            }
        }));
        true
    }

    /// Waits for the last writing, with a time limit for a disk that hangs.
    pub(super) async fn close(&mut self) {
        if let Some(writing) = self.writing.take() {
            tokio::time::timeout(LAST_WRITE, writing).await.ok();
        }
    }
}

fn read(path: &Path) -> io::Result<Vec<Announced>> {
    match fs::read(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(error),
        Ok(bytes) => Ok(serde_json::from_slice(&bytes)?),
    }
}

fn write(path: &Path, nodes: &[Announced]) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)?;
    }
    let part = path.with_extension("json.part");
    fs::write(&part, serde_json::to_vec(nodes)?)?;
    fs::rename(&part, path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn nodes_are_known_over_restarts_and_rubbish_is_as_good_as_none() {
        let data = tempfile::tempdir().unwrap();
        let otter = Announced {
            address: 0x2810,
            name: "otter-1".to_owned(),
            kind: 3,
            sockets: vec!["10.77.0.10:6002".parse().unwrap()],
        };
        let mut memory = Memory::open(data.path());
        assert_eq!(memory.nodes(), []);
        assert!(memory.keep(|| vec![otter.clone()]));
        memory.close().await;
        let memory = Memory::open(data.path());
        assert_eq!(memory.nodes(), [otter]);
        assert_eq!(memory.nodes()[0].kind(), SystemType::Usv);
        fs::write(&memory.path, b"[{").unwrap();
        assert_eq!(Memory::open(data.path()).nodes(), []);
    }
}
