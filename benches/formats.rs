//! Reading and writing files in memory, by number of triangles; the column of the counter has bytes a second.

mod support;

use divan::{Bencher, counter::BytesCount};
use mimesh::core::{
    stage::{BytesInput, Format, MeshWriter, Selection},
    testkit::memory_file::MemoryFile,
};
use support::{Animal, FACES, Shape, animal, default_stage};

const READ: [&str; 6] = ["obj", "ply", "off", "stl", "glb", "gltf"];
/// Point caches and USD are written; a cache alone holds no mesh.
const WRITTEN: [&str; 9] = ["obj", "ply", "off", "stl", "glb", "gltf", "pc2", "mdd", "usda"];

fn main() {
    support::main();
}

/// The file of an animal at rest, or with its poses where the format holds several.
fn file(format: &dyn Format, animal: &Animal) -> Vec<u8> {
    let (mesh, mut out) = (&animal.mesh.rest, Vec::new());
    match format.writer().expect("a format that writes") {
        MeshWriter::Pose(writer) => writer.write(mesh, &mesh.positions, &mut out).expect("a file"),
        MeshWriter::Sequence(format) => {
            let file = MemoryFile::default();
            let mut writer = format.start(mesh, animal.mesh.poses.len(), Box::new(file.clone())).expect("a file");
            for pose in &animal.mesh.poses {
                writer.add(&pose.name, None, &pose.positions.get().expect("held")).expect("a pose");
            }
            writer.finish().expect("a file");
            out = file.bytes();
        }
    }
    out
}

#[divan::bench(args = READ, consts = FACES)]
fn read<const F: usize>(bencher: Bencher, name: &str) {
    let format = default_stage::<dyn Format>(name);
    let input = BytesInput::new(format!("horse.{name}"), file(&*format, animal(Shape::Horse(F))));
    let counter = BytesCount::new(input.contents.len());
    bencher.counter(counter).bench(|| format.read(&input, &Selection::default()).expect("a mesh"));
}

#[divan::bench(args = WRITTEN, consts = FACES)]
fn write<const F: usize>(bencher: Bencher, name: &str) {
    let (format, horse) = (default_stage::<dyn Format>(name), animal(Shape::Horse(F)));
    let counter = BytesCount::new(file(&*format, horse).len());
    bencher.counter(counter).bench(|| file(&*format, horse));
}
