use mimesh_core::{
    Error, Result,
    stage::{ProximityGraph, TransferPair},
};
use nalgebra::{Matrix3, Point3, Vector3};

/// How many markers a fit needs: three points that span a plane say how two shapes lie to each other.
pub const MIN_MARKERS: usize = 3;

/// Checks that markers exist, are distinct, span a plane on either side, and that each component of the target has one.
pub fn check(pair: TransferPair<'_>) -> Result<()> {
    let count = pair.markers.len();
    if count < MIN_MARKERS {
        return Err(Error::data(
            format!("{count} markers: expected at least {MIN_MARKERS}"),
            "give pairs of corresponding points with `markers: FILE`; about 20, spread over the whole shape, do well",
        ));
    }
    pair.check_markers()?;
    for (side, surface) in [("source", pair.source), ("target", pair.target)] {
        let points = pair.markers.iter().map(|m| {
            let point = if side == "source" { m.source } else { m.target };
            point.position(surface, &surface.positions)
        });
        if on_a_line(&points.collect::<Vec<_>>()) {
            return Err(Error::data(
                format!("the {count} markers lie on one line on the {side}: expected points that span the shape"),
                "add markers away from that line",
            ));
        }
    }
    let components = pair.target.components();
    let mut marked = vec![false; components.count()];
    for marker in pair.markers {
        for (vertex, _) in marker.target.corners(pair.target) {
            if let Some(component) = components.of_vertex[vertex as usize] {
                marked[component as usize] = true;
            }
        }
    }
    // A component that is linked to a marked one, in whatever number of steps, follows it.
    for _ in 0..components.count() {
        let reached =
            pair.proximity.into_iter().flat_map(ProximityGraph::links).map(|link| link.components.map(|c| c as usize));
        let news: Vec<_> = reached.filter(|&[a, b]| marked[a] != marked[b]).collect();
        if news.is_empty() {
            break;
        }
        news.into_iter().flatten().for_each(|c| marked[c] = true);
    }
    let loose: Vec<_> = (0..components.count()).filter(|&c| !marked[c]).collect();
    if loose.is_empty() {
        return Ok(());
    }
    Err(Error::data(
        format!(
            "{} of the target's {} components have no marker: {}",
            loose.len(),
            components.count(),
            pair.target.describe_components(&components, &loose)
        ),
        "link them with `proximity: { type: spanning_tree }` and move them with `transfer: { type: multi_component }`, give each a \
         marker, or remove loose parts",
    ))
}

/// Whether the points span less than a plane, to 1e-6 of their spread.
fn on_a_line(points: &[Point3<f64>]) -> bool {
    let mean = points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / points.len() as f64;
    let spread: Matrix3<f64> = points.iter().map(|p| (p.coords - mean) * (p.coords - mean).transpose()).sum();
    let values = spread.symmetric_eigenvalues();
    let mut sorted = [values[0], values[1], values[2]];
    sorted.sort_by(f64::total_cmp);
    sorted[1] <= 1e-12 * sorted[2]
}
