//! Writes the sample animals with a gait as OBJ files into a folder, to look at: `cargo run --example quadrupeds --
//! FOLDER`.

use std::{fmt::Write, fs, path::Path, time::Instant};

use mimesh_core::{mesh::Mesh, stage::Sample};
use mimesh_samples::quadruped::{Gait, Proportions, Quadruped};
use nalgebra::Point3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).ok_or("name a folder")?;
    for (name, proportions) in
        [("horse", Proportions::Horse), ("camel", Proportions::Camel), ("giraffe", Proportions::Giraffe)]
    {
        for gait in [Gait::Gallop, Gait::Walk] {
            let start = Instant::now();
            let animal = Quadruped { proportions, gait, ..Quadruped::default() }.make()?;
            let count = animal.rest.positions.len();
            println!(
                "{name} {gait:?}: {count} vertices, {} landmarks, {:.0?}",
                animal.landmarks.len(),
                start.elapsed()
            );
            write_obj(&Path::new(&folder).join(format!("{name}.obj")), &animal.rest, &animal.rest.positions)?;
            for pose in &animal.poses {
                write_obj(
                    &Path::new(&folder).join(format!("{name}-{gait:?}-{}.obj", pose.name)),
                    &animal.rest,
                    &pose.positions,
                )?;
            }
        }
    }
    Ok(())
}

fn write_obj(path: &Path, mesh: &Mesh, positions: &[Point3<f64>]) -> Result<(), Box<dyn std::error::Error>> {
    let mut text = String::new();
    for p in positions {
        writeln!(text, "v {} {} {}", p.x, p.y, p.z)?;
    }
    for polygon in mesh.polygons.iter() {
        writeln!(text, "f{}", polygon.iter().map(|v| format!(" {}", v + 1)).collect::<String>())?;
    }
    Ok(fs::write(path, text)?)
}
