//! Pictures of meshes, for notebooks.

use mimesh_render::{Canvas, Direction, Paint, Picture, UpAxis, View, colour};
use numpy::PyReadonlyArray2;
use pyo3::{prelude::*, types::PyBytes};

use crate::{
    error::{exception_of, misuse},
    mesh::MeshData,
    surface::poses,
};

/// A PNG of each pose, all of them seen from one place at one scale.
#[pyfunction]
pub fn draw<'py>(
    py: Python<'py>,
    mesh: &Bound<'py, MeshData>,
    shown: Vec<PyReadonlyArray2<'py, f64>>,
    view: &str,
    up: &str,
    size: u32,
) -> PyResult<Vec<Bound<'py, PyBytes>>> {
    let wrong = |what: &str, found: &str, known: &str| misuse(py, format!("{what}: unknown value `{found}`"), known);
    let direction = match view {
        "three_quarter" => Direction::ThreeQuarter,
        "front" => Direction::Front,
        "side" => Direction::Side,
        "top" => Direction::Top,
        _ => return Err(wrong("view", view, "known values: three_quarter, front, side, top")),
    };
    let up = match up {
        "y" => UpAxis::Y,
        "z" => UpAxis::Z,
        _ => return Err(wrong("up", up, "known values: y, z")),
    };
    if !(16..=2048).contains(&size) {
        return Err(wrong("size", &size.to_string(), "expected 16 to 2048 pixels"));
    }
    let rest = mesh.get().sequence.clone();
    let shown = poses(&shown, rest.rest.positions.len()).map_err(|error| exception_of(py, error))?;
    let files: Vec<Vec<u8>> = py.detach(|| {
        let (triangles, _) = rest.rest.polygons.fans();
        let view = View::fit(shown.iter().flatten().copied(), direction, up);
        let draw = |positions: &Vec<_>| {
            let mut canvas = Canvas::new(size, size, view.clone());
            canvas.mesh(positions, &triangles, &Paint::Plain(colour::STEEL));
            let mut picture = Picture::new(size, size, colour::WHITE);
            canvas.draw_onto(&mut picture, 0, 0);
            picture.png()
        };
        shown.iter().map(draw).collect()
    });
    Ok(files.iter().map(|file| PyBytes::new(py, file)).collect())
}
