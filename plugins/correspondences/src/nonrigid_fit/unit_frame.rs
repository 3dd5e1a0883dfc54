//! The frame in which both surfaces are compared.

use mimesh_core::{
    mesh::bounding_box,
    spatial::{Orientation, Similarity},
    stage::TransferPair,
};
use nalgebra::Point3;

/// Both rest surfaces where they are compared: the target about the origin with a diagonal of 1, the source laid on it.
pub struct UnitFrame {
    /// V of the source.
    pub source: Vec<Point3<f64>>,
    /// V of the target.
    pub target: Vec<Point3<f64>>,
}

impl UnitFrame {
    /// Lays the source on the target as the markers say.
    pub fn new(pair: TransferPair<'_>, orientation: Orientation) -> Self {
        let from: Vec<_> =
            pair.markers.iter().map(|m| m.source.position(pair.source, &pair.source.positions)).collect();
        let to: Vec<_> = pair.markers.iter().map(|m| m.target.position(pair.target, &pair.target.positions)).collect();
        let aligned = Similarity::fit(&from, &to, &vec![1.0; from.len()], orientation);
        let (low, high) = bounding_box(&pair.target.positions);
        let (centre, diagonal) = (nalgebra::center(&low, &high), (high - low).norm());
        let unit = |p: Point3<f64>| Point3::from((p - centre) / diagonal);
        Self {
            source: pair.source.positions.iter().map(|p| unit(aligned.apply(p))).collect(),
            target: pair.target.positions.iter().map(|p| unit(*p)).collect(),
        }
    }
}
