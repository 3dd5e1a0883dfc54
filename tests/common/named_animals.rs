//! Built-in animals by name of their known points.

use mimesh_core::{
    mesh::{MeshSequence, Surface},
    plugin::configured,
    stage::Generator,
};
use nalgebra::Point3;
use serde_json::{Value, json};

/// An animal, its points by name, and its surface.
pub struct Animal {
    pub names: Vec<String>,
    pub places: Vec<Point3<f64>>,
    pub surface: Surface,
}

/// The animal of the generator `quadruped` with other `settings`, which stands still.
pub fn animal(settings: Value) -> Animal {
    let mut all = json!({ "type": "quadruped", "gait": "none", "resolution": 60 });
    all.as_object_mut().unwrap().extend(settings.as_object().unwrap().clone());
    let sequence: MeshSequence = configured::<dyn Generator>(all).expect("a quadruped").make().expect("an animal");
    let surface = Surface::new(&sequence.rest).expect("a surface");
    let place = |point| surface.point(point).expect("a point").position(&surface, &surface.positions);
    Animal {
        names: sequence.landmarks.iter().map(|landmark| landmark.name.clone()).collect(),
        places: sequence.landmarks.iter().map(|landmark| place(landmark.point)).collect(),
        surface,
    }
}
