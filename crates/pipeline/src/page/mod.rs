//! Pages of HTML that show a run, or several beside each other: verdicts, pictures, curves, settings and provenance.
//!
//! A page is one file. It is made from what `run.json` holds and from pictures. No script runs in it, so that it opens
//! anywhere, prints, and can be mailed. Only where a pipeline asks for a 3D view, one script and its data stand in it too. Colours follow the reader's light or dark preference.

mod averages;
pub mod chart;
mod compare;
mod content_policy;
mod curves;
mod elements;
mod facts;
mod next_steps;
mod poses;
mod run;
mod scene;
mod view_3d;
mod words;

pub use self::{
    compare::{ComparedRun, average, best, columns, compare},
    content_policy::script_source,
    elements::{Image, PanelImages},
    next_steps::next_steps,
    run::{Pictures, page},
    scene::{Coordinates, Scene, SceneField, SceneMesh, ScenePose, View3d},
};
