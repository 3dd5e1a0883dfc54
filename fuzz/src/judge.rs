//! What a reader of meshes promises.

use mimesh_core::{
    Error,
    mesh::{CornerAttribute, Mesh, MeshSequence, Statistics, check_finite},
    plugin::instances,
    stage::{BytesInput, ClipChoice, Format, MeshWriter, PoseChoice, Selection},
    testkit::memory_file::MemoryFile,
};
use nalgebra::Point3;

/// Poses of a file that are looked at.
const MAX_POSES: usize = 3;

/// Larger meshes are not written again.
const MAX_WRITTEN: usize = 20_000;

/// Formats of 32-bit numbers round to this part of the largest coordinate; a little more for sums of them.
const ROUNDING: f64 = 1e-6;

/// The smallest 32-bit number: below some 1e-38 numbers lie as far apart, however small they are.
const SMALLEST: f64 = 1.5e-45;

/// Reads `bytes` as a file with the extension `name`.
///
/// # Errors
///
/// The promise that was broken.
pub fn mesh(name: &str, bytes: &[u8]) -> Result<String, String> {
    let formats = instances::<dyn Format>();
    let format = formats.iter().find(|(_, format)| format.extensions().contains(&name));
    let (_, format) = format.ok_or("no such format")?;
    let input = BytesInput::new(format!("fuzz.{name}"), bytes);
    let keep = Selection { keep_document: true, ..Selection::default() };
    let clips = Selection { poses: PoseChoice::Clips(ClipChoice::default()), ..Selection::default() };
    let outcome = match format.read(&input, &keep) {
        Err(error) => return told(&error),
        Ok(sequence) => {
            sound(&**format, &sequence)?;
            again(&**format, name, &sequence)?;
            sequence.warnings.join("; ")
        }
    };
    if format.holds_poses() {
        match format.read(&input, &clips) {
            Err(error) => _ = told(&error)?,
            Ok(sequence) => sound(&**format, &sequence)?,
        }
        _ = format.read_points(&input).map_err(|error| told(&error));
    }
    Ok(format!("read; {outcome}"))
}

/// Checks that an error names the file and a way out; gives it without what may differ.
fn told(error: &Error) -> Result<String, String> {
    let text = error.to_string();
    let has_way_out = error.hint().is_some() || matches!(error, Error::Io { .. } | Error::OutOfReach { .. });
    if !has_way_out {
        return Err(format!("an error without a way out: {text}"));
    }
    if !text.contains("fuzz") && !matches!(error, Error::Io { .. }) {
        return Err(format!("an error that does not name the file: {text}"));
    }
    if text.len() > 3000 {
        return Err(format!("an error of {} bytes: {:.200}", text.len(), text));
    }
    Ok(text)
}

/// Checks that numbers are finite and indices in range.
fn sound(format: &dyn Format, sequence: &MeshSequence) -> Result<(), String> {
    let MeshSequence { rest, poses, warnings, .. } = sequence;
    check_finite(&rest.positions).map_err(|error| format!("rest: {error}"))?;
    if format.holds_faces() {
        rest.validate().map_err(|error| format!("rest: {error}"))?;
        let statistics = Statistics::new(rest).map_err(|error| format!("statistics: {error}"))?;
        let numbers = [statistics.diagonal, statistics.area, statistics.volume.unwrap_or(0.0)];
        if !numbers.iter().all(|x| x.is_finite()) {
            return Err(format!("statistics are not finite: {numbers:?}"));
        }
    }
    attribute("texture coordinates", rest, rest.texture_coordinates.as_ref())?;
    attribute("normals", rest, rest.normals.as_ref())?;
    if rest.vertex_colors.as_ref().is_some_and(|colors| colors.len() != rest.positions.len()) {
        return Err("colours of another number of vertices".into());
    }
    if rest.vertex_colors.iter().flatten().flatten().any(|x| !(0.0..=1.0).contains(x)) {
        return Err("colours beyond 0 to 1".into());
    }
    for pose in poses.iter().take(MAX_POSES) {
        match pose.positions.get() {
            Ok(positions) if positions.len() != rest.positions.len() => {
                return Err(format!("pose `{}` of another size", pose.name));
            }
            Ok(positions) => check_finite(&positions).map_err(|error| format!("pose `{}`: {error}", pose.name))?,
            Err(error) if error.hint().is_none() => return Err(format!("pose `{}`: no way out: {error}", pose.name)),
            Err(_) => {}
        }
    }
    match warnings.iter().find(|warning| warning.len() > 4000) {
        Some(warning) => Err(format!("a warning of {} bytes: {:.200}", warning.len(), warning)),
        None => Ok(()),
    }
}

