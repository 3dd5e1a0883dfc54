//! Meshes to put markers on.

// Each test file uses a part of it.
#![allow(dead_code)]

use std::path::Path;

use mimesh_core::{
    mesh::{Mesh, Surface},
    stage::ScenePoint,
    testkit::meshes,
};
use mimesh_markers::{MarkerMesh, MeshRole, ScenePoints};
use nalgebra::Point3;

/// No file is a scene.
pub struct NoScenes;

impl ScenePoints for NoScenes {
    fn scene_points(&self, _: &Path) -> Option<mimesh_core::Result<Vec<ScenePoint>>> {
        None
    }
}

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
    meshes::ellipsoid(8, 12)
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
