//! Notations of marker files, known by the ending of the file.

use std::path::Path;

/// A notation of marker files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notation {
    /// `.cons`: vertices of both sides.
    Cons,
    /// `.yaml`: both sides with names, notes and positions.
    Yaml,
    /// `.pp`: the points of one mesh, as MeshLab picks them.
    PickedPoints,
    /// `.json`: the points of one mesh.
    Json,
    /// `.txt`: the points of one mesh, read as JSON or a table, and written for Wrap.
    Text,
    /// `.fcsv`: the points of one mesh, as 3D Slicer saved them.
    Fiducials,
    /// `.pts`: the points of one mesh.
    Points,
    /// `.landmarkAscii`: the points of one mesh or of both, as Avizo and Amira save them.
    Amira,
    /// `.csv`, `.tsv` and `.dat`: the points of one mesh.
    Table,
}

impl Notation {
    /// The notation of `file` by its ending; `None` if no notation has this ending.
    pub fn of(file: &Path) -> Option<Self> {
        match ending(file).as_str() {
            "cons" => Some(Self::Cons),
            "yaml" | "yml" => Some(Self::Yaml),
            "pp" => Some(Self::PickedPoints),
            "json" => Some(Self::Json),
            "txt" => Some(Self::Text),
            "fcsv" => Some(Self::Fiducials),
            "pts" => Some(Self::Points),
            "landmarkascii" | "landmarkbin" | "am" => Some(Self::Amira),
            "csv" | "tsv" | "dat" => Some(Self::Table),
            _ => None,
        }
    }

    /// Whether one file holds both sides of the markers.
    pub fn holds_both_sides(self) -> bool {
        matches!(self, Self::Cons | Self::Yaml)
    }

    /// Whether files are written in this notation, and not only read.
    pub fn is_written(self) -> bool {
        !matches!(self, Self::Fiducials | Self::Points | Self::Amira)
    }
}

/// Whether `file` has the ending of a file with the points of one mesh.
pub fn is_point_file(file: &Path) -> bool {
    Notation::of(file).is_some_and(|notation| !notation.holds_both_sides())
}

/// The ending of `file` in lower case; empty if there is none.
pub fn ending(file: &Path) -> String {
    file.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default()
}
