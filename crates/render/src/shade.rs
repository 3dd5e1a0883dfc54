//! The light on a surface, by its colour, normal and side.

use crate::colour::{Colour, GREY};
use crate::scale::Scale;

/// The unit vector from a surface to the light, at the camera's upper left: right, up, towards the camera.
const LIGHT: [f32; 3] = [-0.418_28, 0.557_71, 0.716_93];
/// The unit vector halfway between light and camera, which is the normal of a highlight.
const HIGHLIGHT: [f32; 3] = [-0.225_72, 0.300_96, 0.926_52];
/// The tint of a surface's inside.
const INSIDE: [f32; 3] = [120.0, 44.0, 36.0];
/// Brightness is rounded to steps of 1 / 96 so that a picture has few colours and a small file.
const STEPS: f32 = 96.0;

/// The colour of a triangle before it is lit.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Base {
    Colour(Colour),
    /// Places on a scale at the corners: 0 its low end, 1 its high end.
    Places([f32; 3]),
}

/// The lit colours of one triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shade {
    base: Base,
    /// Unit normals at the corners, of the visible side: right, up, towards the camera.
    normals: [[f32; 3]; 3],
    front: bool,
}

impl Shade {
    /// Takes unit normals at the corners, always those of the front side.
    pub(crate) fn new(base: Base, normals: [[f32; 3]; 3], front: bool) -> Self {
        let normals = if front { normals } else { normals.map(|normal| normal.map(|c| -c)) };
        Self { base, normals, front }
    }

    #[cfg(test)]
    pub(crate) fn plain(colour: Colour) -> Self {
        Self::new(Base::Colour(colour), [LIGHT; 3], true)
    }

    /// Returns the colour at barycentric coordinates.
    pub(crate) fn colour(&self, barycentric: [f32; 3]) -> Colour {
        let [u, v, w] = barycentric;
        let [p, q, r] = &self.normals;
        let sum: [f32; 3] = std::array::from_fn(|i| p[i] * u + q[i] * v + r[i] * w);
        let mut normal = unit(sum).unwrap_or([0.0, 0.0, 1.0]);
        // An interpolated normal may turn away from the camera just where the surface does not yet.
        normal[2] = normal[2].max(0.0);
        let (base, material) = match self.base {
            Base::Colour(colour) => (colour, &SURFACE),
            Base::Places([p, q, r]) => {
                let place = p * u + q * v + r * w;
                (if place.is_nan() { GREY } else { Scale::colour_at(place) }, &MAP)
            }
        };
        light(base.map(f32::from), normal, material, self.front)
    }
}

/// The brightness of a surface in light and shadow.
struct Material {
    /// Brightness in full shadow, and what full light adds.
    dark: f32,
    span: f32,
    /// The share of white at the middle of a highlight.
    shine: f32,
}

const SURFACE: Material = Material { dark: 0.44, span: 0.64, shine: 0.18 };
/// Light changes colours of values less, so that they can be read.
const MAP: Material = Material { dark: 0.66, span: 0.36, shine: 0.04 };

fn light(base: [f32; 3], normal: [f32; 3], material: &Material, front: bool) -> Colour {
    // Light that wraps around keeps shape visible in the shadow; a little more comes from the sky than from the ground.
    let lit = ((dot(normal, LIGHT) + 0.4) * (1.0 / 1.4)).max(0.0);
    let sky = 0.5 + 0.5 * normal[1];
    let brightness = stepped(material.dark + material.span * (0.85 * lit + 0.15 * sky));
    let shaded = |colour: f32| (colour * brightness).min(255.0);
    // Adding a half and cutting off rounds; the library's rounding is a call, here made for every sample.
    if front {
        let glint = stepped(power_24(dot(normal, HIGHLIGHT).max(0.0)) * material.shine);
        base.map(|colour| (shaded(colour) * (1.0 - glint) + 255.0 * glint + 0.5) as u8)
    } else {
        std::array::from_fn(|i| (shaded(base[i] * 0.30 + INSIDE[i] * 0.62) + 0.5) as u8)
    }
}

/// Rounds a brightness, which is not negative, to the nearest step.
fn stepped(value: f32) -> f32 {
    f32::from((value * STEPS + 0.5) as u16) / STEPS
}

fn power_24(base: f32) -> f32 {
    let cube = base * base * base;
    let sixth = cube * cube;
    let twelfth = sixth * sixth;
    twelfth * twelfth
}

/// Scales a vector to unit length; `None` if it is zero or not finite.
pub(crate) fn unit(vector: [f32; 3]) -> Option<[f32; 3]> {
    let over_length = 1.0 / dot(vector, vector).sqrt();
    (over_length.is_finite() && over_length > 0.0).then(|| vector.map(|c| c * over_length))
}

pub(crate) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::{STEEL, to_oklab};

    fn lightness(normal: [f32; 3], front: bool) -> f64 {
        let normals = [if front { normal } else { normal.map(|c| -c) }; 3];
        to_oklab(Shade::new(Base::Colour(STEEL), normals, front).colour([0.3, 0.3, 0.4]))[0]
    }

    #[test]
    fn light_directions_have_unit_length() {
        assert!((dot(LIGHT, LIGHT) - 1.0).abs() < 1e-4 && (dot(HIGHLIGHT, HIGHLIGHT) - 1.0).abs() < 1e-4);
    }

    #[test]
    fn the_upper_left_is_lit_and_the_lower_right_in_shadow() {
        assert!(lightness([-0.6, 0.6, 0.53], true) > lightness([0.0, 0.0, 1.0], true));
        assert!(lightness([0.0, 0.0, 1.0], true) > lightness([0.6, -0.6, 0.53], true) + 0.1);
    }

    #[test]
    fn the_inside_is_darker_than_the_outside_everywhere() {
        for normal in [[-0.6, 0.6, 0.53], [0.0, 0.0, 1.0], [0.6, -0.6, 0.53]] {
            assert!(lightness(normal, false) < lightness(normal, true) - 0.08, "{normal:?}");
        }
    }

    #[test]
    fn a_corner_without_a_value_makes_grey() {
        let shade = Shade::new(Base::Places([f32::NAN, 0.0, 0.0]), [LIGHT; 3], true);
        let [r, g, b] = shade.colour([0.2, 0.4, 0.4]);
        assert!(r.abs_diff(g) < 12 && g.abs_diff(b) < 12);
    }
}
