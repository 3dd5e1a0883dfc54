//! Weights on real meshes, against what another program found.
//!
//! tests/DATA.md lists the meshes.

mod common;

use std::path::Path;

use common::{animals::animal, assert_at_most};
use mimesh::core::{
    Figures,
    mesh::{Surface, SurfacePoint},
    stage::{BoundWeights, Proximity, Sampler, Weights},
    testkit::data::{data, read_mesh},
};
use nalgebra::DMatrix;
use serde_json::json;

/// The default of `tolerance`: how far the energy of a handle may lie above the least, relative to it.
const TOLERANCE: f64 = 1e-6;

fn surface(path: &Path) -> Surface {
    Surface::new(&read_mesh(path).rest).unwrap()
}

/// The matrix of an NPY file of version 1 that holds doubles.
fn npy(path: &Path) -> DMatrix<f64> {
    let bytes = std::fs::read(path).expect("the file");
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = String::from_utf8_lossy(&bytes[10..start]).into_owned();
    assert!(bytes[..7] == *b"\x93NUMPY\x01" && header.contains("'<f8'"), "{header}");
    let shape = header.split(['(', ')']).nth(1).expect("a shape");
    let shape: Vec<usize> = shape.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    let values = bytes[start..].chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().expect("eight bytes")));
    if header.contains("'fortran_order': True") {
        DMatrix::from_iterator(shape[0], shape[1], values)
    } else {
        DMatrix::from_row_iterator(shape[0], shape[1], values)
    }
}

/// The handles, energies and weights (before rows are divided by their sums) that libigl found on bodies-2k.
struct Reference {
    surface: Surface,
    points: Vec<SurfacePoint>,
    energies: Vec<f64>,
    weights: DMatrix<f64>,
}

fn reference() -> Option<Reference> {
    let folder = data("bodies-2k")?;
    let surface = surface(&folder.join("source/rest.obj"));
    let text = std::fs::read_to_string(folder.join("bbw.json")).expect("handles and energies");
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let handles = json["handles"].as_array().expect("handles").iter().filter_map(|v| Some(v.as_u64()? as usize));
    let points = handles.map(|v| SurfacePoint::Vertex(surface.vertex_of[v].expect("a vertex of a polygon"))).collect();
    let energies = json["energy"].as_array().expect("energies").iter().filter_map(|e| e.as_f64()).collect();
    Some(Reference { surface, points, energies, weights: npy(&folder.join("bbw-weights.npy")) })
}

fn bind(settings: &str, surface: &Surface, points: &[SurfacePoint]) -> Box<dyn BoundWeights> {
    let stage: Box<dyn Weights> = serde_json::from_str(settings).unwrap();
    stage.bind(surface, points, None).unwrap()
}

fn solve(settings: &str, reference: &Reference) -> (DMatrix<f64>, Figures) {
    let all: Vec<usize> = (0..reference.points.len()).collect();
    let found = bind(settings, &reference.surface, &reference.points).solve(&all).unwrap();
    (found.matrix, found.figures)
}

fn each_row_over_its_sum(mut weights: DMatrix<f64>) -> DMatrix<f64> {
    weights.row_iter_mut().for_each(|mut row| row /= row.sum());
    weights
}

