//! Landmarks by a program of the user's, e.g. a learned matcher.
//!
//! - `files`: the meshes and clicks as the program reads them;
//! - `process`: the program, its limits and its output;
//! - `answer`: the pairs in its output.

mod answer;
mod files;
mod process;

use std::time::Duration;

use mimesh_core::{
    Error, Figures, Result,
    mesh::check_finite,
    plugin::check_ranges,
    register,
    stage::{Landmarks, Proposal, ProposedPair, TransferPair},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use self::{answer::Answer, files::Files};

register!(Landmarks: External);

/// The pairs that a program answers, which is run with the files of both meshes; it needs `--allow-commands`.
///
/// The program gets two OBJ files in a private temporary folder and prints JSON: `{ "pairs": [ { "source": 12, "target": { "triangle": 3,
/// "barycentric": [0.2, 0.3, 0.5] }, "confidence": 0.9, "name": "nose" } ] }`. A point is a vertex (from 0), a place on a triangle, or
/// `{ "position": [x, y, z] }`, which stands for the nearest point. Pairs on points that earlier ones have are left out.
#[derive(Clone, Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct External {
    /// The program and its arguments; no shell reads them. `{source}`, `{target}` and `{clicks}` stand for files; where no argument has
    /// one of these, source and target follow. Paths are relative to the pipeline's folder.
    #[schemars(extend("x-command" = true))]
    pub command: Vec<String>,
    /// After so many seconds the program is ended, and the run fails.
    #[schemars(range(min = 0.1, max = 86400.0))]
    pub time_limit: f64,
}

impl Default for External {
    fn default() -> Self {
        Self { command: Vec::new(), time_limit: 600.0 }
    }
}

#[typetag::serde(name = "external")]
impl Landmarks for External {
    fn propose(&self, pair: TransferPair<'_>) -> Result<Proposal> {
        check_ranges(self)?;
        check_finite(&pair.source.positions)?;
        check_finite(&pair.target.positions)?;
        pair.check_markers()?;
        let Some((program, arguments)) = self.command.split_first() else {
            return Err(Error::Setting {
                setting: "command".into(),
                expected: "a program and its arguments, e.g. [python3, matcher.py]".into(),
                found: "none".into(),
            });
        };
        let files = Files::write(pair)?;
        let arguments = files.arguments(arguments);
        let output = process::run(program, &arguments, Duration::from_secs_f64(self.time_limit))?;
        let answer = Answer::parse(&output).map_err(|message| process::failed(program, &message))?;
        let (found, left_out) = answer.pairs(pair).map_err(|message| process::failed(program, &message))?;
        let mut figures = Figures::default();
        figures.set("answered", found.len());
        if left_out > 0 {
            figures.set("left_out", left_out);
            figures.warn(format!("{left_out} pairs of {program} share a point with an earlier one and are left out"));
        }
        let pairs = pair.markers.iter().map(ProposedPair::clicked).chain(found).collect();
        Ok(Proposal { pairs, figures, ..Proposal::default() })
    }

    fn command(&self) -> Option<&[String]> {
        Some(&self.command)
    }
}
