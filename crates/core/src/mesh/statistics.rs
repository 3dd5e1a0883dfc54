use std::collections::HashSet;

use nalgebra::Point3;
use serde::Serialize;

use super::{Mesh, Surface, inward_components};
use crate::{Result, operators::is_degenerate};

/// Counts and sizes of a mesh, and its defects that a solver may stumble over.
#[derive(Clone, Debug, Serialize)]
pub struct Statistics {
    /// Vertices of the file.
    pub vertices: usize,
    /// Polygons of the file.
    pub polygons: usize,
    /// Polygons with 3, 4 and more corners.
    pub triangles_quads_ngons: [usize; 3],
    /// Triangles after cutting polygons into fans.
    pub triangles: usize,
    /// Vertices after welding seams, with those that no face uses.
    pub welded_vertices: usize,
    /// Vertices of each connected component, in order of first vertex.
    pub component_sizes: Vec<usize>,
    /// Edges of one triangle, after welding.
    pub boundary_edges: usize,
    /// Edges of more than two triangles, after welding.
    pub non_manifold_edges: usize,
    /// Triangles without area, which operators skip ([`is_degenerate`]).
    pub degenerate_triangles: usize,
    /// Polygons whose set of corners an earlier polygon has.
    pub duplicate_polygons: usize,
    /// Vertices that no face uses.
    pub unreferenced_vertices: usize,
    /// Vertices at exactly the place of an earlier one, welded or not.
    pub coincident_vertices: usize,
    /// Smallest and largest corner of the bounding box of the faces.
    pub bounding_box: [[f64; 3]; 2],
    /// Length of its diagonal.
    pub diagonal: f64,
    /// Area of all triangles.
    pub area: f64,
    /// The components whose triangles point inwards ([`inward_components`]), by their places in `component_sizes`.
    pub inward_components: Vec<u32>,
    /// Volume enclosed, positive if triangles face outwards; only if there is no boundary.
    pub volume: Option<f64>,
}

impl Statistics {
    /// Looks at `mesh`.
    ///
    /// # Errors
    ///
    /// The errors of [`Mesh::validate`].
    pub fn new(mesh: &Mesh) -> Result<Self> {
        let surface = Surface::new(mesh)?;
        let topology = surface.topology();
        let (low, high) = mesh.bounding_box_of(&mesh.positions);
        let diagonal = (high - low).norm();
        let mut corner_counts = [0; 3];
        let mut seen = HashSet::new();
        let mut duplicate_polygons = 0;
        for corners in mesh.polygons.iter() {
            if corners.len() >= 3 {
                corner_counts[corners.len().min(5) - 3] += 1;
            }
            let mut sorted = corners.to_vec();
            sorted.sort_unstable();
            duplicate_polygons += usize::from(!seen.insert(sorted));
        }
        let places: HashSet<_> = mesh.positions.iter().map(|p| [p.x, p.y, p.z].map(|x| (x + 0.0).to_bits())).collect();
        let area_normals = surface.area_normals(&surface.positions);
        let corners = (0..surface.triangle_count()).map(|t| surface.corners(&surface.positions, t));
        let degenerate = corners.filter(is_degenerate);
        let centre = nalgebra::center(&low, &high);
        let volume = surface.triangles.iter().zip(&area_normals).map(|(t, n)| {
            let corner: Point3<f64> = surface.positions[t[0] as usize];
            (corner - centre).dot(n) / 6.0
        });
        Ok(Self {
            vertices: mesh.positions.len(),
            polygons: mesh.polygons.len(),
            triangles_quads_ngons: corner_counts,
            triangles: surface.triangle_count(),
            welded_vertices: surface.vertex_count() + surface.strays.len(),
            component_sizes: surface.components().sizes,
            boundary_edges: topology.boundary.len(),
            non_manifold_edges: topology.non_manifold.len(),
            degenerate_triangles: degenerate.count(),
            duplicate_polygons,
            unreferenced_vertices: surface.strays.len(),
            coincident_vertices: mesh.positions.len() - places.len(),
            bounding_box: [low.into(), high.into()],
            diagonal,
            area: area_normals.iter().map(|n| n.norm() / 2.0).sum(),
            inward_components: inward_components(&surface),
            volume: topology.boundary.is_empty().then(|| volume.sum()),
        })
    }
}
