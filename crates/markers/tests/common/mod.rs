//! Meshes to put markers on.

use mimesh_core::mesh::{Mesh, Surface};
use mimesh_markers::{MarkerMesh, MeshRole};
use nalgebra::Point3;

/// A mesh with its surface.
pub struct Meshed {
    pub mesh: Mesh,
    pub surface: Surface,
}

impl Meshed {
    pub fn new(positions: Vec<Point3<f64>>, triangles: &[[u32; 3]]) -> Self {
        let mesh = Mesh::from_triangles(positions, triangles);
        let surface = Surface::new(&mesh).unwrap();
        Self { mesh, surface }
    }

    pub fn on(&self, role: MeshRole) -> MarkerMesh<'_> {
        MarkerMesh { role, mesh: &self.mesh, surface: &self.surface }
    }
}

/// A sphere of 8 × 12 quads stretched by 1, 2 and 3, exactly symmetric across x = 0; 86 vertices, 168 triangles.
pub fn ellipsoid() -> (Vec<Point3<f64>>, Vec<[u32; 3]>) {
    const RINGS: usize = 8;
    const SECTORS: usize = 12;
    let mut positions = vec![Point3::new(0.0, 0.0, 3.0), Point3::new(0.0, 0.0, -3.0)];
    for ring in 1..RINGS {
        let polar = std::f64::consts::PI * ring as f64 / RINGS as f64;
        for sector in 0..SECTORS {
            // One half is computed, the other its mirror image, so that symmetry holds to the last bit.
            let half = SECTORS / 2;
            let (k, sign) = if sector < half { (sector, 1.0) } else { (SECTORS - 1 - sector, -1.0) };
            let angle = std::f64::consts::PI * ((k as f64 + 0.5) / half as f64 - 0.5);
            let x = sign * polar.sin() * angle.cos();
            positions.push(Point3::new(x, 2.0 * polar.sin() * angle.sin(), 3.0 * polar.cos()));
        }
    }
    let at = |ring: usize, sector: usize| (2 + (ring - 1) * SECTORS + sector % SECTORS) as u32;
    let mut triangles = Vec::new();
    for sector in 0..SECTORS {
        triangles.push([0, at(1, sector), at(1, sector + 1)]);
        triangles.push([1, at(RINGS - 1, sector + 1), at(RINGS - 1, sector)]);
        for ring in 1..RINGS - 1 {
            let [a, b] = [at(ring, sector), at(ring + 1, sector)];
            let [c, d] = [at(ring + 1, sector + 1), at(ring, sector + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    (positions, triangles)
}

/// The ellipsoid, `factor` times as large, with each vertex moved along its radius by a share in `dents`.
pub fn dented(factor: f64, dents: &[f64]) -> Meshed {
    let (mut positions, triangles) = ellipsoid();
    for (i, p) in positions.iter_mut().enumerate() {
        *p *= factor * (1.0 + dents[i % dents.len()]);
    }
    Meshed::new(positions, &triangles)
}

/// The ellipsoid as source, and as target twice as large.
pub fn pair() -> [Meshed; 2] {
    [dented(1.0, &[0.0]), dented(2.0, &[0.0])]
}

pub fn both(pair: &[Meshed; 2]) -> [MarkerMesh<'_>; 2] {
    [pair[0].on(MeshRole::Source), pair[1].on(MeshRole::Target)]
}
