//! The contract of weights.

use nalgebra::DMatrix;

use super::{
    meshes,
    support::{bent_bar, one_thread, watched, with_defects},
};
use crate::{
    Figures,
    mesh::{Surface, SurfacePoint},
    stage::{Link, ProximityGraph, Weights},
};

/// Rows are sums of some ten numbers up to 1; closed forms pass a factorisation besides.
const TOLERANCE: f64 = 1e-9;

/// The contract of [`Weights`], on a sound surface, on one with defects and on one of two components.
pub fn weights(name: &str, stage: &dyn Weights) {
    for surface in [bent_bar(), with_defects(bent_bar())] {
        on_surface(name, stage, &surface, &[5, 40, 77, 60, 21, 9], None);
    }
    let two = meshes::two_components();
    on_surface(name, stage, &two, &[3, 60, 11, 25, 50, 41], None);
    components(name, stage, &two);
    mistakes(name, stage, &two);
}

fn on_surface(
    name: &str,
    stage: &dyn Weights,
    surface: &Surface,
    vertices: &[u32; 6],
    proximity: Option<&ProximityGraph>,
) {
    let points = vertices.map(SurfacePoint::Vertex);
    let run = |handles: &[usize]| {
        let bound = stage.bind(surface, &points, proximity).unwrap_or_else(|error| panic!("{name}: {error}"));
        bound.solve(handles).unwrap_or_else(|error| panic!("{name}: {error}")).matrix
    };
    let handles = [0, 1, 2, 4, 5];
    let w = run(&handles);
    check_laws(name, surface, &w, &handles.map(|h| vertices[h]));
    assert!(w == run(&handles) && w == one_thread(|| run(&handles)), "{name}: other weights the next time");

    // One binding serves any choice, and another order of handles is another order of columns.
    let bound = stage.bind(surface, &points, proximity).unwrap_or_else(|error| panic!("{name}: {error}"));
    let solve = |handles: &[usize]| bound.solve(handles).unwrap_or_else(|error| panic!("{name}: {error}")).matrix;
    let fewer = solve(&[1, 3, 0]);
    check_laws(name, surface, &fewer, &[1, 3, 0].map(|h: usize| vertices[h]));
    assert!(w == solve(&handles), "{name}: other weights after another choice of handles");
    let waited = watched(name, |work| bound.solve_watched(&handles, work));
    let waited = waited.unwrap_or_else(|error| panic!("{name}: {error}")).matrix;
    assert!(w == waited, "{name}: other weights while somebody waits");
    let choices: [&[usize]; 4] = [&handles, &[1, 3, 0], &[2, 2], &[5, 1]];
    let together = bound.solve_all(&choices);
    assert_eq!(together.len(), choices.len(), "{name}: one result a choice of handles");
    for (choice, result) in choices.into_iter().zip(together) {
        match (bound.solve(choice), result) {
            (Ok(alone), Ok(together)) => {
                assert!(alone.matrix == together.matrix, "{name}: other weights among other choices");
            }
            (Err(_), Err(_)) => {}
            (alone, _) => panic!("{name}: {choice:?} is refused alone or among others: {:?}", alone.err()),
        }
    }
    let order = [3, 0, 4, 2, 1];
    let reordered = solve(&order.map(|k| handles[k]));
    for (column, k) in order.into_iter().enumerate() {
        let difference = (reordered.column(column) - w.column(k)).amax();
        assert!(difference < TOLERANCE, "{name}: another order of handles changes a weight by {difference:e}");
    }
}

fn check_laws(name: &str, surface: &Surface, w: &DMatrix<f64>, handles: &[u32]) {
    assert_eq!(w.shape(), (surface.vertex_count(), handles.len()), "{name}: W is #V × #H");
    assert!(w.iter().all(|x| x.is_finite()), "{name}: weights are finite");
    for (v, row) in w.row_iter().enumerate() {
        assert!((row.sum() - 1.0).abs() < TOLERANCE, "{name}: the weights of vertex {v} sum to {}", row.sum());
    }
    for (k, &v) in handles.iter().enumerate() {
        for other in 0..handles.len() {
            let expected = f64::from(u8::from(k == other));
            assert_eq!(w[(v as usize, other)], expected, "{name}: handle {other} at the point of handle {k}");
        }
    }
}

/// Components have nothing to do with each other, unless they are linked.
fn components(name: &str, stage: &dyn Weights, two: &Surface) {
    let points = [3, 60, 11].map(SurfacePoint::Vertex);
    let bind = |proximity| stage.bind(two, &points, proximity).unwrap_or_else(|error| panic!("{name}: {error}"));
    let w = bind(None).solve(&[0, 1, 2]).unwrap_or_else(|error| panic!("{name}: {error}")).matrix;
    for v in 0..42 {
        assert!(
            w[(v, 1)] == 0.0 && w[(v + 42, 1)] == 1.0,
            "{name}: the only handle of a component is all of its weight"
        );
    }
    let error = bind(None).solve(&[0, 2]).expect_err("a component without a handle").to_string();
    assert!(error.contains("component") && error.contains("from vertex 42"), "{name}: {error}");

    let pairs = vec![[4, 48], [0, 42]];
    let link = Link { components: [0, 1], distance: 1.0, in_tree: true, stiffness: 1.0, pairs };
    let graph = ProximityGraph::new(two.components(), vec![link], Figures::default()).expect("two components");
    let bridged = bind(Some(&graph)).solve(&[0, 2]).unwrap_or_else(|error| panic!("{name}: {error}")).matrix;
    check_laws(name, two, &bridged, &[3, 11]);
    on_surface(name, stage, two, &[3, 60, 11, 25, 50, 41], Some(&graph));
}

/// Checks that mistakes are refused, and named.
fn mistakes(name: &str, stage: &dyn Weights, two: &Surface) {
    let points = [SurfacePoint::Vertex(3), SurfacePoint::Vertex(60), SurfacePoint::Triangle(0, [0.1, 0.1, 0.8])];
    let corner = two.triangles[0][2];
    let points = [points[0], points[1], points[2], SurfacePoint::Vertex(corner)];
    let bound = stage.bind(two, &points, None).unwrap_or_else(|error| panic!("{name}: {error}"));
    for (handles, words) in
        [(&[][..], &[][..]), (&[0, 1, 0], &["0"]), (&[0, 2, 3, 1], &["2", "3"]), (&[0, 1, 4], &["4"])]
    {
        let Err(error) = bound.solve(handles) else { panic!("{name}: takes the handles {handles:?}") };
        let named = words.iter().all(|word| error.to_string().contains(word));
        assert!(named, "{name}: expected the points {words:?} to be named in: {error}");
    }
    for point in [
        SurfacePoint::Vertex(84),
        SurfacePoint::Triangle(160, [1.0, 0.0, 0.0]),
        SurfacePoint::Triangle(0, [f64::NAN, 0.5, 0.5]),
    ] {
        let bound = stage.bind(two, &[points[0], points[1], point], None);
        let Err(error) = bound else { panic!("{name}: takes {point:?}, which is not on the surface") };
        assert!(error.to_string().contains('2'), "{name}: expected point 2 to be named in: {error}");
    }
}
