//! Locks on results that are being computed, so that others need not compute them too.
//!
//! A lock is advisory, and belongs to an open file: the system releases it when its process ends in any way. On NFS and SMB it holds
//! between machines if the server keeps locks. Where there are none, everybody computes, and all results are the same.

use std::{
    fmt, fs,
    fs::{File, TryLockError},
    io::{Read, Seek, Write},
    path::PathBuf,
};

use serde::{Deserialize, Serialize};

use super::store::{Key, Store};

/// The folder of locks beside the results.
const FOLDER: &str = "locks";

/// A process that computes a result.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LockHolder {
    /// Its number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub process: Option<u32>,
    /// The machine that it runs on, where that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub host: Option<String>,
}

/// A lock that this process holds; dropped, others may take it.
#[derive(Debug)]
pub struct StageLock {
    /// `None` where the system has no locks.
    held: Option<(File, PathBuf)>,
}

impl StageLock {
    /// Takes the lock on the result of `stage` under `key`, without waiting.
    ///
    /// # Errors
    ///
    /// Who holds it, if another process does.
    pub fn take(store: &Store, stage: &str, key: Key) -> Result<Self, LockHolder> {
        let folder = store.folder().join(FOLDER);
        let path = folder.join(format!("{stage}-{}", key.0.to_hex()));
        let opened = fs::create_dir_all(&folder)
            .and_then(|()| File::options().read(true).write(true).create(true).truncate(false).open(&path));
        // A cache that cannot be written is no reason to compute nothing.
        let Ok(mut file) = opened else { return Ok(Self { held: None }) };
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(LockHolder::read(&mut file)),
            Err(TryLockError::Error(_)) => return Ok(Self { held: None }),
        }
        LockHolder::this().write(&mut file);
        Ok(Self { held: Some((file, path)) })
    }

    /// Who computes the result of `stage` under `key` now, if another process does.
    pub fn holder(store: &Store, stage: &str, key: Key) -> Option<LockHolder> {
        let path = store.folder().join(FOLDER).join(format!("{stage}-{}", key.0.to_hex()));
        let mut file = File::options().read(true).write(true).open(path).ok()?;
        matches!(file.try_lock(), Err(TryLockError::WouldBlock)).then(|| LockHolder::read(&mut file))
    }
}

impl Drop for StageLock {
    fn drop(&mut self) {
        // Removed while it is held. Who has opened it already may hold a file without a name, and computes what is cached by now.
        if let Some((file, path)) = self.held.take() {
            let _ = fs::remove_file(path);
            drop(file);
        }
    }
}

impl LockHolder {
    /// This process.
    fn this() -> Self {
        Self { process: Some(std::process::id()), host: host() }
    }

    /// Who holds the lock on `file`; nothing is known of a process that has not written it yet, or where a lock forbids reading.
    fn read(file: &mut File) -> Self {
        let mut text = String::new();
        let read = file.rewind().and_then(|()| file.take(4096).read_to_string(&mut text));
        read.ok().and_then(|_| serde_json::from_str(&text).ok()).unwrap_or_default()
    }

    /// Writes it for others to read; it matters to people only.
    fn write(&self, file: &mut File) {
        let text = serde_json::to_string(self).unwrap_or_default();
        let _ = file.set_len(0).and_then(|()| file.rewind()).and_then(|()| file.write_all(text.as_bytes()));
    }
}

impl fmt::Display for LockHolder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.process, &self.host) {
            (Some(process), Some(host)) => write!(f, "process {process} on {host}"),
            (Some(process), None) => write!(f, "process {process}"),
            _ => f.write_str("another process"),
        }
    }
}

/// The name of this machine, where the system tells it.
fn host() -> Option<String> {
    let of_linux = fs::read_to_string("/proc/sys/kernel/hostname").ok();
    let of_environment = || ["HOSTNAME", "COMPUTERNAME"].into_iter().find_map(|name| std::env::var(name).ok());
    let host = of_linux.or_else(of_environment)?;
    Some(host.trim().to_owned()).filter(|host| !host.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lock_is_held_by_one_and_free_when_it_ends() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path(), 1 << 20);
        let key = Key(blake3::hash(b"a"));
        assert_eq!(StageLock::holder(&store, "correspondence", key), None);
        let lock = StageLock::take(&store, "correspondence", key).unwrap();
        // Another open file is another holder, as in another process.
        let holder = StageLock::take(&store, "correspondence", key).unwrap_err();
        assert_eq!(holder.process, Some(std::process::id()));
        assert!(holder.to_string().starts_with(&format!("process {}", std::process::id())));
        assert_eq!(StageLock::holder(&store, "correspondence", key), Some(holder));
        let _other = StageLock::take(&store, "landmarks", key).unwrap();
        drop(lock);
        assert_eq!(StageLock::holder(&store, "correspondence", key), None);
        drop(StageLock::take(&store, "correspondence", key).unwrap());
        assert_eq!(store.clear().unwrap().entries, 0, "a lock is no entry");
    }

    #[test]
    fn what_a_killed_process_has_left_holds_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::new(folder.path(), 1 << 20);
        let key = Key(blake3::hash(b"a"));
        let lock = StageLock::take(&store, "landmarks", key).unwrap();
        let (file, path) = {
            let mut lock = lock;
            lock.held.take().unwrap()
        };
        drop(file);
        assert!(path.exists());
        assert_eq!(StageLock::holder(&store, "landmarks", key), None);
        assert!(StageLock::take(&store, "landmarks", key).is_ok());
    }
}
