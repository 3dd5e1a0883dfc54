//! Turns of axes, and places within bounding boxes.

use mimesh_core::{
    mesh::bounding_box,
    spatial::{Orientation, Similarity},
};
use nalgebra::{Matrix3, Point3, Vector3};

use super::shape::Shape;

/// Turns of two shapes after which they lie alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frames {
    /// The turn of the source.
    pub source: Matrix3<f64>,
    /// The turn of the target.
    pub target: Matrix3<f64>,
}

impl Frames {
    /// The turn that takes the source to the target.
    pub fn turn(&self) -> Matrix3<f64> {
        self.target.transpose() * self.source
    }

    /// Whether the source keeps the axes of its file, but for quarter turns.
    pub fn keep_axes(&self) -> bool {
        self.source.iter().all(|x| x.fract() == 0.0)
    }

    /// The places of the source, turned.
    pub fn source(&self, shape: &Shape) -> Vec<Point3<f64>> {
        shape.cloud.places.iter().map(|p| self.source * p).collect()
    }

    /// The places of the target, turned.
    pub fn target(&self, shape: &Shape) -> Vec<Point3<f64>> {
        shape.cloud.places.iter().map(|p| self.target * p).collect()
    }
}

/// The rotation that takes the axes along which `places` spread, most first, to x, y and z.
pub fn principal_axes(places: &[Point3<f64>]) -> Matrix3<f64> {
    let mean = places.iter().map(|p| p.coords).sum::<Vector3<f64>>() / places.len() as f64;
    let covariance: Matrix3<f64> = places.iter().map(|p| (p.coords - mean) * (p.coords - mean).transpose()).sum();
    let eigen = covariance.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| eigen.eigenvalues[b].total_cmp(&eigen.eigenvalues[a]).then(a.cmp(&b)));
    let [x, y] = [order[0], order[1]].map(|k| eigen.eigenvectors.column(k).into_owned());
    Matrix3::from_rows(&[x.transpose(), y.transpose(), x.cross(&y).transpose()])
}

/// The rotation that takes points `from` to `to` about their means with the least sum of squares; `None` if it is not determined.
pub fn nearest_rotation(from: &[Point3<f64>], to: &[Point3<f64>]) -> Option<Matrix3<f64>> {
    let weights = vec![1.0; from.len()];
    Some(Similarity::orient(from, to, &weights, Orientation::Fitted)?.rotation)
}

/// The 24 rotations that take axes to axes; those that turn least come first, as files of one kind share their axes.
pub fn quarter_turns() -> Vec<Matrix3<f64>> {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let signs = (0..8).map(|bits| [0, 1, 2].map(|k| if bits >> k & 1 == 0 { 1.0 } else { -1.0 }));
    let all = orders.into_iter().flat_map(|order| {
        signs.clone().map(move |signs| {
            let mut turn = Matrix3::zeros();
            (0..3).for_each(|row| turn[(row, order[row])] = signs[row]);
            turn
        })
    });
    let mut turns: Vec<Matrix3<f64>> = all.filter(|turn| turn.determinant() > 0.0).collect();
    turns.sort_by(|a, b| b.trace().total_cmp(&a.trace()));
    turns
}

/// Where `places` lie in their bounding box, each coordinate −½ to ½.
///
/// An extent counts as at least `least` of the longest, so that what is thin does not grow.
pub fn in_box(places: &[Point3<f64>], least: f64) -> Vec<Vector3<f64>> {
    let (low, high) = bounding_box(places);
    let extent = high - low;
    // A box without extent has all places in its middle.
    let smallest = (least * extent.max()).max(f64::MIN_POSITIVE);
    let middle = nalgebra::center(&low, &high);
    places.iter().map(|p| (p - middle).zip_map(&extent, |x, e| x / e.max(smallest))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_24_turns_and_the_first_is_none() {
        let turns = quarter_turns();
        assert_eq!((turns.len(), turns[0]), (24, Matrix3::identity()));
        for (k, turn) in turns.iter().enumerate() {
            assert_eq!(turn * turn.transpose(), Matrix3::identity());
            assert!(turn.determinant() == 1.0 && !turns[..k].contains(turn));
        }
    }

    #[test]
    fn places_fill_their_box_and_what_is_flat_stays_flat() {
        let places = [[1.0, 2.0, 5.0], [3.0, 3.0, 5.0], [5.0, 2.5, 5.0]].map(Point3::from);
        let corner = |v: [f64; 3]| Vector3::from(v);
        assert_eq!(in_box(&places, 0.0)[..2], [corner([-0.5, -0.5, 0.0]), corner([0.0, 0.5, 0.0])]);
        assert_eq!(in_box(&places, 0.5)[..2], [corner([-0.5, -0.25, 0.0]), corner([0.0, 0.25, 0.0])]);
        assert_eq!(in_box(&places[..1], 0.25), [Vector3::zeros()]);
    }
}
