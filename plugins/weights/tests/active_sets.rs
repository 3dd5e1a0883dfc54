//! Active sets against the interior point: two methods, one minimum.

use mimesh_core::{
    Figures,
    mesh::{Surface, SurfacePoint},
    stage::{HandleWeights, Link, ProximityGraph, Weights},
    testkit::{contracts, meshes, random::Random},
};
use mimesh_weights as _;
use nalgebra::{Point3, Vector3};

/// How far above the least an energy may lie by the default of `tolerance`.
const TOLERANCE: f64 = 1e-6;

fn stage(settings: &str) -> Box<dyn Weights> {
    serde_json::from_str(&format!(r#"{{ "type": "bounded_biharmonic", {settings} }}"#)).unwrap()
}

fn solve(settings: &str, surface: &Surface, handles: &[u32], graph: Option<&ProximityGraph>) -> HandleWeights {
    let points: Vec<_> = handles.iter().map(|&v| SurfacePoint::Vertex(v)).collect();
    let bound = stage(settings).bind(surface, &points, graph).unwrap();
    bound.solve(&(0..handles.len()).collect::<Vec<_>>()).unwrap()
}

fn energies(found: &HandleWeights) -> Vec<f64> {
    found.figures.values["energies"].as_array().unwrap().iter().filter_map(|e| e.as_f64()).collect()
}

/// Vertices of a surface, each the farthest from those before.
fn spread(surface: &Surface, count: usize) -> Vec<u32> {
    let mut distance = vec![f64::INFINITY; surface.vertex_count()];
    let mut chosen = vec![0];
    while chosen.len() < count {
        let last = surface.positions[*chosen.last().unwrap() as usize];
        distance.iter_mut().zip(&surface.positions).for_each(|(d, p)| *d = d.min((p - last).norm()));
        chosen.push((0..distance.len()).max_by(|&a, &b| distance[a].total_cmp(&distance[b])).unwrap() as u32);
    }
    chosen
}

/// Both methods on a surface: energies agree within the tolerance, and the reported gap holds.
fn assert_same_minimum(name: &str, surface: &Surface, handles: &[u32], graph: Option<&ProximityGraph>) {
    // A hundredth of the tolerance makes the interior point the exact one.
    let exact = solve(r#""solver": "interior_point", "tolerance": 1e-8"#, surface, handles, graph);
    let found = solve(r#""solver": "active_sets""#, surface, handles, graph);
    assert!(found.figures.warnings.is_empty(), "{name}: {:?}", found.figures);
    assert!(found.matrix.min() >= 0.0 && found.matrix.max() <= 1.0, "{name}");
    let gap = found.figures.number("relative_gap").unwrap();
    let least = exact.figures.number("relative_gap").unwrap();
    let mut most = 0.0_f64;
    for (k, (found, exact)) in energies(&found).iter().zip(energies(&exact)).enumerate() {
        let above = found / exact - 1.0;
        most = most.max(above);
        assert!(above <= TOLERANCE, "{name}: handle {k} is {above:.1e} above the least");
        // Rounding of Q x.
        assert!(above >= -least - 1e-9, "{name}: handle {k} is {above:.1e} below what is proven least");
    }
    assert!(most <= gap + 1e-9, "{name}: {most:.1e} above the least, and the reported gap is {gap:.1e}");
    let left = found.figures.number("handles_left_to_the_interior_point").unwrap();
    println!(
        "{name}: {} vertices, {} handles, {most:.1e}, gap {gap:.1e}, {left} left",
        surface.vertex_count(),
        handles.len()
    );
}

/// A bar with uneven, partly obtuse triangles.
fn uneven_bar() -> Surface {
    let mut surface = meshes::bar([48, 12, 8], [3.0, 0.9, 0.7]);
    let mut random = Random::new(3);
    surface.positions.iter_mut().for_each(|p| *p += random.vector() * 0.015);
    surface
}

#[test]
fn energies_are_those_of_the_interior_point() {
    for (name, surface) in
        [("sphere", meshes::icosphere(4)), ("uneven bar", uneven_bar()), ("capsule", meshes::capsule(40, 50, 3.0))]
    {
        for count in [12, 64] {
            assert_same_minimum(name, &surface, &spread(&surface, count), None);
        }
    }
}

#[test]
fn energies_of_bridged_components_are_those_of_the_interior_point() {
    let sphere = meshes::icosphere(3);
    let n = sphere.vertex_count() as u32;
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for k in 0..4 {
        positions.extend(sphere.positions.iter().map(|p| p + Vector3::x() * (2.1 * f64::from(k))));
        triangles.extend(sphere.triangles.iter().map(|t| t.map(|v| v + n * k)));
    }
    let surface = Surface::from_triangles(positions, triangles).unwrap();
    for (bridge, stiffness) in [(0.5, 1.0), (1e-4, 1.0), (100.0, 100.0)] {
        // The last component stays by itself.
        let link = |k: u32| {
            let pairs = [3, 70, 200, 410].map(|v| [v + n * k, v + 1 + n * (k + 1)]).to_vec();
            Link { components: [k, k + 1], distance: 1.0, in_tree: true, stiffness, pairs }
        };
        let graph = ProximityGraph::new(surface.components(), vec![link(0), link(1)], Figures::default()).unwrap();
        let points: Vec<_> = [spread(&sphere, 9), spread(&sphere, 7).iter().map(|v| v + 3 * n).collect()].concat();
        let settings = |more: &str| format!(r#""bridge": {bridge}, {more}"#);
        let exact =
            solve(&settings(r#""solver": "interior_point", "tolerance": 1e-8"#), &surface, &points, Some(&graph));
        let found = solve(&settings(r#""solver": "active_sets""#), &surface, &points, Some(&graph));
        for (found, exact) in energies(&found).iter().zip(energies(&exact)) {
            let above = found / exact - 1.0;
            assert!(above <= TOLERANCE && above > -1e-7, "bridges {bridge} × {stiffness}: {above:.1e}");
        }
        println!("{bridge} × {stiffness}: {:?}", found.figures.number("handles_left_to_the_interior_point"));
    }
}

#[test]
fn awkward_triangles_do_not_lead_astray() {
    let mut surface = uneven_bar();
    let n = surface.vertex_count() as u32;
    // A fin, a corner twice, a flat triangle, a needle, and two vertices at one place.
    let [a, b, c] = surface.triangles[100];
    let (p, q) = (surface.positions[a as usize], surface.positions[b as usize]);
    let middle = nalgebra::center(&p, &q);
    surface.positions.extend([p + Vector3::new(0.0, 0.1, 0.1), middle, middle + Vector3::x() * 1e-7, p, q]);
    surface.triangles.extend([[a, b, n], [c, c, a], [a, b, n + 1], [a, b, n + 2], [a, b, n + 3], [n + 3, n + 4, c]]);
    let surface = Surface::from_triangles(surface.positions, surface.triangles).unwrap();
    assert_same_minimum("awkward", &surface, &spread(&surface, 12), None);
}

#[test]
fn tiny_groups_and_groups_that_are_held_throughout_are_solved() {
    // A tetrahedron, a single triangle and another tetrahedron.
    let tetrahedron = meshes::tetrahedron();
    let mut positions = tetrahedron.positions.clone();
    positions.extend([Point3::new(5.0, 0.0, 0.0), Point3::new(6.0, 0.0, 0.0), Point3::new(5.0, 1.0, 0.0)]);
    positions.extend(tetrahedron.positions.iter().map(|p| p + Vector3::y() * 9.0));
    let mut triangles = tetrahedron.triangles.clone();
    triangles.push([4, 5, 6]);
    triangles.extend(tetrahedron.triangles.iter().map(|t| t.map(|v| v + 7)));
    let surface = Surface::from_triangles(positions, triangles).unwrap();
    for handles in [vec![0, 1, 4, 5, 7], vec![0, 1, 2, 4, 5, 6, 7], (0..11).collect()] {
        let exact = solve(r#""solver": "interior_point", "tolerance": 1e-12"#, &surface, &handles, None).matrix;
        let found = solve(r#""solver": "active_sets""#, &surface, &handles, None).matrix;
        // The square root of the tolerance of the energy.
        assert!((&found - exact).amax() < 1e-3, "{handles:?}: {found}");
    }
}

#[test]
fn active_sets_keep_the_contract_and_say_where_steps_do_not_suffice() {
    contracts::weights("bounded_biharmonic, active sets", &*stage(r#""solver": "active_sets""#));
    let sphere = meshes::icosphere(4);
    let handles = spread(&sphere, 12);
    let found = solve(r#""solver": "active_sets""#, &sphere, &handles, None).matrix;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert!(pool.install(|| solve(r#""solver": "active_sets""#, &sphere, &handles, None)).matrix == found);
    let short = solve(r#""solver": "active_sets", "max_iterations": 2"#, &sphere, &handles, None);
    assert!(short.figures.warnings[0].contains("not solved to their tolerance"), "{:?}", short.figures.warnings);
    assert!(short.matrix.iter().all(|x| (0.0..=1.0).contains(x)), "within bounds all the same");
}
