//! Markers as they are given: one file with both sides, or a file of points for each mesh, which are paired here.

use std::{collections::HashMap, path::PathBuf};

use nalgebra::Point3;

use super::{
    Entry, MarkerFile, MarkerFiles, MeshReference, Side,
    attach::{self, Attached, Attacher},
    points::{self, PointFile, Spot},
    usual::{self, Usual},
};
use crate::{
    diagnostic::Kind,
    diagnostic::{Diagnostic, Diagnostics, Location, Result},
    pipeline::words::did_you_mean,
};

/// What files of markers say, before the meshes are looked at.
#[derive(Clone, Debug)]
pub enum Given {
    /// Pairs, from one file.
    Both(MarkerFile),
    /// The points of the source and those of the target.
    Sides([PointFile; 2]),
}

/// Markers on their meshes, and how they got there.
#[derive(Clone, Debug, Default)]
pub struct OnMeshes {
    /// The markers.
    pub markers: MarkerFile,
    /// Of the source and the target: the names of points given by position with their distances off the surface, relative
    /// to the diagonal.
    pub distances: [Vec<(String, f64)>; 2],
    /// What was done to positions of source and target before.
    pub usual: [Option<Usual>; 2],
    /// Sentences about what was left out or looks wrong.
    pub warnings: Vec<String>,
}

/// Reads the files.
///
/// # Errors
///
/// All that is wrong with them.
pub fn read(files: &MarkerFiles) -> Result<Given> {
    match files {
        MarkerFiles::One(file) => super::read(file).map(Given::Both),
        MarkerFiles::Pair { source, target } => match (points::read(source), points::read(target)) {
            (Ok(source), Ok(target)) => Ok(Given::Sides([source, target])),
            (source, target) => {
                let failures = [source.err(), target.err()].into_iter().flatten();
                Err(Diagnostics { diagnostics: failures.flat_map(|failure| failure.diagnostics).collect() })
            }
        },
    }
}

impl Given {
    /// The markers on the meshes; with `fit`, positions in another usual unit or with other axes are brought to the mesh.
    ///
    /// # Errors
    ///
    /// Points that are not on their mesh, and sides that cannot be paired.
    pub fn on(self, source: Side<'_>, target: Side<'_>, fit: bool) -> Result<OnMeshes> {
        let files = match self {
            Self::Both(markers) => return Ok(OnMeshes { markers, ..OnMeshes::default() }),
            Self::Sides(files) => files,
        };
        let mut result = OnMeshes::default();
        result.warnings.extend(files.iter().flat_map(|file| file.warnings.clone()));
        let attachers = [Attacher::new(source)?, Attacher::new(target)?];
        let mut diagnostics = Vec::new();
        let mut attached: [Vec<Attached>; 2] = [vec![], vec![]];
        for k in 0..2 {
            let positions = attach::positions(&files[k]);
            let usual = if fit { usual::fitting(&attachers[k], &positions) } else { None };
            result.usual[k] = usual.filter(|usual| *usual != Usual::NOTHING);
            match attach::attach(&files[k], &attachers[k], usual.unwrap_or(Usual::NOTHING)) {
                Ok(points) => attached[k] = points,
                Err(failure) => diagnostics.extend(failure.diagnostics),
            }
            let by_position = files[k].points.iter().enumerate().zip(&attached[k]);
            let by_position = by_position.filter(|((_, point), _)| matches!(point.spot, Spot::Position(_)));
            result.distances[k] = by_position.map(|((i, point), a)| (attach::label(i, point), a.distance)).collect();
        }
        if !diagnostics.is_empty() {
            return Err(exchanged(&files, [&attachers[1], &attachers[0]])
                .map_or(Diagnostics { diagnostics }, Diagnostics::from));
        }
        let pairs = pair(&files, &mut result.warnings)?;
        let entry = |[s, t]: [usize; 2]| {
            let points = [attached[0][s].point, attached[1][t].point];
            let at: [Option<Point3<f64>>; 2] = [0, 1].map(|k| Some(attachers[k].position(points[k])));
            let name = files[0].points[s].name.clone().or_else(|| files[1].points[t].name.clone());
            let location = Some(files[0].points[s].location.clone());
            Entry { name, at, location, ..Entry::new(points[0], points[1]) }
        };
        result.markers.entries = pairs.into_iter().map(entry).collect();
        Ok(result)
    }
}

impl OnMeshes {
    /// A sentence a side on points that lie off the surface by more than 1 % of the diagonal.
    pub fn doubts(&self) -> Vec<String> {
        let mut sentences = Vec::new();
        for (side, distances) in ["source", "target"].into_iter().zip(&self.distances) {
            let off = distances.iter().filter(|(_, distance)| *distance > 0.01).count();
            let farthest = distances.iter().max_by(|a, b| a.1.total_cmp(&b.1));
            if let (Some((name, distance)), 1..) = (farthest, off) {
                sentences.push(format!(
                    "{off} of {} points given by position lie more than 1 % of the diagonal off the {side}, {name} by {:.1} %",
                    distances.len(),
                    100.0 * distance
                ));
            }
        }
        sentences
    }

