//! Markers on the surfaces of their meshes, as stages use them.

use std::collections::HashMap;

use mimesh_core::{
    mesh::{MeshPoint, SurfacePoint},
    stage::Marker,
};
use mimesh_document::{Diagnostic, Diagnostics, Result};

use crate::{
    indices::{check, indexed_points, missing},
    mesh::{MarkerMesh, MeshRole},
    model::{MarkerFile, MarkerPair, MarkerStatus},
    text::in_line,
};

impl MarkerFile {
    /// The markers on the surfaces of the two meshes.
    ///
    /// # Errors
    ///
    /// Every marker that lacks a point, does not exist on its mesh, or shares a point with an earlier one; skipped ones do not count.
    pub fn resolve(&self, meshes: [MarkerMesh<'_>; 2]) -> Result<Vec<Marker>> {
        if self.pairs.iter().any(|pair| pair.status == MarkerStatus::Skipped) {
            return self.numbered_without_skipped().resolve(meshes);
        }
        if let Some(diagnostic) = self.exchanged(meshes) {
            return Err(diagnostic.into());
        }
        let mut diagnostics = Diagnostics::default();
        MeshRole::BOTH.into_iter().for_each(|role| diagnostics.extend(self.incomplete(role)));
        for mesh in meshes {
            diagnostics.extend(check(mesh, &indexed_points(self, mesh.role)));
        }
        for mesh in meshes {
            diagnostics.extend(self.coincident(meshes, mesh));
        }
        let markers = (0..self.pairs.len()).filter_map(|i| {
            let [source, target] = self.pairs[i].on_surfaces(meshes)?;
            Some(Marker { name: self.name(i), source, target })
        });
        diagnostics.into_result().map(|()| markers.collect())
    }

    /// The markers without those that a person left out, which keep their numbers as names.
    pub(crate) fn numbered_without_skipped(&self) -> Self {
        let used = (0..self.pairs.len()).filter(|&i| self.pairs[i].status != MarkerStatus::Skipped);
        let named = used.map(|i| MarkerPair { name: Some(self.name(i)), ..self.pairs[i].clone() });
        Self { pairs: named.collect(), ..self.clone() }
    }

    /// The diagnostic of all markers that have no point of `role` yet, at the first of them.
    fn incomplete(&self, role: MeshRole) -> Option<Diagnostic> {
        let missing: Vec<usize> = (0..self.pairs.len()).filter(|&i| self.pairs[i].point(role).is_none()).collect();
        let first = *missing.first()?;
        let names: Vec<_> = missing.iter().map(|&i| self.name_with_note(i)).collect();
        let message = match missing.len() {
            1 => format!("marker {} has no {role}", names[0]),
            count => format!("{count} of {} markers have no {role}: {}", self.pairs.len(), names.join("; ")),
        };
        let hint = format!("write the vertex of the {role} at the same place, e.g. `{{ source: 750, target: 3386 }}`");
        Some(self.pairs[first].diagnostic(message).hint(hint))
    }

    fn name_with_note(&self, i: usize) -> String {
        match &self.pairs[i].note {
            Some(note) => format!("{} ({note})", self.name(i)),
            None => self.name(i),
        }
    }

    /// The diagnostic of several markers that do not exist, if all would with source and target exchanged.
    fn exchanged(&self, meshes: [MarkerMesh<'_>; 2]) -> Option<Diagnostic> {
        let mut wrong = (0..self.pairs.len()).filter_map(|i| Some((i, self.pairs[i].missing(meshes)?)));
        let (i, first) = wrong.next()?;
        let count = 1 + wrong.count();
        let [source, target] = meshes;
        let fits_exchanged = |pair: &MarkerPair| {
            pair.source.is_none_or(|point| missing(target, point).is_none())
                && pair.target.is_none_or(|point| missing(source, point).is_none())
        };
        if count < 2 || !self.pairs.iter().all(fits_exchanged) {
            return None;
        }
        let message = format!(
            "marker {}: {first}; so it is with {count} of {} markers, and with none if source and target are exchanged",
            self.name(i),
            self.pairs.len()
        );
        let hint = "exchange `source` and `target` in the pipeline, or the two sides of the markers";
        Some(self.pairs[i].diagnostic(message).hint(hint))
    }

    /// The diagnostics of markers that lie on the same point of `mesh` as an earlier one.
    fn coincident(&self, meshes: [MarkerMesh<'_>; 2], mesh: MarkerMesh<'_>) -> Vec<Diagnostic> {
        let mut seen: HashMap<[u64; 3], usize> = HashMap::new();
        let mut diagnostics = Vec::new();
        for (i, pair) in self.pairs.iter().enumerate() {
            let Some(points) = pair.on_surfaces(meshes) else { continue };
            let at = points[mesh.role.index()].position(mesh.surface, &mesh.surface.positions);
            // Adding 0 makes a positive zero of a negative one.
            let key = [at.x, at.y, at.z].map(|x| (x + 0.0).to_bits());
            let Some(&first) = seen.get(&key) else {
                seen.insert(key, i);
                continue;
            };
            let message = format!(
                "marker {} lies on the same point of the {} as marker {}{}",
                self.name(i),
                mesh.role,
                self.name(first),
                in_line(self.pairs[first].location.as_ref())
            );
            diagnostics.push(pair.diagnostic(message).hint("remove one of the two; a point can have one partner only"));
        }
        diagnostics
    }
}

impl MarkerPair {
    /// The points on the surfaces of source and target, if both exist.
    fn on_surfaces(&self, [source, target]: [MarkerMesh<'_>; 2]) -> Option<[SurfacePoint; 2]> {
        Some([source.surface.point(self.source?)?, target.surface.point(self.target?)?])
    }

    /// In words that a mesh lacks its point of a pair; `None` for points that are still to be found.
    fn missing(&self, [source, target]: [MarkerMesh<'_>; 2]) -> Option<String> {
        let lacks = |mesh, point: Option<MeshPoint>| point.and_then(|point| missing(mesh, point));
        lacks(source, self.source).or_else(|| lacks(target, self.target))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use nalgebra::Point3;

    use super::*;
    use crate::{formats::cons, mesh::MeshRole, remedies::FROM_ONE};
    use mimesh_core::mesh::{Mesh, Surface};

    /// Two triangles whose common edge is split, as at a seam.
    fn split_square() -> (Mesh, Surface) {
        let p = |x: f64, y: f64| Point3::new(x, y, 0.0);
        let positions = vec![p(0., 0.), p(1., 0.), p(0., 1.), p(0., 1.), p(1., 0.), p(1., 1.)];
        let mesh = Mesh::from_triangles(positions, &[[0, 1, 2], [3, 4, 5]]);
        let surface = Surface::new(&mesh).unwrap();
        (mesh, surface)
    }

    /// The same mesh as source and target.
    fn both<'a>(mesh: &'a Mesh, surface: &'a Surface) -> [MarkerMesh<'a>; 2] {
        MeshRole::BOTH.map(|role| MarkerMesh { role, mesh, surface })
    }

    fn resolve(text: &str) -> Result<Vec<Marker>> {
        let (mesh, surface) = split_square();
        cons::parse(Path::new("m.cons"), text)?.resolve(both(&mesh, &surface))
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
    fn all_vertices_out_of_range_are_reported() {
        let text = resolve("3\n9, 0\n1, 1\n2, 7\n").unwrap_err().to_string();
        assert!(text.contains("m.cons:2: marker 1: the source has no vertex 9: expected 0 to 5"), "{text}");
        assert!(text.contains("m.cons:4: marker 3: the target has no vertex 7: expected 0 to 5"), "{text}");
    }

    #[test]
    fn exchanged_sides_are_reported_once() {
        let (mesh, surface) = split_square();
        let small = Mesh::from_triangles(mesh.positions[..3].to_vec(), &[[0, 1, 2]]);
        let small_surface = Surface::new(&small).unwrap();
        let source = MarkerMesh { role: MeshRole::Source, mesh: &mesh, surface: &surface };
        let target = MarkerMesh { role: MeshRole::Target, mesh: &small, surface: &small_surface };
        let file = |text: &str| cons::parse(Path::new("m.cons"), text).unwrap();
        let text = file("3\n0, 4\n1, 1\n2, 5\n").resolve([source, target]).unwrap_err().to_string();
        assert_eq!(
            text,
            "error: m.cons:2: marker 1: the target has no vertex 4: expected 0 to 2; so it is with 2 of 3 markers, and \
             with none if source and target are exchanged\n  hint: exchange `source` and `target` in the pipeline, or the \
             two sides of the markers"
        );
        let both = file("3\n0, 4\n1, 1\n4, 5\n").resolve([source, target]).unwrap_err();
        assert_eq!(both.list.len(), 2);
    }

    #[test]
    fn numbers_that_count_from_one_are_reported_once() {
        let text = resolve("3\n1, 0\n3, 1\n6, 5\n").unwrap_err().to_string();
        assert_eq!(
            text,
            "error: m.cons:4: marker 3: the source has no vertex 6: expected 0 to 5; none of them is vertex 0, so the \
             numbers of the source seem to count from 1\n  hint: subtract 1 from each number of the source, or convert \
             the markers from numbers that count from 1"
        );
        let remedy = resolve("3\n1, 0\n3, 1\n6, 5\n").unwrap_err().list[0].remedy.clone().unwrap();
        assert_eq!((remedy.action, remedy.argument.as_str()), (FROM_ONE, "source"));
        // Where vertex 0 is named, it counts from 0 and is wrong.
        assert!(!resolve("3\n0, 0\n3, 1\n6, 5\n").unwrap_err().to_string().contains("count from 1"));
    }

    #[test]
    fn triangles_in_place_of_vertices_are_reported_once() {
        // A fan of 8 triangles around a vertex, then each of them twice: 9 vertices, 16 triangles.
        let mut positions = vec![Point3::origin()];
        positions.extend((0..8).map(|k| Point3::new(f64::from(k).cos(), f64::from(k).sin(), 0.0)));
        let fan: Vec<_> = (0..8).map(|k| [0, 1 + k, 1 + (k + 1) % 8]).collect();
        let mesh = Mesh::from_triangles(positions, &[&fan[..], &fan[..]].concat());
        let surface = Surface::new(&mesh).unwrap();
        let file = cons::parse(Path::new("m.cons"), "3\n1, 0\n12, 1\n15, 2\n").unwrap();
        let failure = file.resolve(both(&mesh, &surface)).unwrap_err();
        assert_eq!(failure.list.len(), 1);
        assert_eq!(
            failure.list[0].message,
            "marker 2: the source has no vertex 12: expected 0 to 8; so it is with 2 of 3; all are below the number of its \
             triangles, 16, so they may be triangles"
        );
    }
}
