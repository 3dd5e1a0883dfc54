//! Laws of the weights, and known answers on small meshes.

use mimesh_core::{
    Figures,
    linalg::{Assembly, FixedUnknowns},
    mesh::{Mesh, Part, Surface, SurfacePoint},
    operators::{cotangent_laplacian, voronoi_mass},
    plugin::instances,
    stage::{HandleWeights, Link, ProximityGraph, Weights},
    testkit::{contracts, meshes, random::Random},
};
use mimesh_weights as _;
use nalgebra::{DMatrix, DVector, Point3, Vector3};

const ALL: [&str; 4] = ["biharmonic", "bounded_biharmonic", "geodesic_falloff", "harmonic"];

fn stage(settings: &str) -> Box<dyn Weights> {
    let text = if settings.starts_with('{') { settings.into() } else { format!(r#"{{ "type": "{settings}" }}"#) };
    serde_json::from_str(&text).unwrap()
}

fn solve(settings: &str, surface: &Surface, handles: &[u32]) -> HandleWeights {
    let points: Vec<_> = handles.iter().map(|&v| SurfacePoint::Vertex(v)).collect();
    let bound = stage(settings).bind(surface, &points, None).unwrap();
    bound.solve(&(0..handles.len()).collect::<Vec<_>>()).unwrap()
}

fn refusal(settings: &str, surface: &Surface, handles: &[u32]) -> String {
    let points: Vec<_> = handles.iter().map(|&v| SurfacePoint::Vertex(v)).collect();
    let bound = match stage(settings).bind(surface, &points, None) {
        Ok(bound) => bound,
        Err(error) => return error.to_string(),
    };
    bound.solve(&(0..handles.len()).collect::<Vec<_>>()).unwrap_err().to_string()
}

/// A bar with uneven, partly obtuse triangles: 86 vertices.
fn uneven_bar() -> Surface {
    let mut surface = meshes::bar([9, 3, 2], [3.0, 0.9, 0.7]);
    let mut random = Random::new(3);
    surface.positions.iter_mut().for_each(|p| *p += random.vector() * 0.08);
    surface
}

const HANDLES: [u32; 5] = [0, 17, 40, 66, 80];

/// L M⁻¹ L as a dense matrix, by the definition.
fn dense_bilaplacian(surface: &Surface) -> DMatrix<f64> {
    let n = surface.vertex_count();
    let mut l = DMatrix::zeros(n, n);
    for (i, j, &value) in cotangent_laplacian(&surface.positions, &surface.triangles).triplet_iter() {
        (l[(i, j)], l[(j, i)]) = (value, value);
    }
    let mass = DVector::from_vec(voronoi_mass(&surface.positions, &surface.triangles));
    &l * DMatrix::from_diagonal(&mass.map(|m| 1.0 / m)) * l
}

/// The sum over free vertices of what a step to a bound could gain, i.e. the duality gap of 0 ≤ w ≤ 1.
fn gap(q: &DMatrix<f64>, w: &DVector<f64>, held: &[u32]) -> f64 {
    let g = q * w;
    let free = (0..w.len()).filter(|&i| !held.contains(&(i as u32)));
    free.map(|i| (g[i] * w[i]).max(g[i] * (w[i] - 1.0))).sum()
}

#[test]
fn all_weights_keep_their_contract() {
    assert_eq!(instances::<dyn Weights>().iter().map(|(name, _)| *name).collect::<Vec<_>>(), ALL);
    instances::<dyn Weights>().iter().for_each(|(name, stage)| contracts::weights(name, &**stage));
}

#[test]
fn bounded_weights_fulfil_the_conditions_of_the_minimum() {
    let surface = uneven_bar();
    let q = dense_bilaplacian(&surface);
    for tolerance in [1e-3, 1e-6, 1e-9] {
        let settings = format!(r#"{{ "type": "bounded_biharmonic", "normalize": "none", "tolerance": {tolerance} }}"#);
        let found = solve(&settings, &surface, &HANDLES);
        assert!(found.figures.warnings.is_empty(), "{:?}", found.figures);
        assert!(found.matrix.min() == 0.0 && found.matrix.max() == 1.0, "bounds are exact");
        for (k, w) in found.matrix.column_iter().enumerate() {
            let w = w.into_owned();
            let energy = 0.5 * w.dot(&(&q * &w));
            let reported = found.figures.values["energies"][k].as_f64().unwrap();
            // The dense product loses some digits.
            assert!((reported / energy - 1.0).abs() < 1e-9, "{reported} and {energy}");
            assert!(gap(&q, &w, &HANDLES) <= tolerance * energy * 1.01, "handle {k} at tolerance {tolerance:e}");
        }
    }
}

#[test]
fn several_choices_of_handles_have_the_weights_that_each_has_alone() {
    let surface = uneven_bar();
    let points: Vec<_> = (0..24).map(|k| SurfacePoint::Vertex(3 * k)).collect();
    let choices: [&[usize]; 5] =
        [&[0, 5, 9, 14, 20], &[1, 2, 3, 4, 6, 7, 8, 11, 13, 17, 23], &[4, 4], &[20, 14, 9, 5, 0], &[2, 19]];
    for settings in [
        r#"{ "type": "bounded_biharmonic" }"#,
        r#"{ "type": "bounded_biharmonic", "normalize": "exact" }"#,
        r#"{ "type": "bounded_biharmonic", "solver": "active_sets" }"#,
        r#"{ "type": "harmonic" }"#,
    ] {
        let bound = stage(settings).bind(&surface, &points, None).unwrap();
        let together = bound.solve_all(&choices);
        assert_eq!(together.len(), choices.len());
        for (choice, found) in choices.into_iter().zip(together) {
            match (bound.solve(choice), found) {
                (Ok(alone), Ok(found)) => {
                    assert!(alone.matrix == found.matrix, "{settings}: {choice:?}");
                    assert_eq!(alone.figures.values, found.figures.values);
                }
                (alone, found) => assert_eq!(alone.unwrap_err().to_string(), found.unwrap_err().to_string()),
            }
        }
        assert!(bound.solve_all(&[]).is_empty());
    }
}

#[test]
fn bounded_weights_are_those_of_plain_coordinate_descent() {
    let surface = uneven_bar();
    let q = dense_bilaplacian(&surface);
    let settings = r#"{ "type": "bounded_biharmonic", "normalize": "none", "tolerance": 1e-9 }"#;
    let found = solve(settings, &surface, &HANDLES).matrix;
    let mut bounds_met = 0;
    for (k, handle) in HANDLES.into_iter().enumerate() {
        let mut w = DVector::zeros(surface.vertex_count());
        w[handle as usize] = 1.0;
        let mut sweeps = 0;
        while gap(&q, &w, &HANDLES) > 1e-10 * w.dot(&(&q * &w)) {
            for _ in 0..100 {
                for i in (0..w.len()).filter(|&i| !HANDLES.contains(&(i as u32))) {
                    let gradient = q.column(i).dot(&w);
                    w[i] = (w[i] - gradient / q[(i, i)]).clamp(0.0, 1.0);
                }
            }
            sweeps += 100;
            assert!(sweeps < 200_000, "coordinate descent is slow but sure");
        }
        bounds_met += w.iter().filter(|x| **x == 0.0 || **x == 1.0).count() - HANDLES.len();
        let difference = (found.column(k) - &w).amax();
        // The square root of the gap, times what the softest mode allows.
        assert!(difference < 1e-4, "handle {k}: {difference:e} after {sweeps} sweeps");
    }
    assert!(bounds_met > 10, "{bounds_met}: without bounds that matter this says little");
}

#[test]
fn weights_that_are_solved_for_together_fulfil_the_conditions_of_their_minimum() {
    let surface = uneven_bar();
    let q = dense_bilaplacian(&surface);
    let settings = r#"{ "type": "bounded_biharmonic", "normalize": "exact", "tolerance": 1e-6 }"#;
    let found = solve(settings, &surface, &HANDLES);
    assert!(found.figures.warnings.is_empty(), "{:?}", found.figures);
    let (w, gradient) = (&found.matrix, &q * &found.matrix);
    assert!(w.min() >= 0.0 && w.max() <= 1.0, "{} to {}", w.min(), w.max());
    let energy = |w: &DMatrix<f64>| 0.5 * w.dot(&(&q * w));
    let mut gap = 0.0;
    for v in (0..surface.vertex_count()).filter(|&v| !HANDLES.contains(&(v as u32))) {
        assert!((w.row(v).sum() - 1.0).abs() < 1e-12, "{}", w.row(v).sum());
        // What the best corner of the simplex could gain to first order.
        gap += w.row(v).dot(&gradient.row(v)) - gradient.row(v).min();
    }
    assert!(gap <= 1.01e-6 * energy(w), "{gap:e} of {}", energy(w));
    let divided = solve("bounded_biharmonic", &surface, &HANDLES).matrix;
    assert!(energy(w) < energy(&divided), "dividing rows afterwards is not as smooth");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert!(pool.install(|| solve(settings, &surface, &HANDLES)).matrix == found.matrix, "on one thread or many");
    contracts::weights("bounded_biharmonic, exact", &*stage(settings));
}

#[test]
fn closed_forms_are_what_a_direct_solution_gives() {
    let surface = uneven_bar();
    let q = dense_bilaplacian(&surface);
    let n = surface.vertex_count();
    let mut assembly = Assembly::new(n);
    (0..n).for_each(|i| (0..=i).for_each(|j| assembly.add(i, j, q[(i, j)])));
    let laplacian = cotangent_laplacian(&surface.positions, &surface.triangles);
    for (name, lower) in [("biharmonic", assembly.finish()), ("harmonic", laplacian)] {
        let direct = FixedUnknowns::new(&lower, &HANDLES, "the test").unwrap();
        let values: Vec<f64> = DMatrix::<f64>::identity(5, 5).as_slice().to_vec();
        let direct = DMatrix::from_vec(n, 5, direct.solve(&vec![0.0; 5 * n], &values, 5));
        let points: Vec<_> = (0..n as u32).map(SurfacePoint::Vertex).collect();
        let bound = stage(name).bind(&surface, &points, None).unwrap();
        let found = bound.solve(&HANDLES.map(|v| v as usize)).unwrap();
        // Through one factorisation on either side.
        assert!((&found.matrix - &direct).amax() < 1e-9, "{name}: {:e}", (found.matrix - direct).amax());
        let w = found.matrix.column(0);
        let energy = 0.5 * if name == "biharmonic" { w.dot(&(&q * w)) } else { dirichlet(&surface, &w.into_owned()) };
        let reported = found.figures.values["energies"][0].as_f64().unwrap();
        assert!((reported / energy - 1.0).abs() < 1e-8, "{name}: {reported} and {energy}");
    }
}

fn dirichlet(surface: &Surface, w: &DVector<f64>) -> f64 {
    let laplacian = cotangent_laplacian(&surface.positions, &surface.triangles);
    let term = |(i, j, &value): (usize, usize, &f64)| value * w[i] * w[j] * if i == j { 1.0 } else { 2.0 };
    laplacian.triplet_iter().map(term).sum()
}

#[test]
fn neither_size_nor_place_changes_weights() {
    let surface = uneven_bar();
    let mut moved = surface.clone();
    let motion = Random::new(8).rigid_motion(5.0);
    moved.positions.iter_mut().for_each(|p| *p = motion * Point3::from(p.coords * 1000.0));
    for name in ALL {
        let (a, b) = (solve(name, &surface, &HANDLES).matrix, solve(name, &moved, &HANDLES).matrix);
        let difference = (a - b).amax();
        assert!(difference < 1e-9, "{name}: {difference:e}");
    }
}

#[test]
fn a_symmetric_mesh_has_symmetric_weights() {
    let sphere = meshes::icosphere(2);
    let at = |p: Point3<f64>| sphere.positions.iter().position(|q| (q - p).norm() < 1e-9).unwrap();
    let mirrored: Vec<usize> = sphere.positions.iter().map(|p| at(Point3::new(-p.x, p.y, p.z))).collect();
    let first = (0..162).find(|&v| sphere.positions[v].x > 0.4).unwrap();
    let second = (0..162).find(|&v| sphere.positions[v].y < -0.8 && sphere.positions[v].x > 0.1).unwrap();
    let handles = [first, mirrored[first], second, mirrored[second]].map(|v| v as u32);
    assert!(handles[2] != handles[3], "all four differ");
    for name in ALL {
        let w = solve(name, &sphere, &handles).matrix;
        for v in 0..162 {
            for (k, other) in [(0, 1), (2, 3)] {
                let (here, there) = (w[(v, k)], w[(mirrored[v], other)]);
                // Vertices are eliminated in an order that is not symmetric.
                assert!((here - there).abs() < 1e-7, "{name}: vertex {v}: {here} and {there}");
            }
        }
    }
}

#[test]
fn bounded_and_harmonic_weights_and_distances_stay_within_0_and_1() {
    let (sphere, handles) = (meshes::icosphere(3), [0, 1, 100, 200, 300]);
    for name in ["bounded_biharmonic", "harmonic", "geodesic_falloff"] {
        let w = solve(name, &sphere, &handles).matrix;
        assert!(w.min() >= 0.0 && w.max() <= 1.0, "{name}: {} to {}", w.min(), w.max());
    }
    let w = solve("biharmonic", &sphere, &handles).matrix;
    assert!(w.min() < -0.01, "{}: unbounded weights overshoot, or bounds would not be needed", w.min());
}

#[test]
fn clamped_weights_stay_within_bounds_sum_to_one_and_keep_their_handles() {
    let surface = uneven_bar();
    let handles = [3, 20, 41, 60];
    let free = solve(r#"{ "type": "biharmonic" }"#, &surface, &handles).matrix;
    assert!(free.min() < -1e-3, "there is something to clamp: {}", free.min());
    let w = solve(r#"{ "type": "biharmonic", "clamp": true }"#, &surface, &handles).matrix;
    assert!(w.min() >= 0.0 && w.max() <= 1.0);
    for row in w.row_iter() {
        // Rounding of a quotient of sums of four.
        assert!((row.sum() - 1.0).abs() < 1e-12);
    }
    for (k, &v) in handles.iter().enumerate() {
        assert!((w[(v as usize, k)] - 1.0).abs() < 1e-9, "handle {k} has {}", w[(v as usize, k)]);
    }
}

#[test]
fn the_nearest_handle_has_the_greatest_weight_by_distance() {
    let grid = meshes::grid(10, 10);
    let w = solve("geodesic_falloff", &grid, &[0, 120]).matrix;
    for (v, p) in grid.positions.iter().enumerate() {
        let (near, far) = (p.coords.norm(), (Point3::new(1.0, 1.0, 0.0) - p).norm());
        assert!((near - far).abs() < 0.1 || (w[(v, 0)] > 0.5) == (near < far), "{p}");
    }
}

#[test]
fn triangles_without_area_and_edges_of_three_triangles_leave_weights_finite() {
    let mut surface = uneven_bar();
    let n = surface.vertex_count() as u32;
    // A fin on an edge, a corner twice, a flat triangle, a needle, two vertices at one place, and one that is tied to nothing else.
    let [a, b, c] = surface.triangles[12];
    let (p, q) = (surface.positions[a as usize], surface.positions[b as usize]);
    let middle = nalgebra::center(&p, &q);
    surface.positions.extend([p + Vector3::new(0.0, 0.5, 0.4), middle, middle + Vector3::x() * 1e-7, p, q]);
    surface.triangles.extend([[a, b, n], [c, c, a], [a, b, n + 1], [a, b, n + 2], [a, b, n + 3], [n + 3, n + 4, c]]);
    let surface = Surface::from_triangles(surface.positions, surface.triangles).unwrap();
    for name in ALL {
        let w = solve(name, &surface, &HANDLES).matrix;
        assert!(w.iter().all(|x| x.is_finite()), "{name}");
        for (v, row) in w.row_iter().enumerate() {
            assert!((row.sum() - 1.0).abs() < 1e-6, "{name}: vertex {v} has {}", row.sum());
        }
        // The vertex in the middle of an edge has weights between those of its ends.
        let (low, high) = (w.row(a as usize).inf(&w.row(b as usize)), w.row(a as usize).sup(&w.row(b as usize)));
        let inside = |v: u32| (w.row(v as usize) - &low).min() > -0.05 && (&high - w.row(v as usize)).min() > -0.05;
        assert!(inside(n + 1), "{name}: {} of {low} to {high}", w.row(n as usize + 1));
    }
}

#[test]
fn a_component_without_area_goes_with_the_nearest_vertex() {
    let bar = uneven_bar();
    let n = bar.vertex_count() as u32;
    let (mut positions, mut triangles) = (bar.positions.clone(), bar.triangles.clone());
    let near = bar.positions[30] + Vector3::new(0.0, 0.0, 0.01);
    positions.extend([near, near, near]);
    triangles.push([n, n + 1, n + 2]);
    let surface = Surface::from_triangles(positions, triangles).unwrap();
    for name in ALL {
        let w = solve(name, &surface, &HANDLES).matrix;
        (0..3).for_each(|k| assert_eq!(w.row(n as usize + k), w.row(30), "{name}"));
    }
}

#[test]
fn points_within_triangles_are_handles_at_their_nearest_corner() {
    let bar = uneven_bar();
    let [a, b, c] = bar.triangles[20];
    for name in ALL {
        let points = [SurfacePoint::Triangle(20, [0.2, 0.5, 0.3]), SurfacePoint::Vertex(0)];
        let w = stage(name).bind(&bar, &points, None).unwrap().solve(&[0, 1]).unwrap().matrix;
        assert!(w[(b as usize, 0)] == 1.0 && w[(a as usize, 0)] < 1.0 && w[(c as usize, 0)] < 1.0, "{name}");
    }
}

#[test]
fn stronger_bridges_hold_components_closer_together() {
    let two = meshes::two_components();
    let pairs = vec![[0, 42], [5, 47], [9, 51]];
    let link = Link { components: [0, 1], distance: 1.0, in_tree: true, stiffness: 1.0, pairs: pairs.clone() };
    let graph = ProximityGraph::new(two.components(), vec![link], Figures::default()).unwrap();
    let points = [3, 11, 70].map(SurfacePoint::Vertex);
    for name in ["bounded_biharmonic", "biharmonic", "harmonic"] {
        let mut last = f64::INFINITY;
        for bridge in [0.02, 0.2, 2.0] {
            let stage = stage(&format!(r#"{{ "type": "{name}", "bridge": {bridge} }}"#));
            let bound = stage.bind(&two, &points, Some(&graph)).unwrap();
            let w = bound.solve(&[0, 1, 2]).unwrap().matrix;
            let apart: f64 = pairs.iter().map(|p| (w.row(p[0] as usize) - w.row(p[1] as usize)).norm()).sum();
            assert!(apart < last, "{name} with {bridge}: {apart}, before {last}");
            last = apart;
            assert_eq!(bound.figures().number("bridges"), Some(3.0));
        }
        let none = stage(&format!(r#"{{ "type": "{name}", "bridge": 0.0 }}"#));
        assert!(none.bind(&two, &points, Some(&graph)).unwrap().solve(&[0, 1]).is_err(), "{name} is not bridged");
    }
}

#[test]
fn components_without_a_handle_are_named() {
    let two = meshes::two_components();
    let mut mesh = Mesh::from_triangles(two.positions.clone(), &two.triangles);
    mesh.parts = [("head", 0..80), ("jaw", 80..160)]
        .into_iter()
        .map(|(name, polygons)| Part { object: Some(name.into()), polygons, ..Part::default() })
        .collect();
    let surface = Surface::new(&mesh).unwrap();
    for name in ALL {
        let expected = "component without a handle: jaw (42 vertices, from vertex 42)";
        assert_eq!(refusal(name, &surface, &[3, 7]), expected, "{name}");
    }
}

#[test]
fn handles_that_cannot_be_are_refused_by_name() {
    let seamed = Surface::new(&meshes::seamed_cylinder(8, 3)).unwrap();
    for name in ALL {
        assert_eq!(refusal(name, &seamed, &[]), "no handle to give weights to", "{name}");
        // Vertices 0 and 8 of the file are one after welding.
        let welded = [0, 20, 8].map(|v: usize| seamed.vertex_of[v].unwrap());
        assert_eq!(refusal(name, &seamed, &welded), "points 0 and 2 lie at the same vertex, 0 (from 0)", "{name}");
        let expected = "point 1: the surface has no vertex 32: expected 0 to 31";
        assert_eq!(refusal(name, &seamed, &[0, 32]), expected, "{name}");
    }
}

#[test]
fn settings_out_of_range_are_named() {
    let bar = uneven_bar();
    for (settings, expected) in [
        (r#"{ "type": "bounded_biharmonic", "tolerance": 0 }"#, "tolerance: expected 0.000000000001 to 0.1, found 0"),
        (r#"{ "type": "bounded_biharmonic", "max_iterations": 0 }"#, "max_iterations: expected at least 1, found 0"),
        (r#"{ "type": "biharmonic", "bridge": -1 }"#, "bridge: expected at least 0, found -1"),
        (r#"{ "type": "geodesic_falloff", "power": 0.5 }"#, "power: expected 1 to 16, found 0.5"),
    ] {
        assert_eq!(refusal(settings, &bar, &[0, 1]), expected);
    }
}

#[test]
fn a_tolerance_that_is_not_reached_is_said() {
    let found = solve(r#"{ "type": "bounded_biharmonic", "max_iterations": 2 }"#, &uneven_bar(), &HANDLES);
    assert!(found.figures.warnings[0].contains("not solved to their tolerance"), "{:?}", found.figures.warnings);
    assert!(found.matrix.iter().all(|x| (0.0..=1.0).contains(x)), "within bounds all the same");
}

#[test]
fn a_vertex_for_every_handle_leaves_nothing_to_solve() {
    let tetrahedron = meshes::tetrahedron();
    for name in ALL {
        assert_eq!(solve(name, &tetrahedron, &[2, 0, 1, 3]).matrix.sum(), 4.0, "{name}");
        assert_eq!(solve(name, &tetrahedron, &[2]).matrix, DMatrix::from_element(4, 1, 1.0), "{name}");
    }
}
