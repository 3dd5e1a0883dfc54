//! Frames: positions of a mesh in a pose, with what they are.

use std::time::Instant;

use nalgebra::Point3;
use serde_json::{Value, json};

use super::{
    look::{Channel, Look},
    measure::Field,
    pair::LiveMarkers,
};
use crate::{
    container::{self, Numbers},
    project::Project,
    scalars,
};

/// What a frame shows.
#[derive(Clone, Copy, Debug)]
pub struct Shown<'a> {
    /// The project.
    pub project: &'a Project,
    /// The channel.
    pub channel: Channel,
    /// The look that it answers.
    pub look: &'a Look,
    /// The markers that it was made with.
    pub live: &'a LiveMarkers,
    /// The revision of the pipeline that it is of.
    pub pipeline: u64,
    /// When its computation began.
    pub began: Instant,
}

impl Shown<'_> {
    /// The frame with the vertices of a file at `positions`, coloured by `field`.
    pub fn frame(self, positions: &[Point3<f64>], field: Option<&Field>) -> Vec<u8> {
        let side = usize::from(self.channel != Channel::Source);
        self.relative_frame(&container::relative(positions, self.project.meshes.origins[side]), field)
    }

    /// The same of positions that are relative to the origin of the mesh already.
    pub fn relative_frame(self, positions: &[f32], field: Option<&Field>) -> Vec<u8> {
        let Self { project, channel, look, live, pipeline, began } = self;
        let scalar = field.map(|field| {
            let name = look.scalar.as_deref().unwrap_or_default();
            let (title, unit) = (scalars::title(name), scalars::unit(field.words));
            json!({ "name": name, "title": title, "unit": unit, "low": 0.0, "high": field.high, "limit": Value::Null })
        });
        let header = json!({
            "project": project.number,
            "channel": channel,
            "look": look.look,
            "drag": live.drag,
            "pose": look.pose,
            "revision": live.revision,
            "pipeline": pipeline,
            "scalar": scalar,
            "milliseconds": (began.elapsed().as_secs_f64() * 1e4).round() / 10.0,
        });
        let mut arrays = vec![("positions", Numbers::F32(positions))];
        if let Some(field) = field {
            arrays.push(("scalars", Numbers::F32(&field.values)));
        }
        container::write(header, &arrays)
    }
}
