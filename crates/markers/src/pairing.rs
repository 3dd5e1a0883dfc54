//! Pairing the points of two files.

use std::collections::HashMap;

use mimesh_document::{Diagnostic, Diagnostics, Kind, Location, Result, suggest::did_you_mean};

use crate::points::PointFile;

/// Points named in a warning about many of them.
pub const MAX_NAMED: usize = 6;

/// The numbers of the points that belong together, and how they were found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Paired {
    /// The numbers in both files.
    pub pairs: Vec<[usize; 2]>,
    /// Whether points without names were paired by their order.
    pub by_order: bool,
}

/// The numbers of the points that belong together: by name where both files share names, else by order. Sentences about
/// points without a partner are added to `warnings`.
///
/// # Errors
///
/// If a name comes twice in a file, or no name is shared and the files have different numbers of points.
pub fn pair(files: &[PointFile; 2], warnings: &mut Vec<String>) -> Result<Paired> {
    let duplicates: Vec<Diagnostic> = files.iter().flat_map(PointFile::duplicate_names).collect();
    Diagnostics::from(duplicates).into_result()?;
    let pairs = by_name(files);
    if pairs.is_empty() {
        return by_order(files, warnings);
    }
    for k in 0..2 {
        let paired: Vec<[usize; 2]> = pairs.iter().map(|pair| [pair[k], pair[1 - k]]).collect();
        warnings.extend(unpaired(&files[k], &files[1 - k], &paired));
    }
    Ok(Paired { pairs, by_order: false })
}

fn by_name([source, target]: &[PointFile; 2]) -> Vec<[usize; 2]> {
    let targets: HashMap<&str, usize> =
        target.points.iter().zip(0..).filter_map(|(point, i)| Some((point.name.as_deref()?, i))).collect();
    let partner = |i: usize| Some([i, *targets.get(source.points[i].name.as_deref()?)?]);
    (0..source.points.len()).filter_map(partner).collect()
}

fn by_order([source, target]: &[PointFile; 2], warnings: &mut Vec<String>) -> Result<Paired> {
    let (source_file, target_file) = (source.file.display(), target.file.display());
    let counts = [source.points.len(), target.points.len()];
    if counts[0] != counts[1] {
        let message = format!(
            "the points cannot be paired: no name is on both sides, and {source_file} has {}, {target_file} {}",
            counts[0], counts[1]
        );
        let diagnostic = Diagnostic::new(Kind::BadData, message).at(Location::File(source.file.clone()));
        return Err(diagnostic.hint("call partners alike, or bring as many points in the same order").into());
    }
    let are_named = [source, target].into_iter().all(|file| file.points.iter().any(|point| point.name.is_some()));
    if are_named {
        warnings.push(format!("{source_file}: no name is also in {target_file}; the points are paired by order"));
    }
    Ok(Paired { pairs: (0..counts[0]).map(|i| [i, i]).collect(), by_order: !are_named })
}

/// A sentence about the points of `file` that have no partner in `other`; `paired` holds the numbers in `file` and `other`.
fn unpaired(file: &PointFile, other: &PointFile, paired: &[[usize; 2]]) -> Option<String> {
    let alone: Vec<usize> = (0..file.points.len()).filter(|i| paired.iter().all(|pair| pair[0] != *i)).collect();
    let first = *alone.first()?;
    let names: Vec<_> = alone.iter().take(MAX_NAMED).map(|&i| file.name(i)).collect();
    let more = if alone.len() > names.len() { ", …" } else { "" };
    let free: Vec<&str> = (0..other.points.len())
        .filter(|i| paired.iter().all(|pair| pair[1] != *i))
        .filter_map(|i| other.points[i].name.as_deref())
        .collect();
    let suggestion = file.points[first].name.as_deref().and_then(|name| did_you_mean(name, &free));
    let suggestion = suggestion.map_or(String::new(), |suggestion| format!("; {}: {suggestion}", names[0]));
    Some(format!(
        "{}: {} without a partner of that name are left out: {}{more}{suggestion}",
        file.file.display(),
        alone.len(),
        names.join(", ")
    ))
}
