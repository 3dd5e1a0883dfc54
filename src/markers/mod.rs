//! Markers: pairs of corresponding points that the user gives, in files.
//!
//! Files name vertices and triangles of the *meshes*; [`MarkerFile::resolve`] turns them into points of the welded
//! surfaces that stages work on. Two notations are read: [`cons`] and our own [`yaml`].

pub mod cons;
pub mod yaml;

use std::{collections::HashMap, path::Path};

use crate::{
    core::{
        mesh::{Mesh, MeshSequence, Surface, SurfacePoint},
        stage::Marker,
    },
    mistake::{Mistake, Place, Result, read_text},
    status::Status,
};

/// What a file of markers says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MarkerFile {
    /// The source mesh that they were made on.
    pub source: Option<MeshReference>,
    /// The target mesh that they were made on.
    pub target: Option<MeshReference>,
    /// The pairs, in order.
    pub entries: Vec<Entry>,
}

/// A mesh that markers were made on, to notice that it has changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshReference {
    /// The mesh's file, for information.
    pub mesh: Option<String>,
    /// Its number of vertices.
    pub vertices: Option<usize>,
    /// BLAKE3 hash of the file, in hexadecimal.
    pub blake3: Option<String>,
}

/// A pair of points.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// A name, if it has one.
    pub name: Option<String>,
    /// A vertex of the source mesh, or a place on one of its triangles.
    pub source: SurfacePoint,
    /// A vertex of the target mesh, or a place on one of its triangles; `None` while it is still to be found.
    pub target: Option<SurfacePoint>,
    /// A remark.
    pub note: Option<String>,
    /// Where the pair stands in its file.
    pub place: Option<Place>,
}

/// One of the two meshes, as far as markers need it.
#[derive(Clone, Copy, Debug)]
pub struct Side<'a> {
    /// `source` or `target`.
    pub name: &'static str,
    /// The mesh that the file's numbers count.
    pub mesh: &'a Mesh,
    /// Its surface.
    pub surface: &'a Surface,
}

/// Reads a file of markers, in the notation that its extension tells.
///
/// # Errors
///
/// All that is wrong with the file, each with its line.
pub fn read(path: &Path) -> Result<MarkerFile> {
    match path.extension().map(|e| e.to_string_lossy().to_lowercase()).as_deref() {
        Some("cons") => cons::parse(path, &read_text(path)?),
        Some("yaml" | "yml") => yaml::parse(path, &read_text(path)?),
        _ => Err(Mistake::new(Status::BadPipeline, "not a file of markers: expected .cons or .yaml")
            .at(Place::File(path.into()))
            .hint("a .cons has the count in its first line, then `source, target` a line")
            .into()),
    }
}

/// The landmarks that both meshes have, as markers: pairs of equal names.
pub fn from_landmarks(source: &MeshSequence, target: &MeshSequence) -> MarkerFile {
    let targets: HashMap<&str, SurfacePoint> = target.landmarks.iter().map(|l| (l.name.as_str(), l.point)).collect();
    let pair = |source: &crate::core::mesh::Landmark| {
        let target = *targets.get(source.name.as_str())?;
        Some(Entry {
            name: Some(source.name.clone()),
            source: source.point,
            target: Some(target),
            note: None,
            place: None,
        })
    };
    MarkerFile { entries: source.landmarks.iter().filter_map(pair).collect(), ..MarkerFile::default() }
}

impl MarkerFile {
    /// The markers on the surfaces of the meshes.
    ///
    /// # Errors
    ///
    /// Every marker that is out of range, or shares a point with an earlier one.
    pub fn resolve(&self, source: Side<'_>, target: Side<'_>) -> Result<Vec<Marker>> {
        let mut mistakes = Vec::new();
        let mut markers = Vec::new();
        if let Some(mistake) = self.swapped(source, target) {
            return Err(mistake.into());
        }
        mistakes.extend(self.incomplete());
        for (i, entry) in self.entries.iter().enumerate() {
            let Some(of_target) = entry.target else { continue };
            let points = [(source, entry.source), (target, of_target)].map(|(side, point)| {
                on_surface(side, point).map_err(|message| {
                    let hint = "vertices and triangles count from 0; were source and target swapped, or has the mesh changed since?";
                    mistakes.push(entry.mistake(format!("marker {}: {message}", self.name(i))).hint(hint));
                })
            });
            if let [Ok(source), Ok(target)] = points {
                markers.push((i, Marker { name: self.name(i), source, target }));
            }
        }
        for (side, surface) in [(source.name, source.surface), (target.name, target.surface)] {
            let point = |marker: &Marker| if side == source.name { marker.source } else { marker.target };
            let mut seen: HashMap<[u64; 3], usize> = HashMap::new();
            for (i, marker) in &markers {
                let at = point(marker).position(surface, &surface.positions);
                let key = [at.x, at.y, at.z].map(|x| (x + 0.0).to_bits());
                if let Some(first) = seen.get(&key) {
                    mistakes.push(self.coincide(*first, *i, side));
                } else {
                    seen.insert(key, *i);
                }
            }
        }
        if mistakes.is_empty() {
            Ok(markers.into_iter().map(|(_, marker)| marker).collect())
        } else {
            Err(crate::mistake::Failure { mistakes })
        }
    }

