//! Arguments with a fixed set of values, which the JSON Schema of their type lists.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use mimesh_pipeline::schema::described_choices;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;

/// Creates a parser of the values of `T`, with their descriptions as help.
pub fn choice<T>() -> impl TypedValueParser<Value = T>
where
    T: DeserializeOwned + JsonSchema + Clone + Send + Sync + 'static,
{
    let schema = schemars::schema_for!(T).to_value();
    let values = described_choices(&schema).into_iter().map(|(name, description)| {
        let help = description.trim_end_matches('.').to_owned();
        PossibleValue::new(name).help(help)
    });
    PossibleValuesParser::new(values).try_map(|name| serde_json::from_value::<T>(name.into()))
}
