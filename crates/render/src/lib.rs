//! Pictures of triangle meshes, drawn without a graphics card or a display.
//!
//! In reading order:
//! - [`Picture`]: pixels with text and lines, written as PNG;
//! - [`View`]: an orthographic camera that frames points from a [`Direction`];
//! - [`Canvas`]: the depth buffer that meshes with their [`Paint`] and numbered [`Dot`]s are drawn into;
//! - [`Scale`] and [`legend`]: the colours of values, and the bar that explains them;
//! - [`sheet`]: pictures in rows and columns with captions.
//!
//! ```
//! use mimesh_render::{colour, Canvas, Direction, Paint, Picture, UpAxis, View};
//! use nalgebra::Point3;
//!
//! let positions = [Point3::new(0.0, 0.0, 0.0), Point3::new(1.0, 0.0, 0.0), Point3::new(0.0, 1.0, 0.0)];
//! let view = View::fit(positions, Direction::Front, UpAxis::Y);
//! let mut canvas = Canvas::new(240, 180, view);
//! canvas.mesh(&positions, &[[0, 1, 2]], &Paint::Plain(colour::STEEL));
//! let mut picture = Picture::new(240, 180, colour::WHITE);
//! canvas.draw_onto(&mut picture, 0, 0);
//! assert!(picture.png().starts_with(b"\x89PNG"));
//! ```
//!
//! Nothing here fails or panics on bad input. Triangles that cannot be drawn, because a coordinate is not finite or a
//! corner names no vertex, are left out and counted in [`Drawn`]. A picture depends on its input alone, to the last bit,
//! and several can be drawn at once on as many threads.
//!
//! embedded-graphics draws text and lines, png writes files, and quantizr reduces colours: on these pictures its files are
//! smaller and closer to the original than quantette's and color_quant's. The depth buffer is our own because the one
//! rasteriser crate that needs no graphics card, euc, has had no release since 2020.

mod bounds;
mod canvas;
pub mod colour;
mod dots;
mod legend;
mod picture;
mod png;
mod raster;
mod scale;
mod shade;
mod sheet;
mod text;
mod view;

pub use bounds::Bounds;
pub use canvas::{Canvas, Drawn, Paint};
pub use colour::Colour;
pub use dots::{Dot, DotsDrawn};
pub use legend::legend;
pub use picture::{Picture, Rect};
pub use scale::Scale;
pub use sheet::{Cell, sheet};
pub use text::Size;
pub use view::{Direction, Placed, UpAxis, View};
