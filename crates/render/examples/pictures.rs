//! Draws a mesh and its poses: a contact sheet, a map of how far vertices moved, and numbered points.
//!
//! ```sh
//! cargo run --release -p mimesh-render --example pictures -- FOLDER REST.obj [POSE.obj ...]
//! ```
//!
//! The files go to FOLDER; times and sizes are printed.

use mimesh_render::{
    Bounds, Canvas, Cell, Direction, Dot, Paint, Picture, Rect, Scale, UpAxis, View, colour, legend, sheet,
};
use nalgebra::Point3;
use std::error::Error;
use std::path::Path;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, rest, poses @ ..] = arguments.as_slice() else {
        return Err("usage: pictures FOLDER REST.obj [POSE.obj ...]".into());
    };
    std::fs::create_dir_all(folder)?;
    let (positions, triangles) = read_obj(rest)?;
    let poses =
        poses.iter().map(|pose| Ok((name_of(pose), read_obj(pose)?.0))).collect::<Result<Vec<_>, Box<dyn Error>>>()?;
    let up = UpAxis::Y;
    let save = |name: &str, picture: &Picture| -> Result<(), Box<dyn Error>> {
        let start = Instant::now();
        let file = picture.small_png();
        let (time, exact) = (start.elapsed(), picture.png().len());
        println!("{name}: {} x {}, {} bytes in {time:.1?}, exact {exact}", picture.width, picture.height, file.len());
        Ok(std::fs::write(Path::new(folder).join(name), file)?)
    };

    for (name, direction) in [
        ("front.png", Direction::Front),
        ("side.png", Direction::Side),
        ("top.png", Direction::Top),
        ("three-quarter.png", Direction::ThreeQuarter),
    ] {
        let view = View::fit(positions.iter().copied(), direction, up);
        let mut picture = Picture::new(480, 240, colour::WHITE);
        let start = Instant::now();
        for (x, shade) in [(0, colour::STEEL), (240, colour::SAND)] {
            let mut canvas = Canvas::new(240, 240, view);
            canvas.mesh(&positions, &triangles, &Paint::Plain(shade));
            canvas.draw_onto(&mut picture, x, 0);
        }
        println!("two meshes of {} triangles in {:.1?}", triangles.len(), start.elapsed());
        save(name, &picture)?;
    }

    let framed = poses.iter().flat_map(|(_, pose)| pose).copied();
    let view = View::fit(framed, Direction::Angles { yaw: 60.0, pitch: 14.0 }, up);
    let size = Bounds::of(&positions);
    let diagonal = (size.high - size.low).norm();
    let moved = |pose: &[Point3<f64>]| -> Vec<f64> {
        pose.iter().zip(&positions).map(|(posed, rest)| (posed - rest).norm() / diagonal * 100.0).collect()
    };
    let scale = Scale::covering(poses.iter().flat_map(|(_, pose)| moved(pose)));
    let mut rows = Vec::new();
    for (name, pose) in &poses {
        let values = moved(pose);
        let paints = [Paint::Plain(colour::STEEL), Paint::Values { values: &values, scale: &scale }];
        let cells = paints.into_iter().map(|paint| {
            let mut picture = Picture::new(240, 200, colour::WHITE);
            let mut canvas = Canvas::new(240, 200, view);
            canvas.mesh(pose, &triangles, &paint);
            canvas.draw_onto(&mut picture, 0, 0);
            Cell { picture, caption: format!("{name} — moved since {}", name_of(rest)) }
        });
        rows.extend(cells);
    }
    let mut rows: Vec<Vec<Cell>> = rows.chunks(4).map(<[Cell]>::to_vec).collect();
    let mut bar = Picture::new(240, 32, colour::WHITE);
    legend(&mut bar, Rect { x: 0, y: 0, width: 240, height: 32 }, &scale, "%");
    let mut tall = Picture::new(240, 160, colour::WHITE);
    legend(&mut tall, Rect { x: 90, y: 0, width: 90, height: 160 }, &scale, "% of size");
    rows.push(vec![Cell { picture: bar, caption: "moved".into() }, Cell { picture: tall, caption: String::new() }]);
    save("sheet.png", &sheet(&format!("Poses of {}", name_of(rest)), &rows))?;

    for (name, count, width) in [("dots-20.png", 20, 480), ("dots-107.png", 107, 480), ("dots-small.png", 20, 240)] {
        let view = View::fit(positions.iter().copied(), Direction::Angles { yaw: 70.0, pitch: 12.0 }, up);
        let mut picture = Picture::new(width, width * 4 / 5, colour::WHITE);
        let mut canvas = Canvas::new(width, width * 4 / 5, view);
        canvas.mesh(&positions, &triangles, &Paint::Plain(colour::STEEL));
        let step = positions.len() / count;
        let dots: Vec<Dot> = (0..count)
            .map(|i| Dot { at: positions[i * step], label: Some((i + 1).to_string()), colour: colour::CRIMSON })
            .collect();
        canvas.dots(&dots);
        println!("{:?}", canvas.draw_onto(&mut picture, 0, 0));
        save(name, &picture)?;
    }

    let parts: Vec<colour::Colour> =
        triangles.iter().map(|t| colour::of_part(t[0] as usize * 12 / positions.len())).collect();
    let view = View::fit(positions.iter().copied(), Direction::ThreeQuarter, up);
    let mut picture = Picture::new(480, 360, colour::WHITE);
    let mut canvas = Canvas::new(480, 360, view);
    let flipped: Vec<[u32; 3]> = triangles
        .iter()
        .enumerate()
        .map(|(i, [a, b, c])| if i % 400 == 0 { [*a, *c, *b] } else { [*a, *b, *c] })
        .collect();
    canvas.mesh(&positions, &flipped, &Paint::Triangles(&parts));
    canvas.draw_onto(&mut picture, 0, 0);
    save("parts.png", &picture)?;
    speed();
    Ok(())
}

