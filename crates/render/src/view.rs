//! An orthographic camera.

use nalgebra::{Matrix3, Point3, Vector3};

/// The margin around the framed points, as a share of the picture's side.
const MARGIN: f64 = 0.04;

/// The axis that points up in the mesh's file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UpAxis {
    /// x up: the front looks along −y, with z to the right.
    X,
    /// y up, as in most files: the front looks along −z, with x to the right.
    #[default]
    Y,
    /// z up, as in Blender: the front looks along +y, with x to the right.
    Z,
}

/// Where the camera stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Direction {
    /// In front of the mesh: sees what faces +z (y up), −y (z up) or +y (x up).
    Front,
    /// To the right of the front: sees what faces +x (y or z up) or +z (x up).
    Side,
    /// Above the mesh, with its front at the lower edge of the picture.
    Top,
    /// Between front and side, a little above.
    #[default]
    ThreeQuarter,
    /// Anywhere: turned from the front to the right by `yaw` and raised by `pitch`, in degrees.
    Angles {
        /// Degrees about the up axis; 0 is the front, 90 the side.
        yaw: f64,
        /// Degrees above the ground; 90 is the top.
        pitch: f64,
    },
}

impl Direction {
    /// Returns the degrees by which it is turned from the front to the right, and raised.
    pub fn angles(self) -> [f64; 2] {
        match self {
            Self::Front => [0.0, 0.0],
            Self::Side => [90.0, 0.0],
            Self::Top => [0.0, 90.0],
            Self::ThreeQuarter => [40.0, 18.0],
            Self::Angles { yaw, pitch } if yaw.is_finite() && pitch.is_finite() => [yaw, pitch],
            Self::Angles { .. } => [0.0, 0.0],
        }
    }
}

/// A point's place in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Pixels from the left edge.
    pub x: f64,
    /// Pixels from the upper edge.
    pub y: f64,
    /// Distance from the camera in pixels, growing away from it; 0 at the middle of the framed points.
    pub depth: f64,
}

/// An orthographic camera and the box that it frames, in the unit of the mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Unit vectors to the right of the picture, up, and towards the camera.
    axes: [Vector3<f64>; 3],
    /// The middle of the framed box, along `axes`.
    centre: Vector3<f64>,
    /// Half the size of the framed box along `axes`, at least one of the first two above zero.
    half: Vector3<f64>,
}

impl View {
    /// Returns the view from a direction that just holds all points.
    ///
    /// The points are the positions of a mesh, or of all its poses so that their pictures have one scale. The
    /// [corners](crate::Bounds::corners) of a box serve too, but leave more room around an oblique view. Points that are
    /// not finite do not count; without any the unit box is framed.
    pub fn fit(points: impl IntoIterator<Item = Point3<f64>>, direction: Direction, up: UpAxis) -> Self {
        Self::frame(axes(direction, up), points)
    }

    /// Returns the view of a mesh that `turn` takes into the axes of another, from the direction from which the other is seen.
    ///
    /// `turn` is orthogonal. If it mirrors, the picture is the mirror image of what it would be without.
    pub fn fit_turned(
        points: impl IntoIterator<Item = Point3<f64>>,
        direction: Direction,
        up: UpAxis,
        turn: &Matrix3<f64>,
    ) -> Self {
        let [right, up, towards] = axes(direction, up).map(|axis| turn.tr_mul(&axis));
        // A picture shows the surface from outside, so its axes are right-handed.
        let right = if turn.determinant() < 0.0 { -right } else { right };
        Self::frame([right, up, towards], points)
    }

    /// Returns unit vectors to the right of the picture, up, and towards the camera, as the mesh's file has its axes.
    pub fn axes(&self) -> [Vector3<f64>; 3] {
        self.axes
    }

    fn frame(axes: [Vector3<f64>; 3], points: impl IntoIterator<Item = Point3<f64>>) -> Self {
        let mut low = Vector3::repeat(f64::INFINITY);
        let mut high = Vector3::repeat(f64::NEG_INFINITY);
        for point in points {
            let along = axes.map(|axis| axis.dot(&point.coords));
            if along.iter().all(|c| c.is_finite()) {
                low = low.inf(&along.into());
                high = high.sup(&along.into());
            }
        }
        // Halves first: the sum of two huge coordinates may overflow.
        let (centre, mut half) = (high * 0.5 + low * 0.5, high * 0.5 - low * 0.5);
        if !half.iter().chain(centre.iter()).all(|c| c.is_finite()) {
            return Self { axes, centre: Vector3::zeros(), half: Vector3::repeat(0.5) };
        }
        if half.x.max(half.y) <= 0.0 {
            half = Vector3::repeat(if half.z > 0.0 { half.z } else { 0.5 });
        }
        Self { axes, centre, half }
    }

