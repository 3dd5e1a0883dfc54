//! Merging documents: one file over another, key by key.

use serde_json::Value;

use crate::{
    document::Document,
    source_tree::{SpanEntry, SpanTree},
    step::Step,
};

/// Merges `own` into `base`: mappings are merged key by key, everything else is replaced, and so is a stage by one of another
/// `type`. Nothing (`markers: ~`) over a key of the whole takes it out.
pub fn merge_into(base: &mut Document, own: Document) {
    let taken_out: Vec<String> = match (&base.value, &own.value) {
        (Value::Object(base), Value::Object(own)) => own
            .iter()
            .filter(|(key, value)| value.is_null() && base.contains_key(*key))
            .map(|(k, _)| k.clone())
            .collect(),
        _ => vec![],
    };
    merge(&mut base.value, &mut base.root, own.value, own.root);
    for key in taken_out {
        base.take(&key);
    }
}

fn merge(value: &mut Value, node: &mut SpanTree, own: Value, mut own_node: SpanTree) {
    match (value, own) {
        (Value::Object(map), Value::Object(own))
            if !own.get("type").is_some_and(|own| map.get("type") != Some(own)) =>
        {
            for (key, own) in own {
                let step = Step::Key(key);
                let SpanEntry { key: key_spot, node: own_node, .. } = own_node.take(&step);
                let part = node.part_mut(&step);
                part.key = key_spot;
                let Step::Key(key) = step else { continue };
                match map.get_mut(&key) {
                    Some(value) => merge(value, &mut part.node, own, own_node),
                    None => {
                        part.node = own_node;
                        map.insert(key, own);
                    }
                }
            }
            node.span = own_node.span;
            node.folder = own_node.folder;
        }
        (value, own) => {
            *value = own;
            *node = own_node;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use proptest::prelude::*;
    use serde_json::json;

    use super::*;

    fn merged(layers: &[&str]) -> Value {
        let parse = |text: &&str| Document::parse(Path::new("p.yaml"), text).unwrap();
        let mut layers = layers.iter().map(parse);
        let mut base = layers.next().unwrap();
        layers.for_each(|own| merge_into(&mut base, own));
        base.value
    }

    #[test]
    fn maps_are_merged_deeply_and_own_keys_win() {
        assert_eq!(
            merged(&["a: { b: { c: 1, d: 2 } }\ne: [1, 2]\n", "a: { b: { d: 3 } }\ne: [4]\n"]),
            json!({ "a": { "b": { "c": 1, "d": 3 } }, "e": [4] })
        );
    }

    #[test]
    fn another_type_begins_anew_and_the_same_or_none_changes_settings() {
        let base = "t: { type: x, k: 1, n: { type: y, l: 2 } }\n";
        assert_eq!(merged(&[base, "t: { type: z, m: 3 }\n"]), json!({ "t": { "type": "z", "m": 3 } }));
        let changed = json!({ "t": { "type": "x", "k": 5, "n": { "type": "y", "l": 2 } } });
        assert_eq!(merged(&[base, "t: { type: x, k: 5 }\n"]), changed);
        assert_eq!(merged(&[base, "t: { k: 5 }\n"]), changed);
    }

    #[test]
    fn nothing_takes_a_slot_out_but_is_a_value_within() {
        assert_eq!(merged(&["a: 1\nb: { c: 1 }\n", "a: ~\nb: { c: ~ }\n"]), json!({ "b": { "c": null } }));
    }

    /// Maps in which `a` and `b` are maps and `x` and `y` are none, as a key is of one kind in all pipelines.
    fn maps() -> impl Strategy<Value = Value> {
        let leaves = || {
            let leaf = prop_oneof![(0..3i32).prop_map(Value::from), Just(json!([1])), Just(json!("t"))];
            prop::collection::btree_map("[xy]", leaf, 0..3)
        };
        leaves().prop_map(|map| json!(map)).prop_recursive(3, 24, 4, move |inner| {
            let maps = prop::collection::btree_map("[ab]", inner, 0..3);
            (leaves(), maps).prop_map(|(leaves, maps)| {
                let mut all = leaves;
                all.extend(maps);
                json!(all)
            })
        })
    }

    fn over(base: &Value, own: &Value) -> Value {
        merged(&[&base.to_string(), &own.to_string()])
    }

    proptest! {
        /// Merging is associative, so that it does not matter which file includes which.
        ///
        /// That holds without stages, whose types may begin anew, and where a mapping in one file is one in all.
        #[test]
        fn merging_is_associative(a in maps(), b in maps(), c in maps()) {
            prop_assert_eq!(over(&over(&a, &b), &c), over(&a, &over(&b, &c)));
        }

        #[test]
        fn merging_is_idempotent_and_own_values_are_all_there(a in maps(), b in maps()) {
            prop_assert_eq!(over(&a, &a), a.clone());
            let ab = over(&a, &b);
            prop_assert_eq!(over(&ab, &b), ab);
        }

        /// A value of the result is at the place where it was written.
        #[test]
        fn places_go_along(a in maps(), b in maps()) {
            let parse = |name: &str, value: &Value| Document::parse(Path::new(name), &value.to_string()).unwrap();
            let mut both = parse("a", &a);
            merge_into(&mut both, parse("b", &b));
            for (key, value) in both.value.as_object().unwrap() {
                let written = if b.get(key).is_some() { "b" } else { "a" };
                let location = both.location(&[Step::Key(key.clone())], crate::document::At::Value);
                prop_assert!(location.to_string().starts_with(&format!("{written}:")), "{key}: {value} at {location}");
            }
        }
    }
}
