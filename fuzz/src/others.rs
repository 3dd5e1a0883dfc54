//! What readers of markers, pipelines and cached results promise.

use std::{fs, path::Path};

use mimesh_core::stage::{Proposal, ProximityGraph, TriangleMap};
use mimesh_markers::{PointPosition, formats, read};
use mimesh_pipeline::{
    Options,
    cache::{CacheCodec, OpenedSeams, PosedTarget, TransferSummary},
    compose, prepare_all,
};

/// Reads `bytes` as the points of one mesh in a file with the extension `name`.
///
/// # Errors
///
/// The promise that was broken.
pub fn points(name: &str, bytes: &[u8]) -> Result<String, String> {
    let (file, text) = (format!("fuzz.{name}"), String::from_utf8_lossy(bytes));
    match read::parse_points(Path::new(&file), &text) {
        Err(error) => told(&error.to_string()),
        Ok(read) => {
            let positions = read.points.iter().filter_map(|point| match &point.position {
                PointPosition::InSpace(position) => Some(position),
                _ => None,
            });
            let is_sound = positions.flat_map(|position| position.iter()).all(|x| x.is_finite());
            if is_sound {
                Ok(format!("read; {}", read.warnings.join("; ")))
            } else {
                Err("a point that is not finite".into())
            }
        }
    }
}

/// Reads `bytes` as pairs in a file with the extension `name`; what is written is read again as it was.
///
/// # Errors
///
/// The promise that was broken.
pub fn pairs(name: &str, bytes: &[u8]) -> Result<String, String> {
    let (file, text) = (format!("fuzz.{name}"), String::from_utf8_lossy(bytes));
    let file = Path::new(&file);
    let parse =
        |text: &str| if name == "cons" { formats::cons::parse(file, text) } else { formats::yaml::parse(file, text) };
    let markers = match parse(&text) {
        Err(error) => return told(&error.to_string()),
        Ok(markers) => markers,
    };
    if name == "yaml" {
        let mut back =
            parse(&formats::yaml::write(&markers)).map_err(|error| format!("what was written is not read: {error}"))?;
        let mut read = markers;
        let places = back.pairs.iter_mut().chain(&mut read.pairs);
        places.for_each(|pair| pair.location = None);
        if back != read {
            return Err("other markers after writing and reading".into());
        }
    }
    Ok("read".into())
}

/// Checks a pipeline in a folder of its own, where it may include `part.yaml`: what follows a line `# part.yaml`.
///
/// # Errors
///
/// The promise that was broken.
pub fn pipeline(_: &str, bytes: &[u8]) -> Result<String, String> {
    let text = String::from_utf8_lossy(bytes);
    let (text, part) = text.split_once("# part.yaml\n").unwrap_or((&text, ""));
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let file = folder.path().join("fuzz.yaml");
    let written = fs::write(&file, text).and_then(|()| fs::write(folder.path().join("part.yaml"), part));
    written.map_err(|error| error.to_string())?;
    // The folder has another name each time.
    let tell = |error: String| told(&error.replace(&*folder.path().to_string_lossy(), ""));
    if let Err(error) = compose::compose(&file, &[]) {
        return tell(error.to_string());
    }
    // Meshes of any size may be generated, if the user asks for them.
    if text.contains("generator") || part.contains("generator") {
        return Ok("composed".into());
    }
    match prepare_all(&file, &Options::default(), None) {
        Ok(_) => Ok("checked".into()),
        Err(error) => tell(error.to_string()),
    }
}

/// Checks that the text of errors is short, and names the file.
fn told(text: &str) -> Result<String, String> {
    let first = text.lines().next().unwrap_or_default();
    if !text.contains("fuzz.") && !text.contains("part.yaml") {
        return Err(format!("an error that does not name the file: {first}"));
    }
    if first.len() > 3000 { Err(format!("an error of {} bytes: {first:.200}", first.len())) } else { Ok(first.into()) }
}

/// Decodes `bytes` as each kind of cached results; what is decoded is encoded and decoded as it was.
///
/// # Errors
///
/// The promise that was broken.
pub fn cache(_: &str, bytes: &[u8]) -> Result<String, String> {
    let mut found = String::new();
    let mut kinds = [
        ("posed", stays::<PosedTarget>(bytes)),
        ("seams", stays::<OpenedSeams>(bytes)),
        ("summary", stays::<TransferSummary>(bytes)),
        ("map", stays::<TriangleMap>(bytes)),
        ("graph", stays::<ProximityGraph>(bytes)),
        ("proposal", stays::<Proposal>(bytes)),
    ];
    for (kind, outcome) in &mut kinds {
        match outcome {
            Some(true) => found += kind,
            Some(false) => return Err(format!("a cached {kind} changes when it is encoded again")),
            None => {}
        }
    }
    Ok(found)
}

/// Whether what `bytes` hold stays the same from then on; `None` if they hold no `T`.
fn stays<T: CacheCodec>(bytes: &[u8]) -> Option<bool> {
    let encoded = T::decode(bytes)?.encode();
    Some(T::decode(&encoded).is_some_and(|again| again.encode() == encoded))
}
