//! Quarter turns of axes, and places within bounding boxes.

use mimesh_core::mesh::bounding_box;
use nalgebra::{Matrix3, Point3, Vector3};

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
