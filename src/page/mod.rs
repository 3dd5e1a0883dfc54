//! The page that shows a run: verdicts, pictures, curves, settings and provenance in one file of HTML that needs no other.
//!
//! Made from what `run.json` holds and from pictures; no script runs in it, so that it opens anywhere, prints, and can be
//! mailed. Colours follow the reader's light or dark preference.

mod chart;
mod compare;
mod facts;
mod poses;

use base64::{Engine, prelude::BASE64_STANDARD};
use maud::{DOCTYPE, Markup, PreEscaped, html};

pub use self::compare::{Shown, average, best, columns, compare};
use crate::pipeline::{Report, judge::Level};

/// A picture with what it shows.
#[derive(Clone, Debug, Default)]
pub struct Image {
    /// Which pose, or what else.
    pub name: String,
    /// What is to be seen, for those who cannot see it.
    pub alt: String,
    /// The file.
    pub png: Vec<u8>,
    /// Its size in pixels.
    pub size: [u32; 2],
}

/// The pictures of a run.
#[derive(Clone, Debug, Default)]
pub struct Pictures {
    /// The meshes at rest, with their markers.
    pub rest: Vec<Image>,
    /// Large ones of the worst poses.
    pub worst: Vec<Image>,
    /// Small ones of all poses, or of some spread over them.
    pub sheet: Vec<Image>,
}

/// The page of a run.
pub fn page(report: &Report, pictures: &Pictures) -> String {
    let name = report.pipeline.file_stem().unwrap_or_default().to_string_lossy();
    let title = match &report.run {
        Some(run) => format!("{name} · {}", run.name),
        None => name.into_owned(),
    };
    document(
        &title,
        html! {
            (facts::head(report, &title))
            (poses::worst(report, &pictures.worst))
            (poses::table(report))
            @if !pictures.sheet.is_empty() {
                section {
                    h2 { "All poses" }
                    (sheet(&pictures.sheet, report.poses.iter().filter(|pose| pose.error.is_none()).count()))
                }
            }
            (chart::curves(report))
            @if !pictures.rest.is_empty() {
                section {
                    h2 { "At rest" }
                    div.rests { @for image in &pictures.rest { (figure(image)) } }
                }
            }
            (facts::averages(report))
            (facts::warnings(report))
            (facts::stages(report))
            (facts::provenance(report))
        },
    )
}

fn document(title: &str, body: Markup) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="generator" content=(concat!("mimesh ", env!("CARGO_PKG_VERSION")));
                // Without one, browsers ask the server for an icon.
                link rel="icon" href="data:,";
                title { (title) }
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body { main { (body) } }
        }
    }
    .into_string()
}

fn sheet(images: &[Image], poses: usize) -> Markup {
    html! {
        p.note {
            @if images.len() < poses { (images.len()) " of " (poses) " poses, spread over all of them. " }
            "What is seen from behind is dark red."
        }
        div.sheet { @for image in images { (figure(image)) } }
    }
}

fn figure(image: &Image) -> Markup {
    html! {
        figure {
            (picture(image))
            figcaption { (image.name) }
        }
    }
}

fn picture(image: &Image) -> Markup {
    let data = format!("data:image/png;base64,{}", BASE64_STANDARD.encode(&image.png));
    html! { img src=(data) alt=(image.alt) width=(image.size[0]) height=(image.size[1]); }
}

/// The class of a level in the style sheet.
fn class(level: Level) -> &'static str {
    match level {
        Level::Good => "good",
        Level::Doubtful => "doubtful",
        Level::Bad => "bad",
        Level::Failed => "failed",
    }
}

fn badge(level: Level) -> Markup {
    html! { span class=(format!("badge {}", class(level))) { (level.word()) } }
}
