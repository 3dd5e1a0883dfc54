//! Pictures of the results of a run, for the page.

use mimesh_pipeline::Reach;
use std::path::Path;

use mimesh_core::mesh::Surface;
use mimesh_pipeline::{
    Formats, Report,
    page::Image,
    pictures::{self, Camera},
    spec::PictureSettings,
};
use rayon::prelude::*;

use crate::cli::{
    compare::{
        results::{GroundTruth, PosedResult, read_results},
        written_files::WrittenFiles,
    },
    roots::Roots,
};

/// The largest number of poses of a run that are drawn; of more poses some are chosen, spread over all.
const MAX_POSES: usize = 24;
/// Width and height of a picture in pixels.
const PIXELS: u32 = 280;

/// Draws poses of the run whose report is `file`, and gives sentences on those that could not be drawn.
///
/// Meshes may open files in the folders `roots` and in that of the pipeline.
pub fn draw(report: &Report, file: &Path, roots: &Roots) -> (Vec<Image>, Vec<String>) {
    let pipeline = report.pipeline.parent().map(Path::to_path_buf);
    let formats = Formats::new(vec![], Reach::new(roots.folders().into_iter().chain(pipeline)));
    let written = WrittenFiles::new(report, file);
    match read_results(report, &written, &formats, MAX_POSES) {
        Ok(results) => {
            let camera = camera(report);
            let truth = GroundTruth::read(report, &formats);
            let images = results.par_iter().filter_map(|result| image(result, truth.as_ref(), camera)).collect();
            (images, written.changes().into_iter().collect())
        }
        Err(problem) => (vec![], vec![format!("no pictures: {problem}")]),
    }
}

/// The camera that looks at the target of a run as the run's own pictures do.
fn camera(report: &Report) -> Camera {
    Camera::of_report(report).unwrap_or_else(|_| PictureSettings::default().into())
}

/// Draws one result, with its errors in colour where the truth is known.
fn image(result: &PosedResult, truth: Option<&GroundTruth>, camera: Camera) -> Option<Image> {
    let surface = Surface::new(&result.mesh).ok()?;
    let errors = truth.and_then(|truth| truth.errors(result));
    let picture = pictures::draw_mesh(&surface, errors.as_deref(), camera, PIXELS);
    Some(pictures::image(&result.name, format!("result of pose {}", result.name), &picture))
}
