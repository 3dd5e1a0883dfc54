use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the poses of a mesh are to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum PosesAre {
    /// Shapes that stand alone, as smile and frown.
    Shapes,
    /// Frames of a motion, one after another.
    Frames,
}

impl PosesAre {
    /// What poses of these names seem to be; see [`poses_are_frames`].
    pub fn of_names<'a>(names: impl IntoIterator<Item = &'a str>) -> Self {
        if poses_are_frames(names) { Self::Frames } else { Self::Shapes }
    }
}

/// Names that programs give to shapes without one, before their numbers: this program's readers, and Blender.
const UNNAMED_SHAPES: [&str; 2] = ["target-", "Key "];

/// Whether poses of these names are frames of a motion: two or more that end in digits and share all before these.
///
/// `01, 02` and `horse-03, horse-04` are frames; `smile, frown` are shapes, as are numbered shapes without names of their own.
pub fn poses_are_frames<'a>(names: impl IntoIterator<Item = &'a str>) -> bool {
    let stem = |name: &'a str| {
        let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
        (stem.len() < name.len()).then_some(stem)
    };
    let mut names = names.into_iter();
    let Some(first) = names.next().and_then(stem) else { return false };
    let mut others = names.peekable();
    others.peek().is_some() && !UNNAMED_SHAPES.contains(&first) && others.all(|name| stem(name) == Some(first))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frames(names: &[&str]) -> bool {
        poses_are_frames(names.iter().copied())
    }

    #[test]
    fn numbered_names_are_frames() {
        assert!(frames(&["01", "02", "10"]));
        assert!(frames(&["horse-03", "horse-10"]));
        assert!(frames(&["Run 0", "Run 1"]));
    }

    #[test]
    fn other_names_are_shapes() {
        assert!(!frames(&[]));
        assert!(!frames(&["01"]));
        assert!(!frames(&["smile", "frown"]));
        assert!(!frames(&["horse-03", "camel-03"]));
        assert!(!frames(&["horse-03", "horse"]));
        assert!(!frames(&["1a", "2a"]));
    }

    #[test]
    fn numbers_in_place_of_names_are_no_frames() {
        assert!(!frames(&["target-0", "target-1"]));
        assert!(!frames(&["Key 1", "Key 2"]));
    }
}
