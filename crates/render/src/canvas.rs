//! The depth buffer that meshes are drawn into.

use crate::colour::{Colour, GREY, INK, mix};
use crate::dots::{self, Dot, DotsDrawn, PlacedDot};
use crate::picture::{Picture, Rect};
use crate::raster::{Corner, Samples};
use crate::scale::Scale;
use crate::shade::{Base, Shade, dot, unit};
use crate::view::{Placed, View};
use nalgebra::Point3;

/// The depth buffer has this many samples a pixel, across and down.
const PER_PIXEL: usize = 2;

/// An edge is drawn sharp where a face turns from the mean of its neighbours by more than this (cosine of 30°).
const CREASE: f32 = 0.866;

/// A step in depth of this share of the picture's shorter side is drawn as an outline.
const OUTLINE_STEP: f32 = 0.03;
/// How much ink covers the samples of an outline.
const OUTLINE_COVER: f64 = 0.45;

/// The colours of a mesh.
#[derive(Clone, Copy, Debug)]
pub enum Paint<'a> {
    /// One colour.
    Plain(Colour),
    /// A value a vertex. A triangle with a corner that has none, or NaN, is [grey](crate::colour::GREY).
    Values {
        /// #V values.
        values: &'a [f64],
        /// The colours of the values.
        scale: &'a Scale,
    },
    /// A colour a triangle (#F), e.g. that of its component; triangles without one are grey.
    Triangles(&'a [Colour]),
}

/// Counts of a mesh's triangles, drawn and left out.
///
/// Triangles outside the picture, or seen from their edge, count as drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Drawn {
    /// Triangles given to the depth buffer.
    pub triangles: usize,
    /// Triangles left out because a corner names no vertex.
    pub without_vertex: usize,
    /// Triangles left out because a corner is not finite, or over a million pixels outside the picture.
    pub not_finite: usize,
}

/// A depth buffer for any number of meshes that hide one another, and dots on them.
#[derive(Clone, Debug)]
pub struct Canvas {
    width: u32,
    height: u32,
    view: View,
    samples: Samples,
    dots: Vec<PlacedDot>,
    /// The number of dots that are not finite.
    lost_dots: usize,
}

impl Canvas {
    /// Returns an empty canvas of a size in pixels, seen by a camera.
    pub fn new(width: u32, height: u32, view: View) -> Self {
        let samples = Samples::new(width as usize * PER_PIXEL, height as usize * PER_PIXEL);
        Self { width, height, view, samples, dots: Vec::new(), lost_dots: 0 }
    }

    /// Returns the place of a point on this canvas, in pixels; `None` if it is not finite.
    pub fn place(&self, point: &Point3<f64>) -> Option<Placed> {
        self.view.project(point, f64::from(self.width), f64::from(self.height))
    }

    /// Draws a triangle mesh: `positions` #V × 3, corners of `triangles` #F × 3 counter-clockwise seen from outside.
    ///
    /// The surface is smooth where faces meet at a small angle, sharp at creases, and lit from the camera's upper left.
    /// Its inside is dark red, so that flipped triangles and holes are seen. Triangles that do not share their vertices,
    /// as in an STL file that was not welded, look flat.
    pub fn mesh(&mut self, positions: &[Point3<f64>], triangles: &[[u32; 3]], paint: &Paint) -> Drawn {
        let points = self.as_seen(positions);
        let corners: Vec<Option<Corner>> = points.iter().map(|point| self.corner(*point)).collect();
        let normals = Normals::new(&points, triangles);
        let places: Vec<f32> = match paint {
            Paint::Values { values, scale } => {
                let known = values.iter().map(|value| scale.place(*value));
                known.chain(std::iter::repeat(f32::NAN)).take(positions.len()).collect()
            }
            _ => Vec::new(),
        };
        let mut drawn = Drawn::default();
        for (index, triangle) in triangles.iter().enumerate() {
            let vertices = triangle.map(|vertex| vertex as usize);
            if vertices.iter().any(|vertex| *vertex >= positions.len()) {
                drawn.without_vertex += 1;
                continue;
            }
            let [Some(a), Some(b), Some(c)] = vertices.map(|vertex| corners[vertex]) else {
                drawn.not_finite += 1;
                continue;
            };
            drawn.triangles += 1;
            self.samples.fill([a, b, c], |front| {
                let base = match paint {
                    Paint::Plain(colour) => Base::Colour(*colour),
                    Paint::Values { .. } => Base::Places(vertices.map(|vertex| places[vertex])),
                    Paint::Triangles(colours) => Base::Colour(colours.get(index).copied().unwrap_or(GREY)),
                };
                Shade::new(base, normals.at_corners(vertices), front)
            });
        }
        drawn
    }

    /// Adds markers or key points, which [`draw_onto`](Self::draw_onto) draws over the meshes.
    ///
    /// A visible one is a disc with a white rim; one that is hidden behind a surface is a faint ring.
    pub fn dots(&mut self, dots: &[Dot]) {
        for dot in dots {
            match self.place(&dot.at) {
                Some(at) => self.dots.push(PlacedDot { at, dot: dot.clone() }),
                None => self.lost_dots += 1,
            }
        }
    }

