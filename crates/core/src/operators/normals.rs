use nalgebra::{Point3, Vector3};

/// Unit normals of vertices, #V × 3, from the triangles around them weighted by area; 0 where there is none.
pub fn vertex_normals(positions: &[Point3<f64>], triangles: &[[u32; 3]]) -> Vec<Vector3<f64>> {
    let mut normals = vec![Vector3::zeros(); positions.len()];
    for t in triangles {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        let area_normal = (b - a).cross(&(c - a));
        t.iter().for_each(|&v| normals[v as usize] += area_normal);
    }
    normals.iter().map(|n: &Vector3<f64>| n.try_normalize(0.0).unwrap_or_default()).collect()
}
