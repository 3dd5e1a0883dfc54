//! An FBX as `ufbx` reads it, and its unit and axes.

use mimesh_core::{Error, Result, stage::FileInput};
use nalgebra::{Matrix4, Vector3};
use ufbx::{AllocatorOpts, CoordinateAxes, CoordinateAxis, ErrorType, FileFormat, LoadOpts, SceneRoot, SceneSettings};

/// The way out of a file that cannot be read.
pub const DAMAGED: &str = "the file is damaged or of a program that writes FBX in its own way: export it again";

/// What a file becomes takes no more memory than so many times its bytes; compressed files grow by ten to fifty.
const MAX_GROWTH: usize = 256;

/// Whatever its bytes, a file may take so much memory.
const MIN_MEMORY: usize = 1 << 27;

/// Reads the scene of a file, with its images if `images`; nothing else is opened.
///
/// # Errors
///
/// [`Error::Io`] for a file that cannot be read, [`Error::File`] for one that is damaged or no FBX.
pub fn read(input: &dyn FileInput, images: bool) -> Result<SceneRoot> {
    let bytes = input.contents()?;
    // Compressed arrays must not ask for all memory.
    let memory_limit = bytes.len().saturating_mul(MAX_GROWTH).max(MIN_MEMORY);
    let limited = || AllocatorOpts { memory_limit, ..AllocatorOpts::default() };
    let options = LoadOpts {
        ignore_embedded: !images,
        file_format: FileFormat::Fbx,
        temp_allocator: limited(),
        result_allocator: limited(),
        ..LoadOpts::default()
    };
    ufbx::load_memory(&bytes, options).map_err(|error| {
        let details = error.info();
        let details = if details.is_empty() { String::new() } else { format!(": {details}") };
        let found = match &bytes[..] {
            [] => "the file is empty".to_owned(),
            start => {
                let start = &start[..start.len().min(16)];
                format!("{} bytes that begin with `{}`", bytes.len(), start.escape_ascii())
            }
        };
        let message = match error.type_ {
            ErrorType::EmptyFile | ErrorType::UnrecognizedFileFormat => {
                format!("not an FBX: expected `Kaydara FBX Binary` or `; FBX` at its start, found {found}")
            }
            _ => format!("not an FBX that can be read: {}{details}, in {} bytes", error.description, bytes.len()),
        };
        let hint = match error.type_ {
            ErrorType::UnsupportedVersion => "save it as FBX 2020 (7.7) or earlier, binary or ASCII",
            ErrorType::MemoryLimit => "its contents are far larger than the file: export it again, without compression",
            _ => DAMAGED,
        };
        Error::file(input.path(), message, hint)
    })
}

/// What the reader left out or corrected, as sentences.
pub fn warnings(scene: &ufbx::Scene) -> Vec<String> {
    let times = |count: usize| if count > 1 { format!(" ({count} times)") } else { String::new() };
    let all = scene.metadata.warnings.iter();
    all.map(|warning| format!("the file is not clean: {}{}", warning.description, times(warning.count))).collect()
}

/// The matrix from the file's unit and axes to metres with X to the right of who looks at the front, Y up and Z to the front.
pub fn to_metres(settings: &SceneSettings) -> Matrix4<f64> {
    let CoordinateAxes { right, up, front } = settings.axes;
    let mut matrix = Matrix4::identity();
    if let (Some(right), Some(up), Some(front)) = (direction(right), direction(up), direction(front)) {
        for (row, axis) in [right, up, front].into_iter().enumerate() {
            matrix.fixed_view_mut::<1, 3>(row, 0).copy_from(&(axis * metres(settings)).transpose());
        }
    } else {
        matrix *= metres(settings);
        matrix[(3, 3)] = 1.0;
    }
    matrix
}

/// How the file differs from metres with Y up, as a sentence.
pub fn unit_and_axes(settings: &SceneSettings) -> Option<String> {
    let is_upright = to_metres(settings).fixed_view::<3, 3>(0, 0).is_identity(1e-12);
    let unit = match metres(settings) {
        0.01 => "centimetres".to_owned(),
        0.001 => "millimetres".to_owned(),
        1.0 => "metres".to_owned(),
        metres => format!("units of {metres} m"),
    };
    let up = match settings.axes.up {
        CoordinateAxis::PositiveX => "X up",
        CoordinateAxis::NegativeX => "X down",
        CoordinateAxis::NegativeY => "Y down",
        CoordinateAxis::PositiveZ => "Z up",
        CoordinateAxis::NegativeZ => "Z down",
        CoordinateAxis::PositiveY | CoordinateAxis::Unknown => "Y up",
    };
    (!is_upright).then(|| format!("the file is in {unit} with {up}: it is read in metres with Y up"))
}

/// Metres a unit of the file; centimetres, which FBX means by itself, where the file's number is none.
fn metres(settings: &SceneSettings) -> f64 {
    let metres = settings.unit_meters;
    // The file holds centimetres a unit, so that 0.01 of them is not the nearest number to a metre's part.
    let known = [1.0, 0.1, 0.01, 0.001, 0.0254, 0.3048];
    let near = known.into_iter().find(|known| (metres / known - 1.0).abs() < 1e-9);
    near.unwrap_or(if metres > 0.0 && metres.is_finite() { metres } else { 0.01 })
}

fn direction(axis: CoordinateAxis) -> Option<Vector3<f64>> {
    Some(match axis {
        CoordinateAxis::PositiveX => Vector3::x(),
        CoordinateAxis::NegativeX => -Vector3::x(),
        CoordinateAxis::PositiveY => Vector3::y(),
        CoordinateAxis::NegativeY => -Vector3::y(),
        CoordinateAxis::PositiveZ => Vector3::z(),
        CoordinateAxis::NegativeZ => -Vector3::z(),
        CoordinateAxis::Unknown => return None,
    })
}

/// A matrix of `ufbx`, with its last row.
pub fn matrix(m: &ufbx::Matrix) -> Matrix4<f64> {
    Matrix4::new(
        m.m00, m.m01, m.m02, m.m03, //
        m.m10, m.m11, m.m12, m.m13, //
        m.m20, m.m21, m.m22, m.m23, //
        0.0, 0.0, 0.0, 1.0,
    )
}
