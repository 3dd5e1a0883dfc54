//! Meshes that pipelines take from memory, and results that stay there.
//!
//! A pipeline names its meshes in text. So a mesh of Python is kept here under a name as long as a call needs it, and the generator
//! `in_memory` gives it to the pipeline. Results are taken by the format `in_memory`, whose file is empty.

use std::{
    collections::HashMap,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
};

use mimesh_core::{
    Error, Result,
    mesh::{ClipTime, Mesh, MeshSequence},
    register,
    stage::{
        FileInput, Format, Generator, MeshWriter, Selection, SequenceFile, SequenceFormat, SequenceWriter, WriteError,
    },
};
use nalgebra::Point3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

register!(Generator: InMemory);
register!(Format: InMemoryResult);

/// Poses that a run gave.
#[derive(Debug, Default)]
pub struct Collected {
    /// Their names.
    pub names: Vec<String>,
    /// Their times in clips.
    pub times: Vec<Option<ClipTime>>,
    /// Their positions, one pose after the other.
    pub positions: Vec<f64>,
}

/// What is kept for calls under way.
#[derive(Debug, Default)]
struct Kept {
    meshes: HashMap<String, (usize, Arc<MeshSequence>)>,
    results: HashMap<u64, Collected>,
}

static KEPT: Mutex<Option<Kept>> = Mutex::new(None);

fn with_kept<T>(act: impl FnOnce(&mut Kept) -> T) -> T {
    let mut kept: MutexGuard<'_, Option<Kept>> = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    act(kept.get_or_insert_with(Kept::default))
}

/// Keeps a mesh for pipelines until it is dropped.
pub struct KeptMesh {
    name: String,
}

impl KeptMesh {
    /// Keeps `mesh` under `name`, which stands for its content.
    pub fn new(name: &str, mesh: Arc<MeshSequence>) -> Self {
        with_kept(|kept| kept.meshes.entry(name.into()).or_insert((0, mesh)).0 += 1);
        Self { name: name.into() }
    }
}

impl Drop for KeptMesh {
    fn drop(&mut self) {
        with_kept(|kept| {
            if let Some((users, _)) = kept.meshes.get_mut(&self.name) {
                *users -= 1;
                if *users == 0 {
                    kept.meshes.remove(&self.name);
                }
            }
        });
    }
}

/// Collects the results of one call until it is dropped.
pub struct Collector {
    /// The number of the call, which the settings of the format name.
    pub call: u64,
}

impl Collector {
    /// A collector of its own.
    pub fn new() -> Self {
        static CALLS: AtomicU64 = AtomicU64::new(1);
        let call = CALLS.fetch_add(1, Ordering::Relaxed);
        with_kept(|kept| kept.results.insert(call, Collected::default()));
        Self { call }
    }

    /// What was collected.
    pub fn take(self) -> Collected {
        with_kept(|kept| kept.results.remove(&self.call)).unwrap_or_default()
    }
}

impl Drop for Collector {
    fn drop(&mut self) {
        with_kept(|kept| kept.results.remove(&self.call));
    }
}

/// A mesh of Python's memory; calls of the package fill it in.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct InMemory {
    /// The name that stands for the content of the mesh.
    pub content: String,
    /// Whether its poses are left out, as those of a target are.
    pub at_rest: bool,
}

#[typetag::serde(name = "in_memory")]
impl Generator for InMemory {
    fn make(&self) -> Result<MeshSequence> {
        let found = with_kept(|kept| kept.meshes.get(&self.content).map(|(_, mesh)| mesh.clone()));
        let mesh = found.ok_or_else(|| {
            Error::data("a mesh of another call's memory", "give the mesh itself, or save it to a file and name that")
        })?;
        let mut mesh = MeshSequence::clone(&mesh);
        if self.at_rest {
            mesh.poses.clear();
        }
        Ok(mesh)
    }
}

/// Results that stay in Python's memory; calls of the package fill it in.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct InMemoryResult {
    /// The number of the call.
    pub call: u64,
}

/// The ending of files that stand for results in memory.
pub const EXTENSION: &str = "mimesh-in-memory";

#[typetag::serde(name = "in_memory")]
impl Format for InMemoryResult {
    fn extensions(&self) -> &'static [&'static str] {
        &[EXTENSION]
    }

    fn read(&self, input: &dyn FileInput, _: &Selection) -> Result<MeshSequence> {
        Err(Error::file(input.path(), "the result was kept in memory alone", "save it in another format"))
    }

    fn reads(&self) -> bool {
        false
    }

    fn writer(&self) -> Option<MeshWriter<'_>> {
        // Of no call there is nobody to take the results.
        (self.call > 0).then_some(MeshWriter::Sequence(self))
    }
}

impl SequenceFormat for InMemoryResult {
    fn start(
        &self,
        mesh: &Mesh,
        poses: usize,
        _: Box<dyn SequenceFile>,
    ) -> Result<Box<dyn SequenceWriter>, WriteError> {
        with_kept(|kept| {
            if let Some(collected) = kept.results.get_mut(&self.call) {
                *collected = Collected::default();
                collected.positions.reserve_exact(poses * mesh.positions.len() * 3);
            }
        });
        Ok(Box::new(Writer { call: self.call }))
    }
}

struct Writer {
    call: u64,
}

impl SequenceWriter for Writer {
    fn add(&mut self, name: &str, time: Option<&ClipTime>, positions: &[Point3<f64>]) -> Result<(), WriteError> {
        with_kept(|kept| {
            if let Some(collected) = kept.results.get_mut(&self.call) {
                collected.names.push(name.into());
                collected.times.push(time.cloned());
                collected.positions.extend(positions.iter().flat_map(|p| [p.x, p.y, p.z]));
            }
        });
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), WriteError> {
        Ok(())
    }
}
