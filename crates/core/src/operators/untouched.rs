//! Vertices that a shape leaves alone.

use nalgebra::{Point3, Vector3};

use crate::{
    Error, Result,
    linalg::{Assembly, FixedUnknowns},
    mesh::{Surface, SurfacePoint},
};

/// A vertex that moves by less than this, relative to the diagonal, rests: files hold coordinates in 32 bits.
const AT_REST: f64 = 1e-6;

/// Edges shorter than this, relative to the mean, weigh no more.
const MIN_LENGTH: f64 = 1e-3;

/// For each of `points` on `source`, whether all vertices that it depends on rest in `posed` (#V of the source).
///
/// # Errors
///
/// [`Error::Shape`] if `posed` has another count than the source.
pub fn untouched(source: &Surface, posed: &[Point3<f64>], points: &[SurfacePoint]) -> Result<Vec<bool>> {
    Error::check_shape("posed source: vertices", source.vertex_count(), posed.len())?;
    let near = AT_REST * source.diagonal();
    let rests = |v: u32| (posed[v as usize] - source.positions[v as usize]).norm() <= near;
    let point = |point: &SurfacePoint| match *point {
        SurfacePoint::Vertex(v) => rests(v),
        SurfacePoint::Triangle(t, weights) => {
            let corners = source.triangles[t as usize];
            corners.iter().zip(weights).all(|(&v, weight)| weight.abs() < 1e-9 || rests(v))
        }
    };
    Ok(points.iter().map(point).collect())
}

/// Takes the vertices that are `untouched` (#V) back to where they rest, to the last bit, and what they were off by from all others.
///
/// The vertices between are moved by a field that is as smooth as can be: the mean of its neighbours at each, by the inverse squares
/// of the lengths of the edges. So it is nowhere larger than at the untouched vertices. Components without any stay as they are.
///
/// # Errors
///
/// [`Error::Shape`] if counts differ.
pub fn keep_untouched(rest: &Surface, positions: &mut [Point3<f64>], untouched: &[bool]) -> Result<()> {
    let count = rest.vertex_count();
    Error::check_shape("positions: vertices", count, positions.len())?;
    Error::check_shape("untouched: vertices", count, untouched.len())?;
    let edges = rest.edges();
    let length = |[a, b]: [u32; 2]| (rest.positions[a as usize] - rest.positions[b as usize]).norm();
    let floor = MIN_LENGTH * edges.iter().map(|&edge| length(edge)).sum::<f64>() / edges.len().max(1) as f64;
    let held = held(count, &edges, untouched);
    let mut assembly = Assembly::new(count);
    for &[a, b] in edges.iter().filter(|[a, b]| !held[*a as usize] || !held[*b as usize]) {
        let length = length([a, b]).max(floor).max(f64::MIN_POSITIVE.sqrt());
        assembly.add_outer(&[a, b], &[[1.0], [-1.0]], (floor / length).powi(2));
    }
    let off = |v: u32| {
        if untouched[v as usize] { positions[v as usize] - rest.positions[v as usize] } else { Vector3::zeros() }
    };
    let fixed: Vec<u32> = (0..count as u32).filter(|&v| held[v as usize]).collect();
    if fixed.len() < count {
        let values: Vec<Vector3<f64>> = fixed.iter().map(|&v| off(v)).collect();
        let columns: Vec<f64> = (0..3).flat_map(|axis| values.iter().map(move |value| value[axis])).collect();
        let system = FixedUnknowns::new(&assembly.finish(), &fixed, "what untouched vertices were off by")?;
        let field = system.solve(&vec![0.0; 3 * count], &columns, 3);
        for (v, position) in positions.iter_mut().enumerate().filter(|(v, _)| !held[*v]) {
            *position -= Vector3::new(field[v], field[count + v], field[2 * count + v]);
        }
    }
    for (v, position) in positions.iter_mut().enumerate().filter(|(v, _)| untouched[*v]) {
        *position = rest.positions[v];
    }
    Ok(())
}

