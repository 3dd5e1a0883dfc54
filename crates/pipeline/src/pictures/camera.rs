//! The direction from which meshes are drawn.

use mimesh_render::{Direction, UpAxis, View};
use nalgebra::Point3;

use crate::spec::{PictureSettings, Up, ViewFrom};

/// The side that a mesh is seen from.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// The direction from the mesh to the camera.
    pub direction: Direction,
    /// The axis of the mesh's file that points up.
    pub up: UpAxis,
}

impl From<PictureSettings> for Camera {
    /// The camera for a source.
    fn from(settings: PictureSettings) -> Self {
        let direction = match settings.view {
            ViewFrom::ThreeQuarter => Direction::ThreeQuarter,
            ViewFrom::Front => Direction::Front,
            ViewFrom::Side => Direction::Side,
            ViewFrom::Top => Direction::Top,
        };
        let up = match settings.up {
            Up::X => UpAxis::X,
            Up::Y => UpAxis::Y,
            Up::Z => UpAxis::Z,
        };
        Self { direction, up }
    }
}

impl Camera {
    /// Returns the camera for a target, whose file may have another axis up.
    pub fn of_target(settings: PictureSettings) -> Self {
        PictureSettings { up: settings.target_up.unwrap_or(settings.up), ..settings }.into()
    }

    /// Returns the camera on the other side of the mesh.
    pub(super) fn behind(self) -> Self {
        let direction = match self.direction {
            Direction::ThreeQuarter => Direction::Angles { yaw: 220.0, pitch: 18.0 },
            Direction::Front => Direction::Angles { yaw: 180.0, pitch: 0.0 },
            Direction::Side => Direction::Angles { yaw: 270.0, pitch: 0.0 },
            Direction::Top | Direction::Angles { .. } => Direction::Angles { yaw: 0.0, pitch: -90.0 },
        };
        Self { direction, ..self }
    }

    /// Returns the view that frames `positions` (#V).
    pub(super) fn view(self, positions: &[Point3<f64>]) -> View {
        View::fit(positions.iter().copied(), self.direction, self.up)
    }
}
