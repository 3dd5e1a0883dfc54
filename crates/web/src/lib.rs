//! What npm builds of `web/`, which is part of the program if it was built before it: the page of the studio, and the script with
//! which reports show meshes in 3D.

use std::borrow::Cow;

use rust_embed::Embed;

pub use rust_embed::EmbeddedFile;

/// The command that builds the files, in the folder of the sources.
pub const BUILD: &str = "npm ci --prefix web && npm run build --prefix web";

/// How a program without the files gets them.
pub const HOW_TO_BUILD: &str = "in the folder of the sources run `npm ci --prefix web && npm run build --prefix web`, then build the program again";

#[derive(Embed)]
#[folder = "../../web/dist"]
#[allow_missing = true]
struct Files;

/// Returns the file `name`, if it was built.
pub fn file(name: &str) -> Option<EmbeddedFile> {
    Files::get(name)
}

/// Returns the text of the file `name`, if it was built.
pub fn text(name: &str) -> Option<Cow<'static, str>> {
    match Files::get(name)?.data {
        Cow::Borrowed(bytes) => std::str::from_utf8(bytes).ok().map(Cow::Borrowed),
        Cow::Owned(bytes) => String::from_utf8(bytes).ok().map(Cow::Owned),
    }
}

/// Whether the page of the studio was built.
pub fn has_studio() -> bool {
    Files::get("index.html").is_some()
}

/// Returns the script with which reports show meshes in 3D, if it was built.
pub fn report_viewer() -> Option<Cow<'static, str>> {
    text("report/viewer.js")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_out_names_the_command() {
        assert!(HOW_TO_BUILD.contains(BUILD));
    }
}
