//! The options that split a run: which of its poses, and which of several runs.

use std::path::Path;

use mimesh_document::{Diagnostic, Kind, diagnostic::Result};
use mimesh_pipeline::{
    Plan, Prepared,
    cache::Cache,
    shard::{Frames, Part, PoseSelection, Shard, check_room},
};

/// Which poses are computed.
#[derive(Clone, Debug, clap::Args)]
pub struct ShardOptions {
    /// Compute these poses only, counted from 0, e.g. 7, 0-24, 0-99:10 or 1-3,5,7-20:2; write the files of one pose each, and leave
    /// the others to `mimesh merge`
    #[arg(long, value_name = "FRAMES", conflicts_with = "shard", allow_hyphen_values = true)]
    frames: Option<Frames>,
    /// Compute the I-th of N equal parts of the poses only, I from 0, e.g. 0/4 to 3/4; else as --frames
    #[arg(long, value_name = "I/N", allow_hyphen_values = true)]
    shard: Option<Shard>,
    /// Frames of one motion: begin each part N frames earlier, from rest; results are near those of a whole run
    #[arg(long, value_name = "N")]
    warm: Option<usize>,
}

/// Which of several runs of a file are meant.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct RunNames {
    /// Of the runs that targets and a matrix make, only the one of this name; may be given several times
    #[arg(long = "run", value_name = "NAME")]
    pub names: Vec<String>,
}

impl RunNames {
    /// The options as they were given, for another command.
    pub fn arguments(&self) -> Vec<String> {
        self.names.iter().flat_map(|name| ["--run".to_owned(), name.clone()]).collect()
    }
}

impl ShardOptions {
    /// The warm frames as they were given, for another command.
    pub fn warm_arguments(&self) -> Vec<String> {
        self.warm.map_or_else(Vec::new, |warm| vec!["--warm".into(), warm.to_string()])
    }

    /// The part of the poses that is asked for; `None` for all of them.
    pub fn selection(&self) -> Option<PoseSelection> {
        let frames = self.frames.clone().map(PoseSelection::Frames);
        frames.or_else(|| self.shard.map(PoseSelection::Shard))
    }

    /// The part of each of `runs` of the pipeline in `file`; `None` for whole runs.
    ///
    /// # Errors
    ///
    /// A diagnostic if there is no such part, or its results would go nowhere.
    pub fn parts(&self, file: &Path, runs: &[Prepared], cache: Option<&Cache>) -> Result<Option<Vec<Part>>> {
        let Some(selection) = self.selection() else {
            return match self.warm {
                Some(_) => Err(Diagnostic::new(Kind::Usage, "--warm without a part: a whole run needs no warm frames")
                    .hint("leave it out, or give a part by `--frames A-B` or `--shard I/N`")
                    .into()),
                None => Ok(None),
            };
        };
        let of_all: Vec<_> = runs.iter().flat_map(|run| run.outputs.files_of_all()).collect();
        match (cache, of_all.first()) {
            (None, Some(of_all)) => {
                let message = format!(
                    "{selection} with --no-cache: `mimesh merge` takes poses from the cache, and {} could never be written",
                    of_all.display()
                );
                let hint = "leave --no-cache out, or name one folder for all parts by `--cache DIR`";
                return Err(Diagnostic::new(Kind::Usage, message).hint(hint).into());
            }
            (Some(cache), _) => check_room(runs, cache)?,
            (None, None) => {}
        }
        let part = |run: &Prepared| {
            let part = Part::new(run, &selection, self.warm);
            part.map_err(|diagnostic| match run.variant.name.as_str() {
                "" => diagnostic.doing(file.display()),
                name => diagnostic.doing(format!("{}: {name}", file.display())),
            })
        };
        Ok(Some(runs.iter().map(part).collect::<std::result::Result<_, _>>()?))
    }
}

/// The plan of the `i`-th run, whole or in part.
pub fn plan(run: &Prepared, i: usize, parts: Option<&[Part]>, cache: Option<&Cache>) -> Plan {
    match parts.and_then(|parts| parts.get(i)) {
        Some(part) => Plan::of_part(run, cache, part.clone()),
        None => Plan::new(run, cache),
    }
}
