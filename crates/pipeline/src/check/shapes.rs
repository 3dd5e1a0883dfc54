//! The slot `shapes`: which poses are taken, under which names, and what becomes of them.

use std::{
    collections::{BTreeMap, HashMap, HashSet},
    fs,
    path::Path,
    sync::Arc,
};

use mimesh_document::{At, Step, path, suggest::did_you_mean};

use super::findings::{Findings, Scope};
use crate::{
    input::{PoseInput, RestMesh},
    shapes::{Channel, Mask, Region, ShapeEdit, ShapeSettings, side},
    text::some_of,
};

/// The poses that `settings` take, under the names of their results, each with what becomes of it.
pub(super) fn shapes(
    scope: Scope<'_>,
    found: &mut Findings,
    settings: Option<&ShapeSettings>,
    poses: Vec<PoseInput>,
    target: Option<&RestMesh>,
    has_map: bool,
) -> (Vec<PoseInput>, Vec<ShapeEdit>) {
    let Some(settings) = settings else {
        let edits = vec![ShapeEdit::default(); poses.len()];
        return (poses, edits);
    };
    let names: Vec<String> = poses.iter().map(|pose| pose.name.clone()).collect();
    let patterns = Patterns { scope, names: &names };
    let taken = taken(&patterns, found, settings, &poses);
    let mut shapes = mirrored(&patterns, found, settings, taken);
    let region = regions(&patterns, found, settings, &poses, target, has_map);
    let strengths = patterns.by_shape(found, "strengths", &settings.strengths);
    for shape in &mut shapes {
        let of_shape = strengths.get(&shape.shape).map(|strength| **strength);
        shape.edit.strength = of_shape.or(settings.strength).unwrap_or(1.0);
        shape.edit.region = region.get(&shape.shape).cloned();
    }
    rename(&patterns, found, settings, &mut shapes);
    // That the results of two of one name collide follows, and needs no diagnostic.
    let mut seen = HashSet::new();
    shapes.retain(|shape| seen.insert(shape.pose.name.clone()));
    shapes.into_iter().map(|shape| (shape.pose, shape.edit)).unzip()
}

/// A pose on its way to a result.
struct Shape {
    /// Its name in the source, or that of the other side's shape that it is made from, with left and right exchanged.
    shape: String,
    pose: PoseInput,
    edit: ShapeEdit,
}

/// Patterns of names of shapes, matched against the names of the source.
struct Patterns<'a> {
    scope: Scope<'a>,
    names: &'a [String],
}

impl Patterns<'_> {
    /// Whether each name fits `pattern`, written at `at`; a pattern that fits none is a diagnostic.
    fn fits(&self, found: &mut Findings, at: &[Step], place: At, pattern: &str) -> Vec<bool> {
        let compiled = match glob::Pattern::new(pattern) {
            Ok(compiled) => compiled,
            Err(error) => {
                let message = format!("`{pattern}` is no pattern: {}", error.msg);
                found.wrong(self.scope, at, place, message, "e.g. `mouth*`");
                return vec![false; self.names.len()];
            }
        };
        let fits: Vec<bool> = self.names.iter().map(|name| name == pattern || compiled.matches(name)).collect();
        if !fits.contains(&true) && !self.names.is_empty() {
            let known = || format!("shapes: {}", some_of(self.names));
            let hint = did_you_mean(pattern, self.names).unwrap_or_else(known);
            found.wrong(self.scope, at, place, format!("no shape of the source is called `{pattern}`"), hint);
        }
        fits
    }

    /// The values of a mapping at `shapes.KEY` by the names that its keys fit, the first of several.
    fn by_shape<'v, T>(
        &self,
        found: &mut Findings,
        key: &str,
        values: &'v BTreeMap<String, T>,
    ) -> HashMap<String, &'v T> {
        let mut by_shape = HashMap::new();
        // Exact names go before patterns.
        let (exact, patterns): (Vec<_>, Vec<_>) = values.iter().partition(|(name, _)| self.names.contains(name));
        for (pattern, value) in exact.into_iter().chain(patterns) {
            let fits = self.fits(found, &path(["shapes", key, pattern]), At::Key, pattern);
            for (name, _) in self.names.iter().zip(fits).filter(|(_, fits)| *fits) {
                by_shape.entry(name.clone()).or_insert(value);
            }
        }
        by_shape
    }
}

