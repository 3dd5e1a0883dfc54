//! The part of a page in which meshes are turned: where its script works, with the data and the script.

use maud::{Markup, PreEscaped, html};

use super::{
    elements::class,
    scene::{PoseWords, Scene, View3d},
};
use crate::{report::Report, text::count};

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
                        (rounded_up(100.0 * scene.error())) "\u{a0}% of the diagonal at rest."
                    }
                    // The script removes it.
                    p.note #view-3d-without { "The view needs scripts. The pictures below show the same poses." }
                }
            }
        }
    }
}

/// Returns a bound in one digit that is no smaller.
fn rounded_up(value: f64) -> String {
    if value <= 0.0 {
        return "0".into();
    }
    let magnitude = value.log10().floor();
    let digit = 10.0_f64.powf(magnitude);
    // A quotient that rounding brought above a whole number is that number.
    let bound = (value / digit - 1e-9).ceil() * digit;
    format!("{bound:.*}", (-magnitude).max(0.0) as usize)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_rounded_up() {
        for (value, bound) in [(0.000_859, "0.0009"), (0.002, "0.002"), (12.3, "20"), (0.0, "0")] {
            assert_eq!(rounded_up(value), bound);
        }
    }
}
