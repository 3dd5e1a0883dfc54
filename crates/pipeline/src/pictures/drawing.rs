//! Pictures of single meshes: with errors in colour, or with markers.

use std::borrow::Cow;

use mimesh_core::mesh::{Surface, SurfacePoint};
use mimesh_render::{
    Canvas, Colour, Dot, Paint, Picture, Rect, Scale, Size, View,
    colour::{CRIMSON, FAINT, INK, SAND, WHITE},
    legend,
};
use nalgebra::Point3;

use super::Camera;
use crate::page::Image;

/// The pixels below a mesh for the legend of its colours.
pub(super) const LEGEND_HEIGHT: u32 = 36;

/// Returns a picture as it goes into a page; `alt` says what it shows to those who cannot see it.
pub fn image(name: &str, alt: String, picture: &Picture) -> Image {
    Image { name: name.into(), alt, png: picture.small_png(), size: [picture.width, picture.height] }
}

/// Draws a mesh with its numbered points into a square of `size` pixels.
pub fn draw_markers(surface: &Surface, points: &[SurfacePoint], camera: Camera, size: u32, colour: Colour) -> Picture {
    let mut picture = Picture::new(size, size, WHITE);
    let mut canvas = Canvas::new(size, size, camera.view(&surface.positions));
    canvas.mesh(&surface.positions, &surface.triangles, &Paint::Plain(colour));
    let dot = |(k, point): (usize, &SurfacePoint)| Dot {
        at: point.position(surface, &surface.positions),
        label: Some((k + 1).to_string()),
        colour: CRIMSON,
    };
    canvas.dots(&points.iter().enumerate().map(dot).collect::<Vec<_>>());
    let drawn = canvas.draw_onto(&mut picture, 0, 0);
    if drawn.hidden > 0 {
        let note = format!("{} behind", drawn.hidden);
        picture.text(6, size as i32 - 16, &note, Size::Small, INK);
    }
    picture.frame(Rect { x: 0, y: 0, width: size, height: size }, FAINT);
    picture
}

/// Draws a mesh into a square of `size` pixels, in one colour or by `errors`, in percent, of the vertices of its file.
pub fn draw_mesh(surface: &Surface, errors: Option<&[f64]>, camera: Camera, size: u32) -> Picture {
    let mut picture = Picture::new(size, size, WHITE);
    let view = camera.view(&surface.positions);
    match errors {
        Some(errors) => {
            let field = Field { values: errors, high: 5.0, unit: "error, %" };
            draw_field(&mut picture, 0, surface, &surface.positions, view, field);
        }
        None => {
            let mut canvas = Canvas::new(size, size, view);
            canvas.mesh(&surface.positions, &surface.triangles, &Paint::Plain(SAND));
            canvas.draw_onto(&mut picture, 0, 0);
        }
    }
    picture
}

/// A value for each vertex of a mesh's file, the larger the worse.
#[derive(Clone, Copy)]
pub(super) struct Field<'f> {
    pub values: &'f [f64],
    /// The value at the end of the scale of colours.
    pub high: f64,
    /// The name of the values with their unit.
    pub unit: &'f str,
}

/// Draws a posed mesh in the colours of a field at `x` of `picture`, as high as it and as wide, with a legend below.
pub(super) fn draw_field(
    picture: &mut Picture,
    x: u32,
    surface: &Surface,
    posed: &[Point3<f64>],
    view: View,
    field: Field<'_>,
) {
    let size = picture.height;
    let values = on_surface(surface, field.values);
    let over = values.iter().any(|value| *value > field.high);
    let scale = Scale { over, ..Scale::new(0.0, field.high) };
    let mut canvas = Canvas::new(size, size - LEGEND_HEIGHT, view);
    canvas.mesh(posed, &surface.triangles, &Paint::Values { values: &values, scale: &scale });
    canvas.draw_onto(picture, x as i32, 0);
    let y = (size - LEGEND_HEIGHT) as i32;
    let place = Rect { x: x as i32 + 8, y, width: size - 16, height: LEGEND_HEIGHT - 2 };
    legend(picture, place, &scale, field.unit);
}

/// Returns the values of a surface's vertices from those of its file's.
pub(super) fn on_surface<'f>(surface: &Surface, field: &'f [f64]) -> Cow<'f, [f64]> {
    let same =
        surface.representative.len() == field.len() && (0..).zip(&surface.representative).all(|(v, copy)| v == *copy);
    if same {
        return Cow::Borrowed(field);
    }
    surface.representative.iter().map(|&v| field.get(v as usize).copied().unwrap_or(f64::NAN)).collect()
}