fn attribute<const N: usize>(
    what: &str,
    mesh: &Mesh,
    attribute: Option<&CornerAttribute<[f64; N]>>,
) -> Result<(), String> {
    let Some(CornerAttribute { values, indices }) = attribute else { return Ok(()) };
    if indices.len() != mesh.polygons.corner_count() {
        return Err(format!("{what} of {} corners, there are {}", indices.len(), mesh.polygons.corner_count()));
    }
    if indices.iter().flatten().any(|&index| index as usize >= values.len()) {
        return Err(format!("{what} out of range"));
    }
    if values.as_flattened().iter().all(|x| x.is_finite()) {
        Ok(())
    } else {
        Err(format!("{what} that are not finite"))
    }
}

/// Checks that what was read is written, and read again as it was.
fn again(format: &dyn Format, name: &str, sequence: &MeshSequence) -> Result<(), String> {
    let mesh = &sequence.rest;
    let (count, largest) = (mesh.positions.len(), mesh.positions.iter().map(|p| p.coords.amax()).fold(0.0, f64::max));
    // Of what a format writes as 32-bit numbers the very large is refused, as it says.
    if count == 0 || count > MAX_WRITTEN || largest > 1e30 {
        return Ok(());
    }
    let bytes = match format.writer() {
        None => return Ok(()),
        Some(MeshWriter::Pose(writer)) => {
            let mut bytes = Vec::new();
            writer
                .write(mesh, &mesh.positions, &mut bytes)
                .map_err(|error| format!("what was read is not written: {error}"))?;
            bytes
        }
        Some(MeshWriter::Sequence(writer)) => {
            let file = MemoryFile::default();
            let written = writer.start(mesh, 1, Box::new(file.clone())).and_then(|mut writer| {
                writer.add("pose", None, &mesh.positions)?;
                writer.finish()
            });
            written.map_err(|error| format!("what was read is not written: {error}"))?;
            file.bytes()
        }
    };
    let back = format.read(&BytesInput::new(format!("fuzz.{name}"), bytes), &Selection::default());
    let back = back.map_err(|error| format!("what was written is not read: {error}"))?.rest;
    let corners = |mesh: &Mesh| -> Vec<Point3<f64>> {
        if format.holds_faces() {
            mesh.polygons.corners().iter().map(|&v| mesh.positions[v as usize]).collect()
        } else {
            mesh.positions.clone()
        }
    };
    // A format of triangles cuts polygons, and joins vertices.
    if !format.keeps_vertices() && mesh.polygons.iter().any(|corners| corners.len() > 3) {
        return Ok(());
    }
    if format.keeps_vertices() && format.holds_faces() && back.polygons != mesh.polygons {
        return Err("other polygons after writing and reading".into());
    }
    let (old, new) = (corners(mesh), corners(&back));
    if old.len() != new.len() {
        return Err(format!("{} corners after writing and reading, there were {}", new.len(), old.len()));
    }
    let far = old.iter().zip(&new).map(|(old, new)| (old - new).amax()).fold(0.0, f64::max);
    if far > ROUNDING * largest + SMALLEST {
        Err(format!("{far:e} away after writing and reading, of {largest:e}"))
    } else {
        Ok(())
    }
}