    /// Returns a point's place in a picture of a size in pixels; `None` if it is not finite there.
    ///
    /// The framed box is centred and as large as fits with a margin, at the same scale across and down.
    pub fn project(&self, point: &Point3<f64>, width: f64, height: f64) -> Option<Placed> {
        let [x, y, z] = self.seen(self.pixels_per_unit(width, height), point);
        let placed = Placed { x: width / 2.0 + x, y: height / 2.0 - y, depth: -z };
        (placed.x.is_finite() && placed.y.is_finite() && placed.depth.is_finite()).then_some(placed)
    }

    /// Returns the pixels of a unit of length in a picture of a size in pixels.
    pub fn pixels_per_unit(&self, width: f64, height: f64) -> f64 {
        let share = |pixels: f64, half: f64| if half > 0.0 { pixels * (0.5 - MARGIN) / half } else { f64::INFINITY };
        let scale = share(width, self.half.x).min(share(height, self.half.y));
        if scale.is_finite() { scale.max(0.0) } else { 0.0 }
    }

    /// Returns the view that frames the boxes of both views, for poses that come one by one.
    ///
    /// Its direction is that of `self`.
    pub fn and(&self, other: &View) -> View {
        // Where the directions differ, the other's ends are those of its box.
        let corners = |view: &View| {
            let [right, up, towards] = view.axes;
            let sign = |bit: usize| if bit & 1 == 0 { -1.0 } else { 1.0 };
            let corner = |i: usize| {
                let along = view.centre + Vector3::new(sign(i), sign(i >> 1), sign(i >> 2)).component_mul(&view.half);
                Point3::from(right * along.x + up * along.y + towards * along.z)
            };
            (0..8).map(corner).collect::<Vec<_>>()
        };
        let points = corners(self).into_iter().chain(corners(other));
        Self::frame(self.axes, points)
    }

    /// Returns a point relative to the middle, scaled: to the right, up, towards the camera.
    pub(crate) fn seen(&self, scale: f64, point: &Point3<f64>) -> [f64; 3] {
        let [right, up, towards] = &self.axes;
        let coords = &point.coords;
        [
            (right.dot(coords) - self.centre.x) * scale,
            (up.dot(coords) - self.centre.y) * scale,
            (towards.dot(coords) - self.centre.z) * scale,
        ]
    }
}

/// Returns unit vectors to the right, up and towards the camera.
fn axes(direction: Direction, up: UpAxis) -> [Vector3<f64>; 3] {
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let (right, up, front) = match up {
        UpAxis::X => (z, x, y),
        UpAxis::Y => (x, y, z),
        UpAxis::Z => (x, z, -y),
    };
    let [yaw, pitch] = direction.angles();
    let ((yaw_sin, yaw_cos), (pitch_sin, pitch_cos)) = (sin_cos(yaw), sin_cos(pitch));
    let ahead = front * yaw_cos + right * yaw_sin;
    [right * yaw_cos - front * yaw_sin, up * pitch_cos - ahead * pitch_sin, ahead * pitch_cos + up * pitch_sin]
}