#[test]
fn bounded_biharmonic_weights_are_those_of_libigl_or_better() {
    let Some(reference) = reference() else { return };
    let (weights, figures) = solve(r#"{ "type": "bounded_biharmonic", "normalize": "none" }"#, &reference);
    let energies: Vec<f64> = figures.values["energies"].as_array().unwrap().iter().filter_map(|e| e.as_f64()).collect();
    for (k, (found, known)) in energies.iter().zip(&reference.energies).enumerate() {
        println!("handle {k}: energy {found}, relative to libigl {:.1e}", found / known - 1.0);
        assert!(*found <= known * (1.0 + TOLERANCE), "handle {k}: energy {found}, libigl has {known}");
        assert!(*found >= known * (1.0 - TOLERANCE), "handle {k}: energy {found} is below the least, {known}");
    }
    assert!(weights.min() == 0.0 && weights.max() == 1.0, "{} to {}", weights.min(), weights.max());
    for (k, point) in reference.points.iter().enumerate() {
        let SurfacePoint::Vertex(v) = *point else { unreachable!("handles are vertices") };
        for other in 0..reference.points.len() {
            assert_eq!(weights[(v as usize, other)], f64::from(u8::from(k == other)));
        }
    }
    assert!(figures.number("relative_gap").unwrap() <= TOLERANCE && figures.warnings.is_empty(), "{figures:?}");
    // The energy is quadratic about its least value, so weights agree to the square root of its tolerance.
    let difference = (&weights - &reference.weights).amax();
    assert_at_most("difference of weights", difference, TOLERANCE.sqrt(), 4.8e-4);

    // A sum of several weights differs by several such differences.
    let (normalised, _) = solve(r#"{ "type": "bounded_biharmonic" }"#, &reference);
    let difference = (&normalised - each_row_over_its_sum(reference.weights)).amax();
    assert_at_most("difference of weights over their sums", difference, 2.0 * TOLERANCE.sqrt(), 1.27e-3);
}

#[test]
fn unbounded_weights_are_near_bounded_ones_and_their_energy_is_lower() {
    let Some(reference) = reference() else { return };
    let (unbounded, figures) = solve(r#"{ "type": "biharmonic" }"#, &reference);
    for (found, bounded) in figures.values["energies"].as_array().unwrap().iter().zip(&reference.energies) {
        assert!(found.as_f64().unwrap() <= *bounded, "{found} and {bounded}: bounds only raise the energy");
    }
    let bounded = each_row_over_its_sum(reference.weights);
    let mean = (&unbounded - &bounded).abs().mean();
    // A twentieth of the range of weights: so near that `greedy` can rank candidates by unbounded ones.
    assert_at_most("mean difference of unbounded weights", mean, 0.05, 0.0160);
}

/// Vertices of a surface, each the farthest from those before.
fn spread(surface: &Surface, count: usize) -> Vec<SurfacePoint> {
    let sampler: Box<dyn Sampler> =
        serde_json::from_str(&format!(r#"{{ "type": "farthest_point", "count": {count} }}"#)).unwrap();
    sampler.sample(surface).unwrap()
}

/// The energies of active sets against those of the interior point, which proves its own to a tenth of the tolerance.
fn assert_same_minimum(name: &str, surface: &Surface, count: usize) {
    let points = spread(surface, count);
    let all: Vec<usize> = (0..count).collect();
    let solve = |settings: &str| bind(settings, surface, &points).solve(&all).unwrap();
    let exact = solve(r#"{ "type": "bounded_biharmonic", "solver": "interior_point", "tolerance": 1e-7 }"#);
    let found = solve(r#"{ "type": "bounded_biharmonic", "solver": "active_sets" }"#);
    assert!(found.figures.warnings.is_empty(), "{name}: {:?}", found.figures);
    assert!(found.matrix.min() == 0.0 && found.matrix.max() == 1.0, "{name}");
    let energies = |figures: &Figures| -> Vec<f64> {
        figures.values["energies"].as_array().unwrap().iter().filter_map(|e| e.as_f64()).collect()
    };
    let (found_energies, exact_energies) = (energies(&found.figures), energies(&exact.figures));
    let above = found_energies.iter().zip(&exact_energies).map(|(found, exact)| found / exact - 1.0);
    let most = above.fold(f64::NEG_INFINITY, f64::max);
    println!("{name}, {count} handles: {most:.1e} above");
    assert!(most <= TOLERANCE, "{name}: {most:.1e} above the least");
    let gap = found.figures.number("relative_gap").unwrap();
    // The bound overstates, but not to where it would warn.
    assert!(most <= gap + TOLERANCE / 10.0 && gap < 1e-2, "{name}: {most:.1e}, reported {gap:.1e}");
}

#[test]
fn a_body_of_13348_vertices_is_solved_to_the_same_tolerance() {
    let Some(rest) = data("bodies/source/rest.obj") else { return };
    let surface = surface(&rest);
    assert_eq!(surface.vertex_count(), 13_348);
    assert_same_minimum("body", &surface, 6);
}

#[test]
fn made_animals_are_solved_to_the_same_tolerance() {
    for settings in [json!({}), json!({ "resolution": 50 })] {
        let surface = Surface::new(&animal(settings).rest).unwrap();
        [12, 64].iter().for_each(|&count| assert_same_minimum("animal", &surface, count));
    }
}

#[test]
fn a_camel_with_edges_of_many_triangles_has_finite_weights() {
    let Some(camel) = data("sumner-camel-poses/camel-reference.obj") else { return };
    let surface = surface(&camel);
    let points = spread(&surface, 4);
    for settings in [
        r#"{ "type": "bounded_biharmonic", "tolerance": 1e-3 }"#,
        r#"{ "type": "biharmonic" }"#,
        r#"{ "type": "harmonic" }"#,
        r#"{ "type": "geodesic_falloff" }"#,
    ] {
        let found = bind(settings, &surface, &points).solve(&[0, 1, 2, 3]).unwrap();
        assert!(found.figures.warnings.is_empty(), "{settings}: {:?}", found.figures);
        for row in found.matrix.row_iter() {
            // The bilaplacian has the squared condition of the Laplacian, which on 21,887 vertices leaves about half of the digits.
            assert!((row.sum() - 1.0).abs() < 1e-6, "{settings}: {}", row.sum());
        }
    }
}

#[test]
fn stones_without_a_handle_take_weights_over_bridges() {
    let Some(stones) = data("pebble-camel/rest.obj") else { return };
    let surface = surface(&stones);
    let tree: Box<dyn Proximity> = serde_json::from_str(r#"{ "type": "spanning_tree" }"#).unwrap();
    let graph = tree.proximity(&surface).unwrap();
    let points: Vec<_> = (0..12).map(|k| SurfacePoint::Vertex(k * (surface.vertex_count() as u32 / 12))).collect();
    for settings in [r#"{ "type": "bounded_biharmonic", "tolerance": 1e-2 }"#, r#"{ "type": "biharmonic" }"#] {
        let stage: Box<dyn Weights> = serde_json::from_str(settings).unwrap();
        let all: Vec<usize> = (0..12).collect();
        let found = stage.bind(&surface, &points, Some(&graph)).unwrap().solve(&all).unwrap();
        assert!(found.figures.warnings.is_empty(), "{settings}: {:?}", found.figures);
        for row in found.matrix.row_iter() {
            // As on the camel.
            assert!((row.sum() - 1.0).abs() < 1e-6, "{settings}: {}", row.sum());
        }
        let alone = stage.bind(&surface, &points, None).unwrap().solve(&all).unwrap_err().to_string();
        assert!(alone.starts_with("components without a handle: "), "{alone}");
    }
}
