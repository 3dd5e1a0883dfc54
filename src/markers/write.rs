//! Writing markers in any of the notations.

use std::path::{Path, PathBuf};

use nalgebra::Point3;

use super::{MarkerFile, Side, attach::Attacher, cons, json, points, pp, table, yaml};
use crate::{
    core::mesh::SurfacePoint,
    diagnostic::Kind,
    diagnostic::{Diagnostic, Location, Result},
};

/// A point of one side, as files of points have it.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// Its name, or its number from 1.
    pub name: String,
    /// Where it is, in the unit of the mesh.
    pub position: Point3<f64>,
    /// Where it is on the mesh.
    pub point: SurfacePoint,
}

impl Default for Written {
    fn default() -> Self {
        Self { name: String::new(), position: Point3::origin(), point: SurfacePoint::Vertex(0) }
    }
}

/// Texts of files, each with its path.
pub type Texts = Vec<(PathBuf, String)>;

/// The texts of the files that `markers` become, each with its path; and sentences about what they cannot hold.
///
/// `out` with `{side}` becomes two files, one for the points of each mesh.
///
/// # Errors
///
/// If the ending is unknown, a file of points has no `{side}`, or a marker no target yet.
pub fn write(markers: &MarkerFile, out: &Path, source: Side<'_>, target: Side<'_>) -> Result<(Texts, Vec<String>)> {
    let name = out.to_string_lossy();
    let wrong = |message: String, hint: &str| {
        Err(Diagnostic::new(Kind::Usage, message).at(Location::File(out.into())).hint(hint).into())
    };
    let extension = points::extension(out).unwrap_or_default();
    let both = ["cons", "yaml", "yml"].contains(&extension.as_str());
    let one = points::EXTENSIONS.contains(&extension.as_str());
    if !both && !one {
        let hint = "endings of both sides in one file: .yaml, .cons; of one side each: .pp, .csv, .json, .txt (Wrap), as `points-{side}.pp`";
        return wrong("no notation of markers has this ending".into(), hint);
    }
    if one != name.contains("{side}") {
        let (message, hint) = if one {
            (
                format!("a .{extension} holds the points of one mesh"),
                "put `{side}` into its name, e.g. `points-{side}.pp`",
            )
        } else {
            (format!("a .{extension} holds both sides"), "remove `{side}` from its name")
        };
        return wrong(message, hint);
    }
    if extension != "yaml"
        && extension != "yml"
        && let Some(first) = markers.entries.iter().position(|entry| entry.target.is_none())
    {
        let message = format!("marker {} has no target yet", markers.name(first));
        return wrong(message, "only .yaml has room for markers that are still to be completed");
    }
    if extension == "cons" {
        let (text, moved) = cons_text(markers, source, target)?;
        return Ok((vec![(out.into(), text)], moved));
    }
    if both {
        return Ok((vec![(out.into(), yaml::write(markers))], vec![]));
    }
    let files = [source, target].map(|side| {
        let attacher = Attacher::new(side)?;
        let points: Vec<Written> = (0..markers.entries.len())
            .filter_map(|i| {
                let point = markers.entries[i].of(side.name)?;
                Some(Written { name: markers.name(i), position: attacher.position(point), point })
            })
            .collect();
        let mesh = markers.reference(side.name).and_then(|reference| reference.mesh.clone()).unwrap_or_default();
        let text = match extension.as_str() {
            "pp" => pp::write(&points, &mesh),
            "json" => json::write(&points),
            "txt" => json::write_wrap(&points, |point| attacher.triangle(point)),
            _ => table::write(&points),
        };
        Ok((PathBuf::from(name.replace("{side}", side.name)), text))
    });
    Ok((files.into_iter().collect::<Result<_>>()?, vec![]))
}

/// A `.cons`, which knows vertices only, and what that moves.
fn cons_text(markers: &MarkerFile, source: Side<'_>, target: Side<'_>) -> Result<(String, Vec<String>)> {
    let mut warnings = Vec::new();
    let mut columns = Vec::new();
    for side in [source, target] {
        let attacher = Attacher::new(side)?;
        let (mut column, mut moved, mut farthest) = (Vec::new(), 0, 0.0_f64);
        for point in markers.entries.iter().filter_map(|entry| entry.of(side.name)) {
            let (vertex, distance) = attacher.nearest_vertex(point);
            moved += usize::from(distance > 0.0);
            farthest = farthest.max(distance);
            column.push(vertex);
        }
        if moved > 0 {
            warnings.push(format!(
                "{}: a .cons names vertices only: {moved} of {} points moved to the nearest one, by {:.2} % of the diagonal at most",
                side.name,
                column.len(),
                100.0 * farthest
            ));
        }
        columns.push(column);
    }
    let [source, target] = [&columns[0], &columns[1]];
    Ok((cons::write(source.iter().copied().zip(target.iter().copied())), warnings))
}
