//! Results that several processes may compute at once.

use mimesh_document::{Diagnostic, Kind};

use crate::cache::{Key, StageLock, Store};

/// What is done about results that several processes may compute at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sharing {
    /// Nothing: they are computed.
    None,
    /// They are left to a process that has locked them.
    Respect,
    /// They are locked while they are computed, and left to a process that has done so before.
    Lock,
}

impl Sharing {
    /// Takes the lock on the result of `stage` (by the implementation `name`) under `key` if that is called for.
    ///
    /// # Errors
    ///
    /// [`Kind::Busy`] if another process computes this result and it is not computed twice.
    pub fn lock(
        self,
        store: &Store,
        stage: &'static str,
        name: &str,
        key: Key,
    ) -> Result<Option<StageLock>, Diagnostic> {
        let held = match self {
            Self::None => return Ok(None),
            Self::Respect => StageLock::holder(store, stage, key).map_or(Ok(None), Err),
            Self::Lock => StageLock::take(store, stage, key).map(Some),
        };
        held.map_err(|holder| {
            let message = format!("{stage} ({name}): {holder} computes it now");
            Diagnostic::new(Kind::Busy, message).hint("run this again when it is done; its result is then cached")
        })
    }
}
