//! The names of morph targets, old and new.

use std::collections::HashSet;

use serde_json::{Value, json};

use super::{
    layout::{mesh_name, target_count},
    stored::{list, number},
};

/// The names of the morph targets that mesh `index` of a file has, as the reader calls them.
///
/// By convention they stand in the extras of the mesh; some exporters have them at a primitive or at the accessors. Others
/// get numbers, after the name of their mesh if several meshes have such: targets of one name are taken for one pose.
pub fn existing(json: &Value, index: usize) -> Vec<String> {
    let given = given(json, index);
    let has_unnamed = |mesh: &usize| self::given(json, *mesh).contains(&None);
    let is_complete = !given.contains(&None);
    let alone = is_complete || (0..list(json, "meshes").len()).filter(has_unnamed).nth(1).is_none();
    let numbered = |target: usize| {
        if alone { format!("target-{target}") } else { format!("{}-target-{target}", shown_name(json, index)) }
    };
    given.into_iter().enumerate().map(|(target, name)| name.unwrap_or_else(|| numbered(target))).collect()
}

/// The name of the first node that shows a mesh, else that of the mesh.
fn shown_name(json: &Value, mesh: usize) -> String {
    let node = list(json, "nodes").iter().find(|node| number(node, "mesh") == Some(mesh));
    let name = node.and_then(|node| node.get("name")?.as_str()).filter(|name| !name.is_empty());
    name.map_or_else(|| mesh_name(json, mesh), str::to_owned)
}

/// The names that the file gives.
fn given(json: &Value, index: usize) -> Vec<Option<String>> {
    let mesh = &list(json, "meshes")[index];
    let primitives = list(mesh, "primitives");
    let listed = |holder: &Value, target: usize| {
        let name = holder.get("extras")?.get("targetNames")?.get(target)?.as_str()?;
        (!name.is_empty()).then(|| name.to_owned())
    };
    let at_accessor = |target: usize| {
        primitives.iter().find_map(|primitive| {
            let accessor = number(list(primitive, "targets").get(target)?, "POSITION")?;
            let name = list(json, "accessors").get(accessor)?.get("name")?.as_str()?;
            (!name.is_empty()).then(|| name.to_owned())
        })
    };
    let name = |target| {
        let at_primitive = || primitives.iter().find_map(|primitive| listed(primitive, target));
        listed(mesh, target).or_else(at_primitive).or_else(|| at_accessor(target))
    };
    (0..target_count(mesh)).map(name).collect()
}

/// A name for `wanted` that is not among `taken`: itself, or with the first free number from 2.
pub fn unique(wanted: &str, taken: impl Fn(&str) -> bool) -> String {
    let numbered = (2..).map(|number| format!("{wanted}-{number}"));
    std::iter::once(wanted.to_owned()).chain(numbered).find(|name| !taken(name)).expect("there are infinitely many")
}

/// The names of new morph targets, told apart from those of all meshes that get them.
#[derive(Debug, Default)]
pub struct NewNames {
    taken: HashSet<String>,
    /// The names as they were given and as they are written, where these differ.
    pub renamed: Vec<(String, String)>,
}

impl NewNames {
    /// Names beside those in `taken`.
    pub fn new(taken: impl IntoIterator<Item = String>) -> Self {
        Self { taken: taken.into_iter().collect(), renamed: Vec::new() }
    }

    /// The name under which the target `wanted` is written.
    pub fn add(&mut self, wanted: &str) -> String {
        let name = unique(wanted, |name| self.taken.contains(name));
        if name != wanted {
            self.renamed.push((wanted.to_owned(), name.clone()));
        }
        self.taken.insert(name.clone());
        name
    }

    /// A sentence about the names that were changed.
    pub fn warning(&self) -> Option<String> {
        let list = self.renamed.iter().map(|(from, to)| format!("`{from}` is written as `{to}`"));
        let list: Vec<_> = list.collect();
        (!list.is_empty()).then(|| format!("morph targets of the names exist already: {}", list.join(", ")))
    }
}

/// Puts `names` in the extras of `mesh`, and behind the names at its primitives where these have some.
pub fn put(mesh: &mut Value, names: &[String]) {
    match mesh.get_mut("extras") {
        Some(Value::Object(extras)) => {
            extras.insert("targetNames".into(), json!(names));
        }
        // Extras of another kind are the user's; a mesh has no other place for names.
        Some(extras) if !extras.is_null() => {}
        _ => mesh["extras"] = json!({ "targetNames": names }),
    }
    for primitive in mesh.get_mut("primitives").and_then(Value::as_array_mut).into_iter().flatten() {
        if let Some(listed) = primitive.pointer_mut("/extras/targetNames").filter(|listed| listed.is_array()) {
            *listed = json!(names);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stand_at_meshes_primitives_and_accessors() {
        let target = |accessor: usize| json!({ "POSITION": accessor });
        let mesh = json!({
            "primitives": [
                { "targets": [target(0), target(0), target(1), target(0)], "extras": { "targetNames": ["", "at", 3] } },
            ],
            "extras": { "targetNames": ["of", ""] },
        });
        let accessors = json!([{}, { "name": "wink" }]);
        let mut json = json!({ "accessors": accessors, "meshes": [mesh] });
        assert_eq!(existing(&json, 0), ["of", "at", "wink", "target-3"]);
        let unnamed = json!({ "primitives": [{ "targets": [target(0)] }], "name": "hair" });
        json["meshes"].as_array_mut().unwrap().push(unnamed);
        assert_eq!(existing(&json, 0), ["of", "at", "wink", "mesh-0-target-3"]);
        assert_eq!(existing(&json, 1), ["hair-target-0"]);
        json["nodes"] = json!([{}, { "mesh": 1, "name": "wig" }]);
        assert_eq!(existing(&json, 1), ["wig-target-0"]);
    }

    #[test]
    fn names_that_exist_get_a_number() {
        let mut names = NewNames::new(["smile".into(), "smile-2".into()]);
        assert_eq!(["smile", "frown", "frown"].map(|name| names.add(name)), ["smile-3", "frown", "frown-2"]);
        let told = "morph targets of the names exist already: `smile` is written as `smile-3`, `frown` is written as `frown-2`";
        assert_eq!(names.warning().unwrap(), told);
        assert_eq!(NewNames::new([]).warning(), None);
    }

    #[test]
    fn extras_that_are_no_object_are_kept() {
        let names = ["a".to_owned()];
        let mut mesh = json!({ "extras": "mine" });
        put(&mut mesh, &names);
        assert_eq!(mesh, json!({ "extras": "mine" }));
        let mut mesh = json!({ "extras": null });
        put(&mut mesh, &names);
        assert_eq!(mesh, json!({ "extras": { "targetNames": ["a"] } }));
        let mut mesh = json!({ "extras": { "id": 7 }, "primitives": [{ "extras": { "targetNames": [] } }, {}] });
        put(&mut mesh, &names);
        let at_primitive = json!({ "extras": { "targetNames": ["a"] } });
        assert_eq!(mesh, json!({ "extras": { "id": 7, "targetNames": ["a"] }, "primitives": [at_primitive, {}] }));
    }
}