/// The shapes that `only` and `except` leave.
fn taken(patterns: &Patterns<'_>, found: &mut Findings, settings: &ShapeSettings, poses: &[PoseInput]) -> Vec<Shape> {
    let before = found.diagnostics.len();
    let mut fitting = |key: &str, items: &[String]| {
        let mut any = vec![false; poses.len()];
        for item in items {
            let fits = patterns.fits(found, &path(["shapes", key]), At::Value, item);
            any.iter_mut().zip(fits).for_each(|(any, fits)| *any |= fits);
        }
        any
    };
    let only = settings.only.as_ref().map(|only| fitting("only", &only.items));
    let except = settings.except.as_ref().map(|except| fitting("except", &except.items));
    let is_taken = |i: usize| only.as_ref().is_none_or(|only| only[i]) && except.as_ref().is_none_or(|e| !e[i]);
    let shape = |(_, pose): (usize, &PoseInput)| Shape {
        shape: pose.name.clone(),
        pose: pose.clone(),
        edit: ShapeEdit::default(),
    };
    let taken: Vec<Shape> = poses.iter().enumerate().filter(|(i, _)| is_taken(*i)).map(shape).collect();
    // Where a name is wrong, that none is left follows.
    if taken.is_empty() && !poses.is_empty() && found.diagnostics.len() == before {
        let hint = format!("shapes: {}", some_of(patterns.names));
        found.wrong(patterns.scope, &path(["shapes"]), At::Value, "`only` and `except` leave no shape", hint);
    }
    taken
}

/// The shapes with those of one side made from those of the other.
fn mirrored(
    patterns: &Patterns<'_>,
    found: &mut Findings,
    settings: &ShapeSettings,
    mut shapes: Vec<Shape>,
) -> Vec<Shape> {
    let Some(mirror) = settings.mirror else { return shapes };
    let mut made = 0;
    let mut result: Vec<Shape> = Vec::new();
    let from: HashMap<String, PoseInput> = shapes
        .iter()
        .filter_map(|shape| Some((side(&shape.shape).filter(|(side, _)| *side == mirror.from)?.1, shape.pose.clone())))
        .collect();
    // Shapes that are made anew keep their places; the others come after those that they are made from.
    let known: Vec<String> = shapes.iter().map(|shape| shape.shape.clone()).collect();
    let mirror_of = |name: &str, pose: &PoseInput| Shape {
        shape: name.to_owned(),
        pose: PoseInput { name: name.to_owned(), ..pose.clone() },
        edit: ShapeEdit { mirrored: Some(mirror.axis), ..ShapeEdit::default() },
    };
    for shape in shapes.drain(..) {
        if let Some(pose) = from.get(&shape.shape) {
            made += 1;
            result.push(mirror_of(&shape.shape, pose));
            continue;
        }
        let other = side(&shape.shape).filter(|(side, _)| *side == mirror.from).map(|(_, other)| other);
        let other = other.filter(|other| !known.contains(other)).map(|other| mirror_of(&other, &shape.pose));
        made += usize::from(other.is_some());
        result.push(shape);
        result.extend(other);
    }
    if made == 0 {
        let hint = "names of sides end or begin with left and right, as `eyeBlinkLeft`, `eyeBlink_L` or `L_Blink`";
        found.wrong(
            patterns.scope,
            &path(["shapes", "mirror"]),
            At::Value,
            "no shape is of the side to mirror from",
            hint,
        );
    }
    result
}

/// The regions of masks by the names of their shapes.
fn regions(
    patterns: &Patterns<'_>,
    found: &mut Findings,
    settings: &ShapeSettings,
    poses: &[PoseInput],
    target: Option<&RestMesh>,
    has_map: bool,
) -> HashMap<String, Arc<Region>> {
    let mut by_mask: HashMap<&str, Arc<Region>> = HashMap::new();
    for (pattern, mask) in &settings.masks {
        let at = path(["shapes", "masks", pattern]);
        let region = target.and_then(|target| match region(patterns, mask, poses, target, has_map) {
            Ok(region) => Some(region),
            Err((message, hint)) => {
                found.wrong(patterns.scope, &at, At::Value, message, hint);
                None
            }
        });
        by_mask.extend(region.map(|region| (pattern.as_str(), Arc::new(region))));
    }
    let keys: BTreeMap<String, &str> =
        settings.masks.keys().map(|pattern| (pattern.clone(), pattern.as_str())).collect();
    let by_shape = patterns.by_shape(found, "masks", &keys);
    let mut regions: HashMap<String, Arc<Region>> =
        by_shape.iter().filter_map(|(shape, pattern)| Some((shape.clone(), by_mask.get(**pattern)?.clone()))).collect();
    // Shapes that mirroring adds have names that the source does not have.
    for (pattern, region) in by_mask {
        regions.entry(pattern.to_owned()).or_insert(region);
    }
    regions
}