    /// That markers have no target yet: which, in one sentence, at the first.
    fn incomplete(&self) -> Option<Mistake> {
        let missing: Vec<usize> = (0..self.entries.len()).filter(|&i| self.entries[i].target.is_none()).collect();
        let first = *missing.first()?;
        let name = |&i: &usize| match &self.entries[i].note {
            Some(note) => format!("{} ({note})", self.name(i)),
            None => self.name(i),
        };
        let message = match missing.len() {
            1 => format!("marker {} has no target", name(&first)),
            count => {
                let names: Vec<_> = missing.iter().map(name).collect();
                format!("{count} of {} markers have no target: {}", self.entries.len(), names.join("; "))
            }
        };
        let hint = "write the vertex of the target at the same place, e.g. `{ source: 750, target: 3386 }`";
        Some(self.entries[first].mistake(message).hint(hint))
    }

    /// That several markers do not exist, and all would with source and target exchanged.
    fn swapped(&self, source: Side<'_>, target: Side<'_>) -> Option<Mistake> {
        let wrong = |entry: &&Entry| {
            let of = [(source, entry.source), (target, entry.target?)];
            of.into_iter().find_map(|(side, point)| on_surface(side, point).err())
        };
        let wrong: Vec<_> =
            self.entries.iter().enumerate().filter_map(|(i, entry)| Some((i, wrong(&entry)?))).collect();
        let fits = |entry: &Entry| {
            entry.target.is_none_or(|point| on_surface(source, point).is_ok())
                && on_surface(target, entry.source).is_ok()
        };
        let ([(i, first), _, ..], true) = (&wrong[..], self.entries.iter().all(fits)) else { return None };
        let message = format!(
            "marker {}: {first}; so it is with {} of {} markers, and with none if source and target are exchanged",
            self.name(*i),
            wrong.len(),
            self.entries.len()
        );
        let hint = "exchange `source` and `target` in the pipeline, or the two sides of the markers";
        Some(self.entries[*i].mistake(message).hint(hint))
    }

    /// Sentences about meshes that are not those that the markers were made on.
    ///
    /// `hash` is the BLAKE3 hash of the mesh's file, if it comes from one.
    pub fn stale(&self, path: &Path, side: Side<'_>, hash: Option<&str>) -> Option<String> {
        let reference = if side.name == "source" { &self.source } else { &self.target }.as_ref()?;
        let found = side.mesh.positions.len();
        let may = "the numbers may not fit any more";
        let name = reference.mesh.as_deref().unwrap_or(side.name);
        match (reference.vertices, &reference.blake3, hash) {
            (Some(vertices), ..) if vertices != found => Some(format!(
                "{}: made on a {} of {vertices} vertices ({name}), which now has {found}; {may}",
                path.display(),
                side.name
            )),
            (_, Some(expected), Some(hash)) if !expected.eq_ignore_ascii_case(hash) => Some(format!(
                "{}: the {} ({name}) has changed since the markers were made; {may}",
                path.display(),
                side.name
            )),
            _ => None,
        }
    }

    /// The name of entry `i` in messages: the user's, or its number from 1.
    fn name(&self, i: usize) -> String {
        self.entries[i].name.clone().unwrap_or_else(|| (i + 1).to_string())
    }

    fn coincide(&self, first: usize, second: usize, side: &str) -> Mistake {
        let first_line = match &self.entries[first].place {
            Some(Place::Line { line, .. } | Place::Span { line, .. }) => format!(" (line {line})"),
            _ => String::new(),
        };
        let message = format!(
            "marker {} lies on the same point of the {side} as marker {}{first_line}",
            self.name(second),
            self.name(first)
        );
        self.entries[second].mistake(message).hint("remove one of the two; a point can have one partner only")
    }
}

impl Entry {
    fn mistake(&self, message: String) -> Mistake {
        let mistake = Mistake::new(Status::BadData, message);
        match &self.place {
            Some(place) => mistake.at(place.clone()),
            None => mistake,
        }
    }
}

