use std::{collections::HashMap, path::Path};

use super::{
    Entry, MarkerFile, Side,
    attach::Attacher,
    indices::{Given, check, on_surface},
};
use crate::{
    core::stage::Marker,
    diagnostic::{Diagnostic, Diagnostics, Location, Result},
};

/// Positions nearer than this, relative to the diagonal, are one place: a mesh file keeps six digits or so.
pub(super) const SAME_PLACE: f64 = 1e-5;

impl MarkerFile {
    /// The markers on the surfaces of the meshes.
    ///
    /// # Errors
    ///
    /// Every marker that is out of range, or shares a point with an earlier one.
    pub fn resolve(&self, source: Side<'_>, target: Side<'_>) -> Result<Vec<Marker>> {
        let mut diagnostics = Vec::new();
        let mut markers = Vec::new();
        if let Some(diagnostic) = self.swapped(source, target) {
            return Err(diagnostic.into());
        }
        diagnostics.extend(self.incomplete());
        for side in [source, target] {
            let given = |(i, entry): (usize, &Entry)| {
                let point = entry.of(side.name)?;
                Some(Given { label: format!("marker {}", self.name(i)), point, location: entry.location.clone() })
            };
            diagnostics.extend(check(side, &self.entries.iter().enumerate().filter_map(given).collect::<Vec<_>>()));
        }
        for (i, entry) in self.entries.iter().enumerate() {
            let Some(of_target) = entry.target else { continue };
            if let (Ok(source), Ok(target)) = (on_surface(source, entry.source), on_surface(target, of_target)) {
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
                    diagnostics.push(self.coincide(*first, *i, side));
                } else {
                    seen.insert(key, *i);
                }
            }
        }
        if diagnostics.is_empty() {
            Ok(markers.into_iter().map(|(_, marker)| marker).collect())
        } else {
            Err(Diagnostics { diagnostics })
        }
    }

    /// That markers have no target yet: which, in one sentence, at the first.
    fn incomplete(&self) -> Option<Diagnostic> {
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
        Some(self.entries[first].diagnostic(message).hint(hint))
    }

    /// That several markers do not exist, and all would with source and target exchanged.
    fn swapped(&self, source: Side<'_>, target: Side<'_>) -> Option<Diagnostic> {
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
        Some(self.entries[*i].diagnostic(message).hint(hint))
    }

    /// Sentences about meshes that are not those that the markers were made on.
    ///
    /// `hash` is the BLAKE3 hash of the mesh's file, if it comes from one.
    pub fn stale(&self, path: &Path, side: Side<'_>, hash: Option<&str>) -> Option<String> {
        let reference = self.reference(side.name)?;
        let found = side.mesh.positions.len();
        let name = reference.mesh.as_deref().unwrap_or(side.name);
        let changed = match (reference.vertices, &reference.blake3, hash) {
            (Some(vertices), ..) if vertices != found => format!(
                "{}: made on a {} of {vertices} vertices ({name}), which now has {found}",
                path.display(),
                side.name
            ),
            (_, Some(expected), Some(hash)) if !expected.eq_ignore_ascii_case(hash) => {
                format!("{}: the {} ({name}) has changed since the markers were made", path.display(), side.name)
            }
            _ => return None,
        };
        let consequence = match self.astray(side) {
            Some(0) => return None,
            Some(count) => format!("{count} of {} points no longer lie where they were put", self.entries.len()),
            None => "the numbers may not fit any more".into(),
        };
        Some(format!("{changed}; {consequence}: `mimesh markers reattach` carries them over"))
    }

    /// How many points of a side do not lie where the file says that they were; `None` if it does not say it of all.
    fn astray(&self, side: Side<'_>) -> Option<usize> {
        let attacher = Attacher::new(side).ok()?;
        let k = usize::from(side.name != "source");
        let mut count = 0;
        for entry in &self.entries {
            let Some(point) = entry.of(side.name) else { continue };
            let at = entry.at[k]?;
            let lies = on_surface(side, point).is_ok()
                && (attacher.position(point) - at).norm() <= SAME_PLACE * attacher.diagonal;
            count += usize::from(!lies);
        }
        (!self.entries.is_empty()).then_some(count)
    }

    fn coincide(&self, first: usize, second: usize, side: &str) -> Diagnostic {
        let first_line = match &self.entries[first].location {
            Some(Location::Line { line, .. } | Location::Span { line, .. }) => format!(" (line {line})"),
            _ => String::new(),
        };
        let message = format!(
            "marker {} lies on the same point of the {side} as marker {}{first_line}",
            self.name(second),
            self.name(first)
        );
        self.entries[second].diagnostic(message).hint("remove one of the two; a point can have one partner only")
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Point3;

    use super::{super::cons, *};
    use crate::core::mesh::{Mesh, Surface, SurfacePoint};

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
        assert_eq!(both.diagnostics.len(), 2);
    }

    #[test]
    fn numbers_that_count_from_one_are_told_once() {
        let text = resolve("3\n1, 0\n3, 1\n6, 5\n").unwrap_err().to_string();
        assert_eq!(
            text,
            "error: m.cons:4: marker 3: the source has no vertex 6: expected 0 to 5; none of them is vertex 0, so the \
             numbers of the source seem to count from 1\n  hint: subtract 1 from each number of the source, or let \
             `mimesh markers convert --from-one source` do it"
        );
        // Where vertex 0 is named, it counts from 0 and is wrong.
        assert!(!resolve("3\n0, 0\n3, 1\n6, 5\n").unwrap_err().to_string().contains("count from 1"));
    }

    #[test]
    fn triangles_in_place_of_vertices_are_told_once() {
        // A fan of 8 triangles around a vertex, then each of them twice: 9 vertices, 16 triangles.
        let mut positions = vec![Point3::origin()];
        positions.extend((0..8).map(|k| Point3::new(f64::from(k).cos(), f64::from(k).sin(), 0.0)));
        let fan: Vec<_> = (0..8).map(|k| [0, 1 + k, 1 + (k + 1) % 8]).collect();
        let mesh = Mesh::from_triangles(positions, &[&fan[..], &fan[..]].concat());
        let surface = Surface::new(&mesh).unwrap();
        let side = |name| Side { name, mesh: &mesh, surface: &surface };
        let file = cons::parse(Path::new("m.cons"), "3\n1, 0\n12, 1\n15, 2\n").unwrap();
        let failure = file.resolve(side("source"), side("target")).unwrap_err();
        assert_eq!(failure.diagnostics.len(), 1);
        assert_eq!(
            failure.diagnostics[0].message,
            "marker 2: the source has no vertex 12: expected 0 to 8; so it is with 2 of 3; all are below the number of its \
             triangles, 16, so they may be triangles"
        );
    }
}
