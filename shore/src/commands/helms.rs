//! Which vessels are steered by hand through this server.

use imc::Address;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};

/// The vessels that are steered by hand through this server: each by one window.
#[derive(Debug, Clone, Default)]
pub struct Helms(Arc<Mutex<BTreeSet<Address>>>);

/// A window's hold on a helm, until it is dropped.
#[derive(Debug)]
pub struct Helm(Helms, Address);

impl Helms {
    /// The helm of a vessel, unless another window has it.
    pub fn take(&self, vessel: Address) -> Option<Helm> {
        let mut taken = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        taken.insert(vessel).then(|| Helm(self.clone(), vessel))
    }
}

impl Drop for Helm {
    fn drop(&mut self) {
        self.0.0.lock().unwrap_or_else(PoisonError::into_inner).remove(&self.1);
    }
}
