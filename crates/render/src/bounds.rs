//! The bounding box of points.

use nalgebra::Point3;

/// A box along the axes around points.
///
/// Taken over all poses, it gives every picture of a row the same scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The least coordinates; positive infinity if there was no point.
    pub low: Point3<f64>,
    /// The greatest coordinates; negative infinity if there was no point.
    pub high: Point3<f64>,
}

impl Default for Bounds {
    fn default() -> Self {
        Self { low: Point3::from([f64::INFINITY; 3]), high: Point3::from([f64::NEG_INFINITY; 3]) }
    }
}

impl Bounds {
    /// Returns the box around the points that are finite.
    pub fn of<'a>(points: impl IntoIterator<Item = &'a Point3<f64>>) -> Self {
        let mut bounds = Self::default();
        bounds.include(points);
        bounds
    }

    /// Grows the box until it holds those of the points that are finite.
    pub fn include<'a>(&mut self, points: impl IntoIterator<Item = &'a Point3<f64>>) {
        for point in points.into_iter().filter(|point| point.iter().all(|c| c.is_finite())) {
            self.low = self.low.inf(point);
            self.high = self.high.sup(point);
        }
    }

    /// Returns the eight corners; none if there was no finite point.
    pub fn corners(&self) -> Vec<Point3<f64>> {
        if !self.low.iter().chain(self.high.iter()).all(|c| c.is_finite()) {
            return Vec::new();
        }
        let ends = [self.low, self.high];
        (0..8).map(|i| Point3::new(ends[i & 1].x, ends[(i >> 1) & 1].y, ends[(i >> 2) & 1].z)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_that_are_not_finite_do_not_count() {
        let points = [Point3::new(1.0, 2.0, 3.0), Point3::new(f64::NAN, 9.0, 9.0), Point3::new(-1.0, 0.0, 5.0)];
        let bounds = Bounds::of(&points);
        assert_eq!((bounds.low, bounds.high), (Point3::new(-1.0, 0.0, 3.0), Point3::new(1.0, 2.0, 5.0)));
        assert_eq!(bounds.corners().len(), 8);
        assert!(Bounds::of(&[]).corners().is_empty());
    }
}
