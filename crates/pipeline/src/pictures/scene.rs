//! Meshes and poses for the 3D view of a page.

use mimesh_core::{mesh::Surface, stage::Measured};
use nalgebra::{Point3, Vector3};

use super::{Camera, drawing::on_surface};
use crate::{
    page::{Coordinates, SceneField, SceneMesh, ScenePose},
    text::thousands,
};

/// The most triangles that a mesh may have for a page that holds it and its poses.
const MAX_TRIANGLES: usize = 200_000;

/// Why a page does not show source and target in 3D, which have so many triangles; `None` if it does.
pub fn too_large_to_turn(triangles: [usize; 2]) -> Option<String> {
    let (name, count) = ["source", "target"].into_iter().zip(triangles).find(|(_, count)| *count > MAX_TRIANGLES)?;
    Some(format!(
        "The report has no 3D view: the {name} has {} triangles, more than {}. A simpler mesh has one.",
        thousands(count),
        thousands(MAX_TRIANGLES)
    ))
}

/// Turns a mesh as pictures see it from the front: x to the right, y up, z towards the eye. Its rest has a diagonal of 1 and lies about
/// the origin.
#[derive(Clone, Copy, Debug)]
pub(super) struct SceneFrame {
    axes: [Vector3<f64>; 3],
    centre: Vector3<f64>,
    scale: f64,
}

impl SceneFrame {
    /// The frame of a mesh that `camera` looks at.
    pub fn new(surface: &Surface, camera: Camera) -> Self {
        let (mut low, mut high) = (Vector3::repeat(f64::INFINITY), Vector3::repeat(f64::NEG_INFINITY));
        for position in &surface.positions {
            low = low.inf(&position.coords);
            high = high.sup(&position.coords);
        }
        let diagonal = (high - low).norm();
        let scale = if diagonal > 0.0 { 1.0 / diagonal } else { 1.0 };
        Self { axes: camera.axes(), centre: 0.5 * (low + high), scale }
    }

    /// Positions in the frame.
    pub fn coordinates(&self, positions: &[Point3<f64>]) -> Coordinates {
        let place = |position: &Point3<f64>| {
            let from_centre = (position.coords - self.centre) * self.scale;
            self.axes.map(|axis| axis.dot(&from_centre))
        };
        Coordinates::new(&positions.iter().map(place).collect::<Vec<_>>())
    }

    /// The mesh at rest.
    pub fn mesh(&self, surface: &Surface) -> SceneMesh {
        let polygons = &surface.polygon_of;
        let continues = (0..surface.triangles.len())
            .map(|t| t > 0 && polygons.get(t).is_some_and(|own| polygons.get(t - 1) == Some(own)));
        SceneMesh {
            rest: self.coordinates(&surface.positions),
            triangles: surface.triangles.clone(),
            continues: continues.collect(),
        }
    }
}

/// A pose, with the field by which its pictures are coloured.
pub(super) fn scene_pose(
    name: &str,
    [of_source, of_target]: [&SceneFrame; 2],
    source: Option<&[Point3<f64>]>,
    result: &[Point3<f64>],
    target: &Surface,
    measured: Option<&Measured>,
) -> ScenePose {
    let field = measured.map(|measured| {
        SceneField::new(&on_surface(target, &measured.field), measured.field_high, measured.field_unit)
    });
    ScenePose {
        name: name.into(),
        source: source.map(|source| of_source.coordinates(source)),
        result: of_target.coordinates(result),
        field,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_meshes_are_named() {
        assert_eq!(too_large_to_turn([200_000, 200_000]), None);
        let sentence = too_large_to_turn([12, 200_001]).unwrap();
        assert!(sentence.contains("the target has 200,001 triangles, more than 200,000"), "{sentence}");
    }
}
