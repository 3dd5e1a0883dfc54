//! The names of the results of shapes.

use std::{collections::HashMap, path::Path};

use mimesh_document::{At, files::read_text, path, suggest::did_you_mean};

use super::{
    findings::Findings,
    shape_patterns::{Patterns, Shape},
};
use crate::{shapes::ShapeSettings, text::some_of};

/// What is wrong, and a way out.
type Problem = (String, String);

/// Gives results their names.
pub(super) fn rename(patterns: &Patterns<'_>, found: &mut Findings, settings: &ShapeSettings, shapes: &mut [Shape]) {
    let mut names: HashMap<String, String> = HashMap::new();
    if let Some(file) = &settings.rename_file {
        let at = path(["shapes", "rename_file"]);
        let file = patterns.scope.path(&at, file);
        if found.input(patterns.scope, "names of shapes", &file, &at) {
            match table(&file) {
                Ok(table) => names.extend(table),
                Err((message, hint)) => found.wrong(patterns.scope, &at, At::Value, message, hint),
            }
        }
    }
    for (shape, name) in &settings.rename {
        if !shapes.iter().any(|known| known.shape == *shape) {
            let hint =
                did_you_mean(shape, patterns.names).unwrap_or_else(|| format!("shapes: {}", some_of(patterns.names)));
            let message = format!("no shape of the source is called `{shape}`");
            found.wrong(patterns.scope, &path(["shapes", "rename", shape]), At::Key, message, hint);
        }
        names.insert(shape.clone(), name.clone());
    }
    let mut unknown = Vec::new();
    for shape in shapes.iter_mut() {
        let own = names.get(&shape.shape).cloned();
        let name = own.or_else(|| {
            let convention = settings.names?;
            let name = convention.name_of(&shape.shape);
            if name.is_none() {
                unknown.push(shape.shape.clone());
            }
            name
        });
        if let Some(name) = name {
            shape.pose.name = name;
        }
    }
    if !unknown.is_empty() {
        found.warnings.push(format!("shapes keep the names that `names` has none for: {}", some_of(&unknown)));
    }
    let mut by_name: HashMap<&str, &str> = HashMap::new();
    for shape in shapes.iter() {
        if let Some(other) = by_name.insert(&shape.pose.name, &shape.shape) {
            let message = format!("two shapes become `{}`: `{other}` and `{}`", shape.pose.name, shape.shape);
            let hint = "give one another name by `rename`, or leave it out by `except`";
            found.wrong(patterns.scope, &path(["shapes"]), At::Value, message, hint);
            return;
        }
    }
}

/// The two columns of a CSV file.
fn table(file: &Path) -> Result<Vec<(String, String)>, Problem> {
    let hint = || "each line has the name of a shape and that of its result, e.g. `jawOpen,MouthOpen`".to_owned();
    let text = read_text(file)
        .map_err(|problem| (format!("{}: {}", file.display(), problem.message), problem.hint.unwrap_or_else(hint)))?;
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(text.trim_start_matches('\u{feff}').as_bytes());
    let mut names = Vec::new();
    for (line, record) in reader.records().enumerate() {
        let record = record.map_err(|error| (format!("{}: {error}", file.display()), hint()))?;
        match (record.len(), record.get(0), record.get(1)) {
            (2, Some(shape), Some(name)) if !shape.is_empty() && !name.is_empty() => {
                names.push((shape.into(), name.into()))
            }
            (count, ..) => {
                let message =
                    format!("{}: record {}: expected two names, found {count} columns", file.display(), line + 1);
                return Err((message, hint()));
            }
        }
    }
    Ok(names)
}