/// The point of the surface for a point of the mesh.
fn on_surface(side: Side<'_>, point: SurfacePoint) -> std::result::Result<SurfacePoint, String> {
    let check = |what: &str, index: u32, count: usize| {
        let last = count.saturating_sub(1);
        if (index as usize) < count {
            Ok(())
        } else {
            Err(format!("the {} has no {what} {index}: expected 0 to {last}", side.name))
        }
    };
    match point {
        SurfacePoint::Vertex(vertex) => {
            check("vertex", vertex, side.mesh.positions.len())?;
            Ok(SurfacePoint::Vertex(side.surface.vertex_of[vertex as usize]))
        }
        SurfacePoint::Triangle(triangle, _) => {
            check("triangle", triangle, side.surface.triangle_count())?;
            Ok(point)
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::*;

    /// Two triangles whose common edge is split, as at a seam.
    fn split_square() -> (Mesh, Surface) {
        let p = |x: f64, y: f64| Point3::new(x, y, 0.0);
        let positions = vec![p(0., 0.), p(1., 0.), p(0., 1.), p(0., 1.), p(1., 0.), p(1., 1.)];
        let mesh = Mesh::from_triangles(positions, &[[0, 1, 2], [3, 4, 5]]);
        let surface = Surface::new(&mesh).unwrap();
        (mesh, surface)
    }

    fn resolve(text: &str) -> Result<Vec<Marker>> {
        let (mesh, surface) = split_square();
        let side = |name| Side { name, mesh: &mesh, surface: &surface };
        cons::parse(Path::new("m.cons"), text)?.resolve(side("source"), side("target"))
    }

    #[test]
    fn vertices_of_the_mesh_become_vertices_of_the_welded_surface() {
        let markers = resolve("2\n0, 0\n5, 5\n").unwrap();
        assert_eq!(markers[1].source, SurfacePoint::Vertex(3));
        assert_eq!(markers[1].name, "2");
    }

    #[test]
    fn copies_of_one_vertex_are_one_point() {
        let text = resolve("2\n1, 0\n4, 5\n").unwrap_err().to_string();
        assert!(
            text.starts_with("error: m.cons:3: marker 2 lies on the same point of the source as marker 1 (line 2)"),
            "{text}"
        );
    }

    #[test]
    fn all_vertices_out_of_range_are_told() {
        let text = resolve("3\n9, 0\n1, 1\n2, 7\n").unwrap_err().to_string();
        assert!(text.contains("m.cons:2: marker 1: the source has no vertex 9: expected 0 to 5"), "{text}");
        assert!(text.contains("m.cons:4: marker 3: the target has no vertex 7: expected 0 to 5"), "{text}");
    }

    #[test]
    fn exchanged_sides_are_told_once() {
        let (mesh, surface) = split_square();
        let small = Mesh::from_triangles(mesh.positions[..3].to_vec(), &[[0, 1, 2]]);
        let small_surface = Surface::new(&small).unwrap();
        let source = Side { name: "source", mesh: &mesh, surface: &surface };
        let target = Side { name: "target", mesh: &small, surface: &small_surface };
        let file = |text: &str| cons::parse(Path::new("m.cons"), text).unwrap();
        let text = file("3\n0, 4\n1, 1\n2, 5\n").resolve(source, target).unwrap_err().to_string();
        assert_eq!(
            text,
            "error: m.cons:2: marker 1: the target has no vertex 4: expected 0 to 2; so it is with 2 of 3 markers, and \
             with none if source and target are exchanged\n  hint: exchange `source` and `target` in the pipeline, or the \
             two sides of the markers"
        );
        let both = file("3\n0, 4\n1, 1\n4, 5\n").resolve(source, target).unwrap_err();
        assert_eq!(both.mistakes.len(), 2);
    }

    #[test]
    fn landmarks_of_equal_names_are_markers() {
        use crate::core::mesh::Landmark;
        let of = |names: [&str; 2]| MeshSequence {
            landmarks: names
                .iter()
                .enumerate()
                .map(|(i, name)| Landmark { name: name.to_string(), point: SurfacePoint::Vertex(i as u32) })
                .collect(),
            ..MeshSequence::default()
        };
        let file = from_landmarks(&of(["nose", "tail"]), &of(["ear", "nose"]));
        assert_eq!(file.entries.len(), 1);
        assert_eq!(
            (file.entries[0].source, file.entries[0].target),
            (SurfacePoint::Vertex(0), Some(SurfacePoint::Vertex(1)))
        );
    }
}
