//! Masks in files, as the studio paints them.

use std::path::Path;

use mimesh_document::files::read_text;
use serde::Deserialize;

/// What the file of a mask holds; the mesh that it was painted on is for people.
#[derive(Deserialize)]
struct MaskFile {
    weights: Option<Vec<f64>>,
}

/// The weights in `file`, 0 to 1, for the `count` vertices of the target's file.
///
/// # Errors
///
/// What is wrong, and a way out: for a file that cannot be read, another number of weights, and weights out of range.
pub fn read_mask(file: &Path, count: usize) -> Result<Vec<f64>, (String, String)> {
    let at = file.display();
    let hint = || "paint it in the studio, or write { \"weights\": [ … ] } with one number for each vertex".to_owned();
    let text =
        read_text(file).map_err(|problem| (format!("{at}: {}", problem.message), problem.hint.unwrap_or_else(hint)))?;
    let MaskFile { weights } = serde_json::from_str(&text).map_err(|error| (format!("{at}: {error}"), hint()))?;
    let weights = weights.ok_or_else(|| (format!("{at} has no `weights`"), hint()))?;
    if weights.len() != count {
        let message = format!("{at} has {} weights, the target has {count} vertices", weights.len());
        return Err((message, "was it painted on another mesh? Paint it anew".into()));
    }
    match weights.iter().position(|weight| !(0.0..=1.0).contains(weight)) {
        Some(v) => Err((format!("{at}: the weight of vertex {v} is {}, expected 0 to 1", weights[v]), hint())),
        None => Ok(weights),
    }
}