/// What is wrong, and a way out.
type Problem = (String, String);

/// The region that `mask` says.
fn region(
    patterns: &Patterns<'_>,
    mask: &Mask,
    poses: &[PoseInput],
    target: &RestMesh,
    has_map: bool,
) -> Result<Region, Problem> {
    let surface = &target.surface;
    match (&mask.vertices, &mask.parts, mask.color, &mask.shape) {
        (Some(vertices), None, None, None) => {
            let count = surface.vertex_of.len();
            let mut inside = vec![false; surface.vertex_count()];
            for &v in vertices {
                let of_surface = surface.vertex_of.get(v as usize).ok_or_else(|| {
                    (format!("the target has no vertex {v}"), format!("its vertices are 0 to {}", count - 1))
                })?;
                of_surface.iter().for_each(|&v| inside[v as usize] = true);
            }
            Ok(Region::Inside(inside))
        }
        (None, Some(parts), None, None) => {
            let mesh = &target.sequence.rest;
            let names = |part: &mimesh_core::mesh::Part| -> Vec<String> {
                part.object.iter().chain(&part.groups).chain(&part.material).cloned().collect()
            };
            let all: Vec<String> = {
                let mut all: Vec<String> = mesh.parts.iter().flat_map(names).collect();
                all.sort();
                all.dedup();
                all
            };
            if let Some(unknown) = parts.items.iter().find(|name| !all.contains(name)) {
                let hint = did_you_mean(unknown, &all).unwrap_or_else(|| format!("parts: {}", some_of(&all)));
                return Err((format!("the target has no part called `{unknown}`"), hint));
            }
            let mut inside = vec![false; surface.vertex_count()];
            for part in mesh.parts.iter().filter(|part| names(part).iter().any(|name| parts.items.contains(name))) {
                let corners = part.polygons.clone().flat_map(|polygon| mesh.polygons.get(polygon));
                corners.filter_map(|&v| surface.vertex_of[v as usize]).for_each(|v| inside[v as usize] = true);
            }
            Ok(Region::Inside(inside))
        }
        (None, None, Some(channel), None) => {
            let Some(colors) = &target.sequence.rest.vertex_colors else {
                let hint = "paint its vertices in a format that keeps colours, or use `parts` or `vertices`";
                return Err(("the vertices of the target have no colours".into(), hint.into()));
            };
            let share = |&v: &u32| colors[v as usize][channel_index(channel)].clamp(0.0, 1.0);
            Ok(Region::Shares(surface.representative.iter().map(share).collect()))
        }
        (None, None, None, Some(shape)) => {
            let Some(pose) = poses.iter().find(|pose| pose.name == *shape) else {
                let known = || format!("shapes: {}", some_of(patterns.names));
                let hint = did_you_mean(shape, patterns.names).unwrap_or_else(known);
                return Err((format!("no shape of the source is called `{shape}`"), hint));
            };
            if !has_map {
                let hint = "name a `correspondence`, or use `parts` or `vertices`";
                return Err(("nothing tells which of the target follows a shape of the source".into(), hint.into()));
            }
            Ok(Region::MovedBy(pose.clone()))
        }
        _ => Err((
            "a mask has one of the keys `vertices`, `parts`, `color` and `shape`".into(),
            "e.g. `{ parts: [Face] }`".into(),
        )),
    }
}

fn channel_index(channel: Channel) -> usize {
    match channel {
        Channel::Red => 0,
        Channel::Green => 1,
        Channel::Blue => 2,
        Channel::Alpha => 3,
    }
}

/// Gives results their names.
fn rename(patterns: &Patterns<'_>, found: &mut Findings, settings: &ShapeSettings, shapes: &mut [Shape]) {
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
    let text = fs::read_to_string(file).map_err(|error| (format!("{}: {error}", file.display()), hint()))?;
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
