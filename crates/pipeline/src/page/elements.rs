//! What all pages are made of: the document around them, pictures and badges.

use base64::{Engine, prelude::BASE64_STANDARD};
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::{chart, content_policy::content_policy, words::name};
use crate::metrics::Level;

/// A picture with its description.
#[derive(Clone, Debug, Default)]
pub struct Image {
    /// The name of the pose, or another caption.
    pub name: String,
    /// The text for those who cannot see the picture.
    pub alt: String,
    /// The PNG file.
    pub png: Vec<u8>,
    /// Width and height in pixels.
    pub size: [u32; 2],
}

/// Pictures of one pose that stand side by side, or below each other where there is little room.
#[derive(Clone, Debug, Default)]
pub struct PanelImages {
    /// The name of the pose.
    pub name: String,
    /// Source, result, and errors as far as there are any.
    pub panels: Vec<Image>,
}

/// Returns a page of HTML with its style sheet, in which at most one script runs.
pub fn document(title: &str, script: Option<&str>, body: Markup) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(content_policy(script));
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="generator" content=(concat!("mimesh ", env!("CARGO_PKG_VERSION")));
                // Without one, browsers ask the server for an icon.
                link rel="icon" href="data:,";
                title { (title) }
                style { (PreEscaped(include_str!("style.css"))) (PreEscaped(chart::STYLE)) }
            }
            body { main { (body) } }
        }
    }
    .into_string()
}

/// Returns a picture with its name below.
pub fn figure(image: &Image) -> Markup {
    html! {
        figure {
            (picture(image))
            figcaption { (name(&image.name)) }
        }
    }
}

/// Returns a picture.
pub fn picture(image: &Image) -> Markup {
    let data = format!("data:image/png;base64,{}", BASE64_STANDARD.encode(&image.png));
    html! { img src=(data) alt=(image.alt) width=(image.size[0]) height=(image.size[1]); }
}

/// Returns the class of a level in the style sheet.
pub fn class(level: Level) -> &'static str {
    match level {
        Level::Good => "good",
        Level::Doubtful => "doubtful",
        Level::Bad => "bad",
        Level::Failed => "failed",
    }
}

/// Returns the word for a level in its colour.
pub fn badge(level: Level) -> Markup {
    html! { span class=(format!("badge {}", class(level))) { (level.word()) } }
}
