//! The settings with which a glTF is written.

use mimesh_core::spatial::{LengthUnit, MeshUnits, UnitAxes, UpAxis};
use nalgebra::Vector3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// The settings with which a glTF is written.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Poses a second.
    pub frames_per_second: f64,
    /// Whether poses have their own normals.
    pub pose_normals: bool,
    /// The animation that shows the poses.
    pub animation: PoseAnimation,
    /// The unit of the mesh.
    pub unit: LengthUnit,
    /// The upward axis of the mesh.
    pub up: UpAxis,
    /// One binary file, or JSON with the numbers inside.
    pub binary: bool,
}

/// The animation that is written for poses.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, JsonSchema, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PoseAnimation {
    /// As `clip_times` if all poses have a time in a clip, as `play` if they have numbered names, else `none`.
    #[default]
    Auto,
    /// No animation: all morph targets are at 0 until someone moves them.
    None,
    /// One animation that shows pose after pose, at `frames_per_second`.
    Play,
    /// One animation a clip that the poses come from, at the times in that clip.
    ClipTimes,
}

impl Options {
    /// The properties that place a node so that stored positions + `offset`, in unit and axes of the mesh, are in metres, Y up.
    pub fn node_transform(&self, offset: Vector3<f64>) -> Value {
        let mut node = json!({});
        let scale = self.unit.metres();
        let up = MeshUnits { unit: None, up: Some(self.up) };
        let turned = UnitAxes::between(up, MeshUnits::METRES_Y_UP).turn(&offset);
        if offset != Vector3::zeros() {
            node["translation"] = json!(<[f64; 3]>::from(turned * scale));
        }
        let half = 0.5_f64.sqrt();
        match self.up {
            UpAxis::Y => {}
            UpAxis::Z => node["rotation"] = json!([-half, 0.0, 0.0, half]),
            // A third of a turn about (1, 1, 1).
            UpAxis::X => node["rotation"] = json!([0.5, 0.5, 0.5, 0.5]),
        }
        if scale != 1.0 {
            node["scale"] = json!([scale, scale, scale]);
        }
        node
    }
}
