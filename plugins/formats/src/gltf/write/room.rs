//! The room that the JSON of a GLB will take, before all poses are there.

use std::io;

use serde::Serialize;

use super::{binary::Binary, output::glb_head};

/// The JSON of one more target in a primitive, e.g. `{"POSITION":12345,"NORMAL":12346},`.
const TARGET: usize = 48;

/// What is known of the JSON of a glTF in the making.
pub struct Known<'a> {
    /// Poses that are in it.
    pub names: &'a [String],
    /// Poses that will be in it at most.
    pub poses: usize,
    /// The primitives that a pose moves.
    pub primitives: usize,
    /// The meshes that have names of targets.
    pub meshes: usize,
    /// Bytes of JSON beside views, accessors and targets.
    pub other: usize,
}

/// Puts what is held of `binary` into the file, behind room for the JSON of all poses.
///
/// # Errors
///
/// Those of the file.
pub fn leave(binary: &mut Binary, known: &Known<'_>) -> io::Result<()> {
    let so_far = json_length(&binary.views)? + json_length(&binary.accessors)?;
    let names: usize = known.names.iter().map(|name| name.len() + 4).sum();
    let a_pose = (so_far + known.meshes * names).div_ceil(known.names.len().max(1)) + known.primitives * TARGET;
    // A tenth more for numbers that grow longer, and a little for animations.
    let json = known.other + a_pose * known.poses.max(known.names.len()) * 11 / 10 + 4096;
    binary.tail.leave_room(glb_head(json as u64))
}

/// The bytes of `value` as JSON.
///
/// # Errors
///
/// Those of its serialization.
pub fn json_length(value: &impl Serialize) -> io::Result<usize> {
    Ok(serde_json::to_vec(value)?.len())
}
