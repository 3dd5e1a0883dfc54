//! The page that shows a run.

use maud::{Markup, html};

use super::{
    averages::averages,
    curves::curves,
    elements::{Image, PanelImages, document, figure},
    facts,
    next_steps::next_steps_section,
    poses,
    scene::View3d,
    view_3d,
};
use crate::{input::HelpCommands, report::Report};

/// The pictures of a run.
#[derive(Clone, Debug, Default)]
pub struct Pictures {
    /// The meshes at rest, with their markers.
    pub rest: Vec<Image>,
    /// Large pictures of the worst poses.
    pub worst: Vec<PanelImages>,
    /// Small pictures of all poses, or of some spread over them.
    pub sheet: Vec<Image>,
    /// The worst poses to be turned, if the pipeline asks for that.
    pub view_3d: Option<View3d>,
}

/// Returns the page of a run; its next steps name the commands of the host, `help`.
pub fn page(report: &Report, pictures: &Pictures, help: &HelpCommands) -> String {
    let name = report.pipeline.file_stem().unwrap_or_default().to_string_lossy();
    let title = match &report.run {
        Some(run) => format!("{name} · {}", run.name),
        None => name.into_owned(),
    };
    let scene = match &pictures.view_3d {
        Some(View3d::Scene(scene)) => Some(scene),
        _ => None,
    };
    document(
        &title,
        scene.map(|scene| &*scene.script),
        html! {
            (facts::head(report, &title))
            (poses::meaning(report))
            (poses::shared(report))
            (next_steps_section(report, help))
            @if let Some(view) = &pictures.view_3d { (view_3d::section(view)) }
            (poses::worst(report, &pictures.worst))
            (poses::table(report))
            @if !pictures.sheet.is_empty() {
                section {
                    h2 { "All poses" }
                    (sheet(&pictures.sheet, report.poses.iter().filter(|pose| pose.error.is_none()).count()))
                }
            }
            (curves(report))
            @if !pictures.rest.is_empty() {
                section {
                    h2 { "At rest" }
                    div.rests { @for image in &pictures.rest { (figure(image)) } }
                }
            }
            (averages(report))
            (facts::choices(report))
            (facts::warnings(report))
            (facts::stages(report))
            (facts::provenance(report))
            @if let Some(scene) = scene { (view_3d::scripts(scene, report)) }
        },
    )
}

fn sheet(images: &[Image], poses: usize) -> Markup {
    html! {
        p.note {
            @if images.len() < poses { (images.len()) " of " (poses) " poses, spread over all of them. " }
            "Source and result are seen from the same side. What is seen from the back is dark red."
        }
        div.sheet tabindex="0" {
            @for image in images {
                // Its panels are squares beside each other.
                @let panels = image.size[0] / image.size[1].max(1);
                div style=(format!("--panels: {panels}")) { (figure(image)) }
            }
        }
    }
}