    /// Notes where the points are and which meshes they are on, so that they are found again after an edit.
    pub fn remember(&mut self, source: Side<'_>, target: Side<'_>, files: [Option<&PathBuf>; 2]) -> Result<()> {
        remember(&mut self.markers, source, target, files)
    }
}

/// Notes in `markers` where the points are and which meshes they are on.
///
/// # Errors
///
/// As [`Attacher::new`].
pub fn remember(
    markers: &mut MarkerFile,
    source: Side<'_>,
    target: Side<'_>,
    files: [Option<&PathBuf>; 2],
) -> Result<()> {
    for (k, side) in [source, target].into_iter().enumerate() {
        let attacher = Attacher::new(side)?;
        for entry in &mut markers.entries {
            entry.at[k] = entry.of(side.name).map(|point| attacher.position(point));
        }
        let reference = Some(MeshReference::new(files[k].map(PathBuf::as_path), side));
        *(if k == 0 { &mut markers.source } else { &mut markers.target }) = reference;
    }
    Ok(())
}

/// That the two files fit with source and target exchanged, where they do not fit as they are.
fn exchanged(files: &[PointFile; 2], others: [&Attacher<'_>; 2]) -> Option<Diagnostic> {
    let fits = |k: usize| attach::attach(&files[k], others[k], Usual::NOTHING).is_ok();
    if !(fits(0) && fits(1)) {
        return None;
    }
    let message = format!(
        "the points of {} lie on the target, and those of {} on the source",
        files[0].file.display(),
        files[1].file.display()
    );
    Some(
        Diagnostic::new(Kind::BadData, message)
            .at(Location::File(files[0].file.clone()))
            .hint("exchange the two files, or `source` and `target`"),
    )
}

/// The numbers of the points that belong together: by name where both sides share names, else by order.
fn pair(files: &[PointFile; 2], warnings: &mut Vec<String>) -> Result<Vec<[usize; 2]>> {
    let [source, target] = files;
    let by_name: HashMap<&str, usize> =
        target.points.iter().enumerate().filter_map(|(i, point)| Some((point.name.as_deref()?, i))).collect();
    if let Some(diagnostic) = files.iter().find_map(twice) {
        return Err(diagnostic.into());
    }
    let partner = |(i, point): (usize, &points::NamedPoint)| Some([i, *by_name.get(point.name.as_deref()?)?]);
    let pairs: Vec<[usize; 2]> = source.points.iter().enumerate().filter_map(partner).collect();
    let counts = [source.points.len(), target.points.len()];
    if pairs.is_empty() {
        if counts[0] != counts[1] {
            let message = format!(
                "the points cannot be paired: no name is on both sides, and {} has {}, {} {}",
                source.file.display(),
                counts[0],
                target.file.display(),
                counts[1]
            );
            let hint = "call partners alike, or bring as many points in the same order";
            return Err(Diagnostic::new(Kind::BadData, message)
                .at(Location::File(source.file.clone()))
                .hint(hint)
                .into());
        }
        if files.iter().all(|file| file.points.iter().any(|point| point.name.is_some())) {
            warnings.push(format!(
                "{}: no name is also in {}; the points are paired by order",
                source.file.display(),
                target.file.display()
            ));
        }
        return Ok((0..counts[0]).map(|i| [i, i]).collect());
    }
    for (k, (file, other)) in [(source, target), (target, source)].into_iter().enumerate() {
        let alone: Vec<usize> = (0..file.points.len()).filter(|i| pairs.iter().all(|pair| pair[k] != *i)).collect();
        let Some(&first) = alone.first() else { continue };
        let names: Vec<_> = alone.iter().take(6).map(|&i| attach::label(i, &file.points[i])).collect();
        let more = if alone.len() > names.len() { ", …" } else { "" };
        let free: Vec<&str> = other
            .points
            .iter()
            .enumerate()
            .filter(|(i, _)| pairs.iter().all(|pair| pair[1 - k] != *i))
            .filter_map(|(_, point)| point.name.as_deref())
            .collect();
        let meant = file.points[first].name.as_deref().and_then(|name| did_you_mean(name, &free));
        let meant = meant.map_or(String::new(), |meant| format!("; {}: {meant}", names[0]));
        warnings.push(format!(
            "{}: {} without a partner of that name are left out: {}{more}{meant}",
            file.file.display(),
            alone.len(),
            names.join(", ")
        ));
    }
    Ok(pairs)
}

/// That two points of a file have one name, which not every notation rules out.
fn twice(file: &PointFile) -> Option<Diagnostic> {
    let mut seen = std::collections::HashSet::new();
    let second = file.points.iter().find(|point| point.name.as_ref().is_some_and(|name| !seen.insert(name)))?;
    let name = second.name.as_deref().unwrap_or_default();
    let message = format!("another point is called {name}");
    Some(Diagnostic::new(Kind::BadData, message).at(second.location.clone()).hint("give each its own name"))
}
