//! Regions and maps of handles on a real body with known weights, in figures.
//!
//! tests/DATA.md lists the mesh.

mod common;

use std::path::Path;

use common::assert_at_most;
use mimesh::core::{
    Figures,
    mesh::Surface,
    stage::{Clusterer, Deformer, HandleWeights, Regions},
    testkit::data::{data, read_mesh},
};
use nalgebra::{DMatrix, Point3};
use serde_json::json;

/// A body with six poses and bounded biharmonic weights of 12 handles.
struct Body {
    surface: Surface,
    poses: Vec<Vec<Point3<f64>>>,
    weights: HandleWeights,
}

impl Body {
    fn read() -> Option<Self> {
        let folder = data("bodies-2k")?;
        let read = |name: &str| read_mesh(folder.join(format!("source/{name}.obj"))).rest;
        let surface = Surface::new(&read("rest")).expect("a surface");
        let poses = ["bow", "crouch", "kick", "reach", "stride", "twist"].map(|name| read(name).positions).to_vec();
        let mut matrix = rows_of_12(&folder.join("bbw-weights.npy"));
        matrix.row_iter_mut().for_each(|mut row| row /= row.sum());
        Some(Self { surface, poses, weights: HandleWeights { matrix, figures: Figures::default() } })
    }

    /// Mean distance from the rest mesh to a pose in percent of the diagonal, over all poses: 13.9.
    fn rest_baseline(&self) -> f64 {
        let rest = &self.surface.positions;
        let distance = |pose: &Vec<Point3<f64>>| rest.iter().zip(pose).map(|(p, q)| (p - q).norm()).sum::<f64>();
        let count = (rest.len() * self.poses.len()) as f64;
        100.0 * self.poses.iter().map(distance).sum::<f64>() / count / self.surface.diagonal()
    }

    fn regions(&self, clusterer: &str) -> Regions {
        let stage: Box<dyn Clusterer> = serde_json::from_value(json!({ "type": clusterer })).expect("settings");
        let bound = stage.bind(&self.surface, &self.poses).expect("poses of the surface");
        bound.cluster(&self.weights.matrix).expect("weights of the surface")
    }

    /// Mean distance to the pose in percent of the diagonal and energies by iteration, for each pose.
    fn fits(&self, regions: &Regions, settings: serde_json::Value) -> Vec<(f64, Vec<f64>)> {
        let stage: Box<dyn Deformer> = serde_json::from_value(settings).expect("settings");
        let skin = stage.bind(&self.surface).and_then(|bound| bound.skin(&self.weights, regions)).expect("a skin");
        let fit = |pose: &Vec<Point3<f64>>| {
            let figures = skin.fit(pose).expect("a fit").figures;
            let energies = figures.values.get("energies").and_then(|e| e.as_array().cloned()).unwrap_or_default();
            let distance = figures.number("mean_distance_percent").expect("a distance");
            (distance, energies.iter().filter_map(|e| e.as_f64()).collect())
        };
        self.poses.iter().map(fit).collect()
    }
}

/// An array of 64-bit floats, row by row, of NumPy's format 1.0.
fn rows_of_12(path: &Path) -> DMatrix<f64> {
    let bytes = std::fs::read(path).expect("an array");
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let numbers = bytes[start..].as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b));
    DMatrix::from_row_iterator((bytes.len() - start) / 8 / 12, 12, numbers)
}

/// The mean over the poses of the distances in [`Body::fits`].
fn mean_distance(fits: &[(f64, Vec<f64>)]) -> f64 {
    fits.iter().map(|(distance, _)| distance).sum::<f64>() / fits.len() as f64
}

#[test]
fn twelve_handles_follow_six_poses_of_a_body() {
    let Some(body) = Body::read() else { return };
    let (by_weight, by_rotation) = (body.regions("weight_kmeans"), body.regions("rotation_kmeans"));
    assert_eq!((by_weight.count, by_rotation.count), (12, 12));
    let distance = |regions, settings| mean_distance(&body.fits(regions, settings));
    // Without rigidity the maps are a least-squares solution: the handles and poses alone decide how near it comes.
    let closest = distance(&by_rotation, json!({ "type": "linear_blend" }));
    assert_at_most("linear_blend", closest, 0.25, 0.2456);
    assert_at_most("linear_blend, part of the motion", closest / body.rest_baseline(), 0.02, 0.0176);
    let mut energy = Vec::new();
    // Rigidity costs some of the closeness, less where regions know the poses.
    for (name, regions, cost, measured) in [("W", &by_weight, 1.12, 0.2675), ("W'", &by_rotation, 1.08, 0.2596)] {
        let fits = body.fits(regions, json!({ "type": "arap_skinning", "lambda": 0.5 }));
        assert!(mean_distance(&fits) > closest, "{name}: nearer than the nearest");
        assert_at_most(name, mean_distance(&fits), cost * closest, measured);
        for (_, energies) in &fits {
            // Each step lowers the energy, and a dozen iterations suffice.
            assert_at_most(&format!("{name}, iterations"), energies.len() as f64, 12.0, 7.0);
            assert!(energies.is_sorted_by(|a, b| a >= b), "{name}: {energies:?}");
        }
        energy.push(fits.iter().filter_map(|(_, energies)| energies.last()).sum::<f64>());
    }
    // Regions that know the poses move more rigidly.
    assert_at_most("energy of W' over that of W", energy[1] / energy[0], 0.8, 0.714);
    // Held at the handles alone the maps do not follow (figure 7 of the paper), less so with regions by W.
    let held = [&by_weight, &by_rotation]
        .map(|regions| distance(regions, json!({ "type": "arap_skinning", "difference": "none" })));
    assert!(held.iter().all(|held| *held > 4.0 * closest), "E_diff is not needed: {held:?} %");
    assert_at_most("W', E_diff off", held[1], held[0].min(1.3), 1.2212);
}
