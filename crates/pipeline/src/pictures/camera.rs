//! The direction from which meshes are drawn.

use mimesh_render::{Direction, UpAxis, View};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::{
    report::{MeshView, Report},
    spec::{PictureSettings, Up, ViewFrom},
};

/// The side that a mesh is seen from.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// The direction from the mesh to the camera.
    pub direction: Direction,
    /// The axis of the mesh's file that points up.
    pub up: UpAxis,
    /// The rotation that takes the mesh into the axes in which it is looked at.
    pub turn: Matrix3<f64>,
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
        Self { direction, up: axis(settings.up.unwrap_or_default()), turn: Matrix3::identity() }
    }
}

impl Camera {
    /// Returns the camera for a target, whose file may have another axis up.
    pub fn of_target(settings: PictureSettings) -> Self {
        PictureSettings { up: settings.target_up.or(settings.up), ..settings }.into()
    }

    /// Returns the camera for the target of a run, which sees it as the pictures of the run do.
    ///
    /// # Errors
    ///
    /// If the settings in the report cannot be read.
    pub fn of_report(report: &Report) -> serde_json::Result<Self> {
        let settings = serde_json::from_value(report.settings["pictures"].clone())?;
        let Some(view) = report.target_view else { return Ok(Self::of_target(settings)) };
        Ok(Self { up: axis(view.up), turn: Matrix3::from(view.turn), ..settings.into() })
    }

    /// Returns how this camera sees its mesh, as reports keep it.
    pub fn mesh_view(self) -> MeshView {
        let up = match self.up {
            UpAxis::X => Up::X,
            UpAxis::Y => Up::Y,
            UpAxis::Z => Up::Z,
        };
        MeshView { up, turn: self.turn.into() }
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

    /// Returns unit vectors to the right, up and towards the eye of one who stands in front of the mesh.
    pub(super) fn axes(self) -> [Vector3<f64>; 3] {
        View::fit_turned([], Direction::Front, self.up, &self.turn).axes()
    }

    /// Returns the view that frames `positions` (#V).
    pub(super) fn view(self, positions: &[Point3<f64>]) -> View {
        View::fit_turned(positions.iter().copied(), self.direction, self.up, &self.turn)
    }
}

/// Returns the axis for pictures.
fn axis(up: Up) -> UpAxis {
    match up {
        Up::X => UpAxis::X,
        Up::Y => UpAxis::Y,
        Up::Z => UpAxis::Z,
    }
}
