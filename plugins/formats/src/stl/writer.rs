use mimesh_core::{Error, Result, mesh::Mesh};
use nalgebra::{Point3, Vector3};

use crate::single;

/// A binary STL of `mesh` with its vertices at `positions` (#V × 3); polygons are fans from their first corner.
///
/// # Errors
///
/// [`Error::Data`] if there are more triangles than the format counts, or a coordinate is beyond its numbers.
pub fn write(mesh: &Mesh, positions: &[Point3<f64>]) -> Result<Vec<u8>> {
    let (triangles, _) = mesh.polygons.fans();
    let count = u32::try_from(triangles.len()).map_err(|_| {
        Error::data(format!("{} triangles are more than an STL can hold", triangles.len()), "write PLY")
    })?;
    single::check_positions(positions, single::MAX, "STL")?;
    let mut out = vec![b' '; 80];
    let header = b"written by mimesh";
    out[..header.len()].copy_from_slice(header);
    out.extend(count.to_le_bytes());
    for corners in &triangles {
        let corners = corners.map(|v| positions[v as usize]);
        let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
        let normal = normal.try_normalize(f64::MIN_POSITIVE).unwrap_or_else(Vector3::zeros);
        for vector in [normal, corners[0].coords, corners[1].coords, corners[2].coords] {
            out.extend(vector.iter().flat_map(|&x| (x as f32).to_le_bytes()));
        }
        out.extend([0; 2]);
    }
    Ok(out)
}

/// A sentence if 32-bit numbers move vertices by more than 1e-6 of the diagonal.
pub fn rounding_warning(mesh: &Mesh) -> Option<String> {
    let size = mesh.positions.iter().map(|p| p.coords.amax()).fold(0.0, f64::max);
    let rounding = f64::from(f32::EPSILON) / 2.0 * size;
    (rounding > 1e-6 * mesh.diagonal()).then(|| {
        format!(
            "the mesh lies so far from the origin that the 32-bit numbers of STL move vertices by up to {rounding:.1e}"
        )
    })
}
