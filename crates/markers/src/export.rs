//! Writing markers in any notation.

use std::path::{Path, PathBuf};

use mimesh_document::{Diagnostic, Kind, Location, Result};

use crate::{
    attacher::Attacher,
    formats::{cons, json, pp, table, wrap, yaml},
    indices::{check, indexed_points},
    mesh::{MarkerMesh, MeshRole},
    model::{MarkerFile, MarkerStatus},
    notation::{Notation, ending},
    points::ExportPoint,
};

/// The files that markers become.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exported {
    /// The texts of the files, each with its path.
    pub files: Vec<(PathBuf, String)>,
    /// Sentences about points that the notation cannot hold as they are.
    pub warnings: Vec<String>,
}

/// The texts of the files that `markers` become in the notation of `out`.
///
/// An `out` with `{side}` in its name becomes two files, one for the points of each mesh.
///
/// # Errors
///
/// If the ending is unknown, a file of points has no `{side}`, a marker has no target yet, or a point does not exist.
pub fn export(markers: &MarkerFile, out: &Path, meshes: [MarkerMesh<'_>; 2]) -> Result<Exported> {
    let notation = check_name(out)?;
    if notation != Notation::Yaml && markers.pairs.iter().any(|pair| pair.status == MarkerStatus::Skipped) {
        return export(&markers.numbered_without_skipped(), out, meshes);
    }
    if notation != Notation::Yaml {
        check_complete(markers, out)?;
    }
    for mesh in meshes {
        check(mesh, &indexed_points(markers, mesh.role)).into_result()?;
    }
    match notation {
        Notation::Yaml => Ok(Exported { files: vec![(out.into(), yaml::write(markers))], warnings: vec![] }),
        Notation::Cons => Ok(export_cons(markers, out, meshes)),
        _ => {
            let [source, target] = meshes.map(|mesh| export_side(markers, out, notation, mesh));
            Ok(Exported { files: vec![source?, target?], warnings: vec![] })
        }
    }
}

/// The notation of `out`, whose name has `{side}` if it needs it.
fn check_name(out: &Path) -> Result<Notation> {
    let Some(notation) = Notation::of(out).filter(|notation| notation.is_written()) else {
        let hint = "endings of both sides in one file: .yaml, .cons; of one side each: .pp, .csv, .json, .txt (Wrap), as \
                    `points-{side}.pp`";
        return Err(unusable(out, no_notation(out), hint));
    };
    let (both, ending) = (notation.holds_both_sides(), ending(out));
    match (both, out.to_string_lossy().contains("{side}")) {
        (false, false) => {
            let hint = "put `{side}` into its name, e.g. `points-{side}.pp`";
            Err(unusable(out, format!("a .{ending} holds the points of one mesh"), hint))
        }
        (true, true) => Err(unusable(out, format!("a .{ending} holds both sides"), "remove `{side}` from its name")),
        _ => Ok(notation),
    }
}

fn no_notation(out: &Path) -> String {
    match Notation::of(out) {
        Some(_) => format!("a .{} is read and not written", ending(out)),
        None => "no notation of markers has this ending".into(),
    }
}

fn check_complete(markers: &MarkerFile, out: &Path) -> Result<()> {
    let lacks = |role: MeshRole| Some((role, markers.pairs.iter().position(|pair| pair.point(role).is_none())?));
    match MeshRole::BOTH.into_iter().find_map(lacks) {
        None => Ok(()),
        Some((role, first)) => {
            let message = format!("marker {} has no {role} yet", markers.name(first));
            Err(unusable(out, message, "only .yaml has room for markers that are still to be completed"))
        }
    }
}

fn unusable(out: &Path, message: String, hint: &str) -> mimesh_document::Diagnostics {
    Diagnostic::new(Kind::Usage, message).at(Location::File(out.into())).hint(hint).into()
}

/// A `.cons`, which holds vertices only; a sentence for each mesh on which that moves points.
fn export_cons(markers: &MarkerFile, out: &Path, meshes: [MarkerMesh<'_>; 2]) -> Exported {
    let mut warnings = Vec::new();
    let [source, target] = meshes.map(|mesh| {
        let points = markers.pairs.iter().filter_map(|pair| pair.point(mesh.role));
        let nearest: Vec<(u32, f64)> = points.filter_map(|point| mesh.nearest_vertex(point)).collect();
        let moved = nearest.iter().filter(|(_, distance)| *distance > 0.0).count();
        if moved > 0 {
            let farthest = nearest.iter().fold(0.0, |farthest: f64, (_, distance)| farthest.max(*distance));
            warnings.push(format!(
                "{}: a .cons names vertices only: {moved} of {} points moved to the nearest one, by {:.2} % of the diagonal at most",
                mesh.role,
                nearest.len(),
                100.0 * farthest
            ));
        }
        nearest
    });
    let pairs = source.iter().zip(&target).map(|(source, target)| (source.0, target.0));
    Exported { files: vec![(out.into(), cons::write(pairs))], warnings }
}

/// The file of points for `mesh`.
fn export_side(
    markers: &MarkerFile,
    out: &Path,
    notation: Notation,
    mesh: MarkerMesh<'_>,
) -> Result<(PathBuf, String)> {
    let points: Vec<ExportPoint> = (0..markers.pairs.len())
        .filter_map(|i| {
            let point = markers.pairs[i].point(mesh.role)?;
            Some(ExportPoint { name: markers.name(i), position: mesh.position(point)?, point })
        })
        .collect();
    let text = match notation {
        Notation::PickedPoints => {
            let mesh = markers.reference(mesh.role).and_then(|reference| reference.mesh.as_deref());
            pp::write(&points, mesh.unwrap_or_default())
        }
        Notation::Json => json::write(&points),
        Notation::Text => {
            let attacher = Attacher::new(mesh)?;
            wrap::write(points.iter().map(|point| attacher.place_on_triangle(point.point)))
        }
        _ => table::write(&points),
    };
    Ok((PathBuf::from(out.to_string_lossy().replace("{side}", mesh.role.name())), text))
}