/// Times a sphere of 100,000 triangles in a cell of 240 × 240 pixels, the least of 20 times.
fn speed() {
    let (rings, segments) = (250_u32, 200_u32);
    let place = |i: u32| {
        let (sin, cos) = (std::f64::consts::PI * f64::from(i / segments) / f64::from(rings)).sin_cos();
        let (turn_sin, turn_cos) = (std::f64::consts::TAU * f64::from(i % segments) / f64::from(segments)).sin_cos();
        Point3::new(sin * turn_sin, cos, sin * turn_cos)
    };
    let positions: Vec<Point3<f64>> = (0..(rings + 1) * segments).map(place).collect();
    let corners = |i: u32| {
        let next = i / segments * segments + (i + 1) % segments;
        [[i, i + segments, next + segments], [i, next + segments, next]]
    };
    let triangles: Vec<[u32; 3]> = (0..rings * segments).flat_map(corners).collect();
    let values: Vec<f64> = positions.iter().map(|p| p.x).collect();
    let view = View::fit(positions.iter().copied(), Direction::ThreeQuarter, UpAxis::Y);
    let scale = Scale::new(-1.0, 1.0);
    for paint in [Paint::Plain(colour::STEEL), Paint::Values { values: &values, scale: &scale }] {
        let draw = || {
            let start = Instant::now();
            let mut canvas = Canvas::new(240, 240, view);
            canvas.mesh(&positions, &triangles, &paint);
            let mesh = start.elapsed();
            canvas.draw_onto(&mut Picture::new(240, 240, colour::WHITE), 0, 0);
            (start.elapsed(), mesh)
        };
        let (all, mesh) = (0..20).map(|_| draw()).min().unwrap_or_default();
        println!("{} triangles at 240 x 240: {all:.1?}, of it the mesh {mesh:.1?}", triangles.len());
    }
}

fn name_of(path: &str) -> String {
    Path::new(path).file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Positions and triangles of an OBJ file, polygons as fans from their first corner.
#[expect(clippy::type_complexity, reason = "an example needs no name for it")]
fn read_obj(path: &str) -> Result<(Vec<Point3<f64>>, Vec<[u32; 3]>), Box<dyn Error>> {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for line in std::fs::read_to_string(path)?.lines() {
        let mut words = line.split_whitespace();
        match words.next() {
            Some("v") => {
                let numbers = words.take(3).map(str::parse).collect::<Result<Vec<f64>, _>>()?;
                positions.push(Point3::from_slice(&numbers));
            }
            Some("f") => {
                let index = |word: &str| word.split('/').next().unwrap_or_default().parse::<u32>().map(|i| i - 1);
                let corners = words.map(index).collect::<Result<Vec<u32>, _>>()?;
                triangles.extend(corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]]));
            }
            _ => {}
        }
    }
    Ok((positions, triangles))
}