/// Vertices whose correction is known: those that are `untouched`, and those that no edges join to one.
fn held(count: usize, edges: &[[u32; 2]], untouched: &[bool]) -> Vec<bool> {
    let mut neighbours = vec![Vec::new(); count];
    for &[a, b] in edges {
        neighbours[a as usize].push(b);
        neighbours[b as usize].push(a);
    }
    let mut reached = untouched.to_vec();
    let mut pending: Vec<u32> = (0..count as u32).filter(|&v| untouched[v as usize]).collect();
    while let Some(v) = pending.pop() {
        for &next in &neighbours[v as usize] {
            if !std::mem::replace(&mut reached[next as usize], true) {
                pending.push(next);
            }
        }
    }
    reached.iter().zip(untouched).map(|(reached, untouched)| *untouched || !reached).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testkit::meshes;

    #[test]
    fn points_rest_where_all_vertices_that_they_depend_on_do() {
        let surface = meshes::grid(4, 4);
        let mut posed = surface.positions.clone();
        posed[6].z += 0.1;
        posed[7].x += 1e-9;
        let touching = surface.triangles.iter().position(|corners| corners.contains(&6)).unwrap();
        let corner = surface.triangles[touching].iter().position(|&v| v == 6).unwrap();
        let mut beside = [0.5; 3];
        beside[corner] = 0.0;
        let points = [
            SurfacePoint::Vertex(6),
            SurfacePoint::Vertex(7),
            SurfacePoint::Triangle(touching as u32, [1.0 / 3.0; 3]),
            SurfacePoint::Triangle(touching as u32, beside),
        ];
        assert_eq!(untouched(&surface, &posed, &points).unwrap(), [false, true, false, true]);
        assert!(untouched(&surface, &posed[1..], &points).is_err());
    }

    #[test]
    fn what_is_untouched_rests_to_the_last_bit_and_a_common_drift_is_gone_everywhere() {
        let rest = meshes::grid(12, 12);
        let untouched: Vec<bool> = rest.positions.iter().map(|p| p.x < 0.5 * rest.positions[12].x).collect();
        let lift = |v: usize| if untouched[v] { 0.0 } else { 0.3 };
        let drift = Vector3::new(0.01, -0.02, 0.005);
        let mut positions: Vec<_> =
            (0..rest.vertex_count()).map(|v| rest.positions[v] + Vector3::new(0.0, 0.0, lift(v)) + drift).collect();
        keep_untouched(&rest, &mut positions, &untouched).unwrap();
        for (v, (position, rest)) in positions.iter().zip(&rest.positions).enumerate() {
            if untouched[v] {
                assert_eq!(position, rest);
            } else {
                // The field is constant, up to the rounding of a solve of 100 unknowns.
                assert!((position - rest - Vector3::new(0.0, 0.0, 0.3)).norm() < 1e-12);
            }
        }
    }

    #[test]
    fn no_vertex_is_moved_by_more_than_the_untouched_were_off_and_other_components_stay() {
        let (rest, second) = (meshes::icosphere(2), meshes::icosphere(1));
        let first = rest.vertex_count();
        let both = Surface::from_triangles(
            rest.positions.iter().chain(&second.positions).copied().collect(),
            rest.triangles
                .iter()
                .copied()
                .chain(second.triangles.iter().map(|t| t.map(|v| v + first as u32)))
                .collect(),
        )
        .unwrap();
        let mut positions = both.positions.clone();
        let off = |v: usize| 0.01 * Vector3::new((v as f64).sin(), (2.0 * v as f64).cos(), 0.3);
        positions.iter_mut().enumerate().for_each(|(v, p)| *p += off(v));
        let before = positions.clone();
        let untouched: Vec<bool> = (0..both.vertex_count()).map(|v| v < first && both.positions[v].y < 0.0).collect();
        let largest = (0..first).filter(|&v| untouched[v]).map(|v| off(v).norm()).fold(0.0, f64::max);
        keep_untouched(&both, &mut positions, &untouched).unwrap();
        for v in 0..both.vertex_count() {
            let moved = (positions[v] - before[v]).norm();
            // The principle of the maximum holds for each coordinate.
            assert!(moved <= 3.0_f64.sqrt() * largest + 1e-12, "{v}: {moved}");
            assert!(v < first || moved == 0.0);
        }
        // None, or all.
        keep_untouched(&both, &mut positions, &vec![false; before.len()]).unwrap();
        keep_untouched(&both, &mut positions, &vec![true; before.len()]).unwrap();
        assert_eq!(positions, both.positions);
    }
}
