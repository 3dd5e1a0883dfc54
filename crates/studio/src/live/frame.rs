//! Frames: positions of a mesh in a pose, with what they are.

use std::time::Instant;

use nalgebra::Point3;
use serde_json::{Value, json};

use super::{
    look::{Channel, Look},
    pair::LiveMarkers,
    result::Field,
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
    /// When its computation began.
    pub began: Instant,
}

impl Shown<'_> {
    /// The frame with the vertices of a file at `positions`, coloured by `field`.
    pub fn frame(self, positions: &[Point3<f64>], field: Option<&Field>) -> Vec<u8> {
        let Self { project, channel, look, live, began } = self;
        let side = usize::from(channel != Channel::Source);
        let positions = container::relative(positions, project.meshes.origins[side]);
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
            "pipeline": project.pipeline.revision(),
            "scalar": scalar,
            "milliseconds": (began.elapsed().as_secs_f64() * 1e4).round() / 10.0,
        });
        let mut arrays = vec![("positions", Numbers::F32(&positions))];
        if let Some(field) = field {
            arrays.push(("scalars", Numbers::F32(&field.values)));
        }
        container::write(header, &arrays)
    }
}
