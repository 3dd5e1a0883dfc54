//! What a pipeline says of its shapes.

use std::{collections::BTreeMap, path::PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Convention, Side};
use crate::{axis::Axis, one_or_many::OneOrMany};

/// The shapes that are taken, their names, strengths and regions.
///
/// All names of shapes but those of results are those of the source. `*` stands for any part of a name and `?` for a character.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct ShapeSettings {
    /// The shapes that are taken, e.g. `[jaw*, mouth*]`; left out, all.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("examples" = ["mouth*", ["jawOpen", "mouth*"]]))]
    pub only: Option<OneOrMany>,
    /// The shapes that are left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("examples" = ["eyeLook*"]))]
    pub except: Option<OneOrMany>,
    /// Results are called as this convention calls the shapes; those that it does not have keep their names, which is told.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub names: Option<Convention>,
    /// Names of results by those of the shapes, before `names`.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(extend("examples" = [{ "jawOpen": "MouthOpen" }]))]
    pub rename: BTreeMap<String, String>,
    /// A CSV file of two columns, the name of a shape and that of its result, as `rename`.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("examples" = ["names.csv"]))]
    pub rename_file: Option<PathBuf>,
    /// How much of each shape's motion results have; 1 is all.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = -10.0, max = 10.0))]
    pub strength: Option<f64>,
    /// The strengths of single shapes, in place of `strength`.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(extend("examples" = [{ "jawOpen": 0.8, "brow*": 1.2 }]))]
    pub strengths: BTreeMap<String, f64>,
    /// Shapes of one side are made from those of the other, by the symmetry of the target.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mirror: Option<Mirror>,
    /// The parts of the target that shapes may move, by their names; all else rests. The first name that fits counts.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    #[schemars(extend("examples" = [{ "jaw*": { "parts": ["Face", "Teeth"] } }]))]
    pub masks: BTreeMap<String, Mask>,
}

/// Shapes of one side are made from those of the other: their names end or begin with left and right in any usual way.
///
/// Those that the source has of the other side are made anew, and those that it lacks are added.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Mirror {
    /// The axis of the target from one side to the other; its plane of symmetry is found.
    pub axis: Axis,
    /// The side whose shapes are kept.
    pub from: Side,
}

/// A part of the target: one of its keys says which.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Mask {
    /// Vertices of the target's file, from 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vertices: Option<Vec<u32>>,
    /// Objects, groups or materials of the target.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parts: Option<OneOrMany>,
    /// A channel of the colours of the target's vertices: the share of the motion that each takes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub color: Option<Channel>,
    /// A shape of the source: what follows a vertex that it moves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<String>,
    /// A mask as the studio paints it, a JSON file: the share of the motion that each vertex of the target's file takes.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(extend("examples" = ["jaw.target.mask.json"]))]
    pub file: Option<PathBuf>,
}

/// A channel of colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Channel {
    /// Red.
    Red,
    /// Green.
    Green,
    /// Blue.
    Blue,
    /// Opacity.
    Alpha,
}