    /// Draws the meshes and then the dots onto a picture, the canvas' upper left corner at (`x`, `y`).
    ///
    /// The picture stays as it was where the canvas is empty. The outline of every shape is darkened, also where one part
    /// stands before another.
    pub fn draw_onto(&self, picture: &mut Picture, x: i32, y: i32) -> DotsDrawn {
        for row in 0..self.height as usize {
            for column in 0..self.width as usize {
                let (colour, cover) = self.resolve(column, row);
                if cover > 0.0 {
                    picture.blend(x.saturating_add(column as i32), y.saturating_add(row as i32), colour, cover);
                }
            }
        }
        let area = Rect { x, y, width: self.width, height: self.height };
        // Dots lie on a surface, that is, as often just behind as just before it.
        let slack = f64::from(self.width.min(self.height)) * 0.015;
        let drawn = dots::draw(picture, area, &self.dots, |at| {
            let per_pixel = PER_PIXEL as f64;
            let (column, row) = (at.x * per_pixel, at.y * per_pixel);
            let inside = column >= 0.0 && row >= 0.0;
            let nearest = if inside { self.samples.at(column as usize, row as usize) } else { None };
            nearest.is_none_or(|(depth, _)| f64::from(depth) > at.depth - slack)
        });
        DotsDrawn { outside: drawn.outside + self.lost_dots, ..drawn }
    }

    /// Returns points in pixels from the middle of the canvas: to the right, up, towards the camera.
    fn as_seen(&self, positions: &[Point3<f64>]) -> Vec<[f32; 3]> {
        let scale = self.view.pixels_per_unit(f64::from(self.width), f64::from(self.height));
        positions.iter().map(|point| self.view.seen(scale, point).map(|c| c as f32)).collect()
    }

    fn corner(&self, [right, up, towards]: [f32; 3]) -> Option<Corner> {
        let samples = |pixels: f64| pixels * PER_PIXEL as f64;
        let (x, y) = (f64::from(self.width) / 2.0 + f64::from(right), f64::from(self.height) / 2.0 - f64::from(up));
        Corner::new(samples(x), samples(y), -f64::from(towards))
    }

    /// Returns the mean colour of those samples of a pixel that show a surface, and their share.
    fn resolve(&self, column: usize, row: usize) -> (Colour, f64) {
        let mut sum = [0u32; 3];
        let mut count = 0;
        for y in row * PER_PIXEL..(row + 1) * PER_PIXEL {
            for x in column * PER_PIXEL..(column + 1) * PER_PIXEL {
                let Some((depth, colour)) = self.samples.at(x, y) else { continue };
                let colour = if self.is_outline(x, y, depth) { mix(colour, INK, OUTLINE_COVER) } else { colour };
                (0..3).for_each(|c| sum[c] += u32::from(colour[c]));
                count += 1;
            }
        }
        let mean = sum.map(|s| (s + count / 2).checked_div(count).unwrap_or(0) as u8);
        (mean, f64::from(count) / (PER_PIXEL * PER_PIXEL) as f64)
    }

    /// Returns whether a neighbour of a sample is empty or lies far behind it.
    fn is_outline(&self, x: usize, y: usize, depth: f32) -> bool {
        let far = depth + OUTLINE_STEP * self.width.min(self.height) as f32;
        let neighbours = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
        neighbours.into_iter().any(|(x, y)| {
            // Beyond the edge of the picture the surface may go on.
            let inside = x < self.samples.width && y < self.samples.height;
            inside && self.samples.at(x, y).is_none_or(|(other, _)| other > far)
        })
    }
}

/// Normals of vertices, each the sum of those of the faces around it, weighted by area.
struct Normals<'a> {
    points: &'a [[f32; 3]],
    of_vertices: Vec<[f32; 3]>,
}

impl<'a> Normals<'a> {
    fn new(points: &'a [[f32; 3]], triangles: &[[u32; 3]]) -> Self {
        let mut of_vertices = vec![[0.0; 3]; points.len()];
        for triangle in triangles {
            let vertices = triangle.map(|vertex| vertex as usize);
            if let Some(area) = area_normal(points, vertices) {
                vertices.iter().for_each(|vertex| (0..3).for_each(|c| of_vertices[*vertex][c] += area[c]));
            }
        }
        of_vertices.iter_mut().for_each(|sum| *sum = unit(*sum).unwrap_or_default());
        Self { points, of_vertices }
    }

    /// Returns unit normals at the corners of a triangle: the vertex' own, or at a crease the face's.
    fn at_corners(&self, vertices: [usize; 3]) -> [[f32; 3]; 3] {
        let smooth = vertices.map(|vertex| self.of_vertices[vertex]);
        let Some(face) = area_normal(self.points, vertices).and_then(unit) else { return smooth };
        smooth.map(|normal| if dot(normal, face) < CREASE { face } else { normal })
    }
}

/// Returns the normal of a triangle, twice its area long; `None` if a vertex is missing or the normal is not finite.
fn area_normal(points: &[[f32; 3]], [a, b, c]: [usize; 3]) -> Option<[f32; 3]> {
    let (a, b, c) = (points.get(a)?, points.get(b)?, points.get(c)?);
    let [p, q]: [[f32; 3]; 2] = [b, c].map(|end| std::array::from_fn(|i| end[i] - a[i]));
    let normal = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
    normal.iter().all(|c| c.is_finite()).then_some(normal)
}

#[cfg(test)]
mod tests;
