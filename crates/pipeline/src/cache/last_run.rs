//! The inputs of the last run, which explain why a stage runs again.

use serde_json::{Map, Value};

use super::{
    codec::CacheCodec,
    keys::{RunKeys, StageKey},
    store::{Key, Lookup, Store},
};
use crate::{input::Prepared, json::to_bytes};

/// The kind of its entry in the cache.
const KIND: &str = "last_run";

/// The inputs of the stages in the last run of a pipeline.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LastRun(Map<String, Value>);

/// Why a stage runs again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Change {
    /// This pipeline has not been run, or not with this stage.
    New,
    /// These have changed since the last run.
    Changed(Vec<String>),
    /// Nothing has changed; the result is gone.
    Gone,
}

impl LastRun {
    /// The inputs of a run with `keys`.
    pub fn of(keys: &RunKeys) -> Self {
        let stages = keys.stages().into_iter();
        Self(stages.filter_map(|(name, key)| Some((name.into(), key?.inputs.clone().into()))).collect())
    }

    /// The last run of `prepared`; empty if there was none.
    pub fn read(store: &Store, prepared: &Prepared) -> Self {
        match store.get(KIND, key(prepared)) {
            Lookup::Hit(bytes) => Self::decode(&bytes).unwrap_or_default(),
            _ => Self::default(),
        }
    }

    /// Stores it; a failure only costs the reason in the next plan.
    pub fn store(&self, store: &Store, prepared: &Prepared) {
        let _ = store.put(KIND, key(prepared), &self.encode());
    }

    /// Why `stage`, with the key `key`, has no result now.
    pub fn change(&self, stage: &str, key: &StageKey) -> Change {
        let Some(before) = self.0.get(stage).and_then(Value::as_object) else { return Change::New };
        let mut changes = Vec::new();
        for (name, now) in &key.inputs {
            match before.get(name) {
                Some(before) if before == now => {}
                Some(before) if name == "settings" => differences("", before, now, &mut changes),
                _ if name == "files" => changes.push("a file that the settings name".into()),
                _ => changes.push(name.clone()),
            }
        }
        if changes.is_empty() { Change::Gone } else { Change::Changed(changes) }
    }
}

impl CacheCodec for LastRun {
    fn encode(&self) -> Vec<u8> {
        to_bytes(&self.0)
    }

    fn decode(bytes: &[u8]) -> Option<Self> {
        serde_json::from_slice(bytes).ok().map(Self)
    }
}

/// The key of a pipeline's last run: runs differ by where they report.
fn key(prepared: &Prepared) -> Key {
    let path = std::path::absolute(&prepared.outputs.report).unwrap_or_else(|_| prepared.outputs.report.clone());
    Key(blake3::hash(path.as_os_str().as_encoded_bytes()))
}

/// Each setting that is another one now, with both values.
fn differences(path: &str, before: &Value, now: &Value, found: &mut Vec<String>) {
    match (before, now) {
        (Value::Object(a), Value::Object(b)) if a.get("type") == b.get("type") => {
            let keys = b.keys().chain(a.keys().filter(|key| !b.contains_key(*key)));
            for key in keys {
                let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                differences(&path, a.get(key).unwrap_or(&Value::Null), b.get(key).unwrap_or(&Value::Null), found);
            }
        }
        (Value::Object(a), Value::Object(b)) => {
            let kind = |map: &Map<String, Value>| map.get("type").cloned().unwrap_or_default();
            let path = if path.is_empty() { "type".into() } else { format!("{path}.type") };
            found.push(format!("{path} is {}, was {}", kind(b), kind(a)));
        }
        _ if before != now => found.push(format!("{path} is {now}, was {before}")),
        _ => {}
    }
}