/// Returns sine and cosine, exact at right angles so that plain views have no rounding in them.
fn sin_cos(degrees: f64) -> (f64, f64) {
    match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        other => other.to_radians().sin_cos(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DIRECTIONS: [Direction; 5] = [
        Direction::Front,
        Direction::Side,
        Direction::Top,
        Direction::ThreeQuarter,
        Direction::Angles { yaw: -200.0, pitch: -35.0 },
    ];

    #[test]
    fn axes_are_a_right_handed_frame_from_everywhere() {
        for up in [UpAxis::X, UpAxis::Y, UpAxis::Z] {
            for direction in DIRECTIONS {
                let [right, above, towards] = axes(direction, up);
                assert!((right.cross(&above) - towards).norm() < 1e-14, "{direction:?} {up:?}");
                assert!((right.norm() - 1.0).abs() < 1e-14 && right.dot(&above).abs() < 1e-14);
            }
        }
    }

    #[test]
    fn a_named_direction_sees_the_side_it_says() {
        assert_eq!(axes(Direction::Front, UpAxis::Y)[2], Vector3::z());
        assert_eq!(axes(Direction::Side, UpAxis::Y), [-Vector3::z(), Vector3::y(), Vector3::x()]);
        assert_eq!(axes(Direction::Top, UpAxis::Y)[2], Vector3::y());
        assert_eq!(axes(Direction::Front, UpAxis::Z), [Vector3::x(), Vector3::z(), -Vector3::y()]);
        assert_eq!(axes(Direction::Front, UpAxis::X)[1], Vector3::x());
    }

    #[test]
    fn a_turned_mesh_looks_as_it_did_before_and_a_mirrored_one_as_in_a_mirror() {
        let points = [[0.0, 1.0, 5.0], [2.0, -3.0, 1.0], [7.0, 0.5, -2.0], [1.0, 9.0, 0.0]].map(Point3::from);
        // From Z up to Y up, and the mirror image along x.
        let turn = Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0);
        let mirror = Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, 1.0));
        for direction in DIRECTIONS {
            let plain = View::fit(points, direction, UpAxis::Y);
            for (change, sign) in [(turn, 1.0), (mirror, -1.0)] {
                let changed = points.map(|p| change.transpose() * p);
                let view = View::fit_turned(changed, direction, UpAxis::Y, &change);
                for (before, after) in points.iter().zip(&changed) {
                    let place = |view: View, p| view.project(p, 200.0, 100.0).unwrap();
                    let (before, after) = (place(plain, before), place(view, after));
                    assert!((sign * (before.x - 100.0) - (after.x - 100.0)).abs() < 1e-9, "{direction:?}");
                    assert!((before.y - after.y).abs() < 1e-9 && (before.depth - after.depth).abs() < 1e-9);
                }
            }
        }
    }

    #[test]
    fn all_that_is_framed_lies_in_the_picture_and_touches_the_margin() {
        let corners = crate::Bounds { low: Point3::new(-3.0, 1.0, 2.0), high: Point3::new(4.0, 2.5, 9.0) }.corners();
        for direction in DIRECTIONS {
            let view = View::fit(corners.iter().copied(), direction, UpAxis::Y);
            let placed: Vec<Placed> = corners.iter().map(|p| view.project(p, 300.0, 200.0).unwrap()).collect();
            let least = |of: fn(&Placed) -> f64| placed.iter().map(of).fold(f64::INFINITY, f64::min);
            let (left, top) = (least(|p| p.x), least(|p| p.y));
            assert!(left > 300.0 * MARGIN - 1e-9 && top > 200.0 * MARGIN - 1e-9);
            assert!((left - 300.0 * MARGIN).min(top - 200.0 * MARGIN) < 1e-9, "{direction:?}: {left} {top}");
        }
    }

    #[test]
    fn two_views_together_frame_what_both_did() {
        let points = [[0.0, 1.0, 5.0], [2.0, -3.0, 1.0], [7.0, 0.5, -2.0], [1.0, 9.0, 0.0]].map(Point3::from);
        for direction in DIRECTIONS {
            let fit = |points: &[Point3<f64>]| View::fit(points.iter().copied(), direction, UpAxis::Z);
            let (both, all) = (fit(&points[..2]).and(&fit(&points[2..])), fit(&points));
            // Turning there and back rounds.
            assert!(
                (both.centre - all.centre).amax() < 1e-12 && (both.half - all.half).amax() < 1e-12,
                "{direction:?}"
            );
        }
    }

    #[test]
    fn a_point_nearer_the_camera_has_less_depth() {
        let points = [Point3::new(0.0, 0.0, 0.0), Point3::new(1.0, 1.0, 5.0)];
        let view = View::fit(points, Direction::Front, UpAxis::Y);
        let [far, near] = points.map(|p| view.project(&p, 100.0, 100.0).unwrap());
        assert!(near.depth < far.depth && near.x > far.x && near.y < far.y);
    }

    #[test]
    fn nothing_one_point_and_infinite_points_still_give_a_view() {
        let one = Point3::new(5.0, 5.0, 5.0);
        for points in
            [vec![], vec![one], vec![Point3::from([f64::NAN; 3])], vec![one, Point3::from([f64::INFINITY; 3])]]
        {
            let view = View::fit(points, Direction::ThreeQuarter, UpAxis::Y);
            assert!(view.project(&one, 100.0, 100.0).is_some());
        }
        assert!(
            View::fit([one], Direction::Front, UpAxis::Y).project(&Point3::from([f64::NAN; 3]), 9.0, 9.0).is_none()
        );
    }
}
