//! The part of a page in which meshes are turned: where its script works, with the data and the script.

use maud::{Markup, PreEscaped, html};

use super::{
    elements::class,
    scene::{PoseWords, Scene, View3d},
};
use crate::{
    report::Report,
    text::{count, number},
};

/// Returns the section in which the script works, with what those see who have no scripts.
pub fn section(view: &View3d) -> Markup {
    html! {
        section #view-3d {
            h2 { "The worst poses in 3D" }
            @match view {
                View3d::None(reason) => { p.note { (reason) } }
                View3d::Scene(scene) => {
                    p.note {
                        (count(scene.poses.len(), "pose", "poses")) ", the worst first. Positions are rounded, by at most "
                        (number(100.0 * scene.error())) "\u{a0}% of the diagonal at rest."
                    }
                    noscript { p.note { "This needs scripts. The pictures below show the same poses." } }
                }
            }
        }
    }
}

/// Returns the data and the script of the view, for the end of the page.
pub fn scripts(scene: &Scene, report: &Report) -> Markup {
    let words = |name: &str| {
        let verdict = report.poses.iter().find(|pose| pose.name == name).and_then(|pose| pose.verdict.as_ref());
        verdict.map_or_else(PoseWords::default, |verdict| PoseWords {
            level: class(verdict.level),
            verdict: verdict.level.word(),
            reasons: verdict.reasons.iter().map(|reason| reason.words().replace('`', "")).collect(),
        })
    };
    html! {
        script #view-3d-data type="application/json" { (PreEscaped(scene.json(words))) }
        script { (PreEscaped(&scene.script)) }
    }
}
