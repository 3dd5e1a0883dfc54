//! The argument `--stage`: a kind of stage.

use std::ffi::OsStr;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use mimesh_core::plugin;

use crate::cli::new::{source::Source, template};

/// Parses a kind of stage. Reading the kinds waits until the argument or its help is needed.
#[derive(Clone)]
pub struct KindParser;

impl TypedValueParser for KindParser {
    type Value = String;

    fn parse_ref(
        &self,
        command: &clap::Command,
        argument: Option<&clap::Arg>,
        value: &OsStr,
    ) -> Result<String, clap::Error> {
        PossibleValuesParser::new(possible_values()).parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new(possible_values().into_iter()))
    }
}

/// The kinds with a template, and hidden the other registered kinds: for these the command explains what they lack.
///
/// Without mimesh's source no templates are known, and all registered kinds are shown.
fn possible_values() -> Vec<PossibleValue> {
    let with_template = template::kinds(Source::of_program());
    let registered = plugin::all().into_iter().map(|plugin| plugin.stage.to_owned());
    let mut all: Vec<String> = with_template.iter().cloned().chain(registered).collect();
    all.sort();
    all.dedup();
    let is_hidden = |kind: &String| !with_template.is_empty() && !with_template.contains(kind);
    all.into_iter().map(|kind| PossibleValue::new(kind.clone()).hide(is_hidden(&kind))).collect()
}
