use nalgebra::Point3;

use super::degenerate::is_degenerate;

/// The diagonal of the lumped mass M, #V: the Voronoi area of each vertex, in squared units of length.
///
/// Mixed areas of Meyer et al. 2003: inside an obtuse triangle the obtuse corner takes half the area and the others a
/// quarter, so that areas stay positive and sum to the area of the mesh. Vertices without a triangle, or with degenerate
/// triangles only, have 0.
pub fn voronoi_mass(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> Vec<f64> {
    let mut mass = vec![0.0; positions.len()];
    for t in triangles {
        let corners = t.map(|v| positions[v as usize]);
        if is_degenerate(&corners) {
            continue;
        }
        for (share, &v) in shares(&corners).iter().zip(t) {
            mass[v as usize] += share;
        }
    }
    mass
}

/// The parts of a triangle's area that belong to its corners.
fn shares(corners: &[Point3<f64>; 3]) -> [f64; 3] {
    let edge = |k: usize| corners[(k + 2) % 3] - corners[(k + 1) % 3];
    let double_area = edge(0).cross(&edge(1)).norm();
    // dot[k] is |u| |v| cos of the angle at corner k; cot = dot / double_area.
    let dot: [f64; 3] = std::array::from_fn(|k| -edge((k + 1) % 3).dot(&edge((k + 2) % 3)));
    if let Some(obtuse) = dot.iter().position(|&d| d < 0.0) {
        return std::array::from_fn(|k| double_area / if k == obtuse { 4.0 } else { 8.0 });
    }
    std::array::from_fn(|k| {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        (edge(i).norm_squared() * dot[i] + edge(j).norm_squared() * dot[j]) / (8.0 * double_area)
    })
}
