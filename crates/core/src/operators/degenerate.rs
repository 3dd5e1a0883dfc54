use nalgebra::Point3;

/// Height of a triangle over its longest edge, relative to that edge: 0.87 if equilateral, 0 without area, NaN if a corner is.
pub fn relative_height(&[a, b, c]: &[Point3<f64>; 3]) -> f64 {
    let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
    if longest == 0.0 { 0.0 } else { (b - a).cross(&(c - a)).norm() / longest }
}

/// Whether a triangle is too thin for cotangents that keep half their digits: its [`relative_height`] is below 1e-8 or NaN.
pub fn is_degenerate(corners: &[Point3<f64>; 3]) -> bool {
    let has_area = relative_height(corners) > 1e-8;
    !has_area
}
