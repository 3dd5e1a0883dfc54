//! Made animals as files, without the names of their points.

use std::fmt::Write as _;

use mimesh::core::{mesh::MeshSequence, plugin::configured, stage::Generator};
use nalgebra::Point3;
use serde_json::{Value, json};

use super::Project;

/// A quadruped with these settings.
pub fn animal(settings: Value) -> MeshSequence {
    let mut all = json!({ "type": "quadruped", "frames": 2, "resolution": 30 });
    all.as_object_mut().expect("a mapping").extend(settings.as_object().expect("a mapping").clone());
    configured::<dyn Generator>(all).expect("a quadruped").make().expect("an animal")
}

/// An OBJ of `mesh` at `positions`.
pub fn obj(mesh: &MeshSequence, positions: &[Point3<f64>]) -> String {
    let mut text = String::new();
    positions.iter().for_each(|p| _ = writeln!(text, "v {} {} {}", p.x, p.y, p.z));
    for polygon in mesh.rest.polygons.iter() {
        let corners: Vec<_> = polygon.iter().map(|v| (v + 1).to_string()).collect();
        let _ = writeln!(text, "f {}", corners.join(" "));
    }
    text
}

/// Writes `NAME.obj` and `NAME-POSE.obj` for each pose.
pub fn write(project: &Project, name: &str, settings: Value) {
    let mesh = animal(settings);
    project.write(&format!("{name}.obj"), &obj(&mesh, &mesh.rest.positions));
    for pose in &mesh.poses {
        project.write(&format!("{name}-{}.obj", pose.name), &obj(&mesh, &pose.positions.get().unwrap()));
    }
}

/// The samples' gallop, small, with a report.
pub fn gallop(project: &Project, more: &str) {
    project.write(
        "g.yaml",
        &format!(
            "source: {{ generator: {{ type: quadruped, proportions: horse, gait: gallop, resolution: 20, frames: 4 }} }}
target: {{ generator: {{ type: quadruped, proportions: camel, gait: gallop, resolution: 20, frames: 4, seed: 1 }} }}
correspondence: {{ type: nonrigid_fit }}
transfer: {{ type: gradient }}
output: [out/report.html, out/sheet.png, out/camel.glb]
{more}"
        ),
    );
}
