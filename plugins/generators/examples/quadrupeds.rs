//! Writes the sample animals with a gait as OBJ files into a folder, to look at: `cargo run --example quadrupeds --
//! FOLDER`.

use std::{fmt::Write, fs, path::Path, time::Instant};

use mimesh_core::{mesh::Mesh, stage::Generator};
use mimesh_generators::quadruped::{Gait, MadeOf, Proportions, Quadruped};
use nalgebra::Point3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).ok_or("name a folder")?;
    let folder = Path::new(&folder);
    fs::create_dir_all(folder)?;
    for proportions in [Proportions::Horse, Proportions::Camel, Proportions::Giraffe] {
        for made_of in [MadeOf::Skin, MadeOf::Pebbles, MadeOf::Plates, MadeOf::Boxes] {
            for gait in [Gait::Gallop, Gait::Walk] {
                let start = Instant::now();
                let animal = Quadruped { proportions, gait, made_of, ..Quadruped::default() }.make()?;
                let name = format!("{proportions:?}-{made_of:?}").to_lowercase();
                println!(
                    "{name} {gait:?}: {} vertices, {} components, {} landmarks, {:.0?}",
                    animal.rest.positions.len(),
                    animal.rest.parts.len().max(1),
                    animal.landmarks.len(),
                    start.elapsed()
                );
                write_obj(&folder.join(format!("{name}.obj")), &animal.rest, &animal.rest.positions)?;
                for pose in &animal.poses {
                    let file = format!("{name}-{gait:?}-{}.obj", pose.name).to_lowercase();
                    write_obj(&folder.join(file), &animal.rest, &pose.positions.get()?)?;
                }
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
