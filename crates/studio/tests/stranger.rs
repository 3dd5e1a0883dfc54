//! A stage of a stranger's crate is in the forms by being linked.

mod common;

use common::{sample, serve};
use mimesh_core::{
    Result,
    mesh::{Surface, SurfacePoint},
    register,
    stage::Sampler,
};
use mimesh_key_points as _;
use mimesh_studio::Start;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

register!(Sampler: EveryNth);

/// One vertex of every few, as nobody else would choose them.
#[derive(Debug, Deserialize, JsonSchema, Serialize)]
#[serde(default, deny_unknown_fields)]
struct EveryNth {
    /// How many vertices to go on.
    #[schemars(range(min = 1, max = 50))]
    step: usize,
}

impl Default for EveryNth {
    fn default() -> Self {
        Self { step: 7 }
    }
}

#[typetag::serde(name = "every_nth")]
impl Sampler for EveryNth {
    fn sample(&self, surface: &Surface) -> Result<Vec<SurfacePoint>> {
        Ok((0..surface.vertex_count() as u32).step_by(self.step).map(SurfacePoint::Vertex).collect())
    }
}

/// All objects in `schema` that describe a stage of type `name`.
fn of_type<'a>(schema: &'a Value, name: &str, found: &mut Vec<&'a Value>) {
    if schema["properties"]["type"]["const"] == name {
        found.push(schema);
    }
    match schema {
        Value::Object(members) => members.values().for_each(|member| of_type(member, name, found)),
        Value::Array(members) => members.iter().for_each(|member| of_type(member, name, found)),
        _ => {}
    }
}

#[test]
fn it_has_its_doc_comments_default_and_limits_and_is_checked() {
    let folder = tempfile::tempdir().unwrap();
    let client = serve(folder.path(), Some(Start::Pipeline(sample(folder.path()))));
    let schema = client.get("/api/schema").json();
    let mut found = Vec::new();
    of_type(&schema, "every_nth", &mut found);
    let stage = found.first().expect("the stage is in the schema");
    assert!(stage["description"].as_str().unwrap().starts_with("One vertex of every few"), "{stage:#}");
    let step = &stage["properties"]["step"];
    // The other kind of value is a variable of the pipeline.
    assert_eq!(
        (&step["description"], &step["default"], &step["anyOf"][0]["minimum"], &step["anyOf"][0]["maximum"]),
        (&json!("How many vertices to go on."), &json!(7), &json!(1), &json!(50)),
        "{step:#}"
    );
    // What the form sends arrives in the text, and its mistakes at the field.
    let base = client.get("/api/pipeline").json()["revision"].clone();
    let path = json!(["key_points"]);
    let set = |base: &Value, step: u64| {
        let value = json!({ "type": "greedy", "sampler": { "type": "every_nth", "step": step } });
        client.post("/api/pipeline/set", json!({ "base": base, "path": path, "value": value })).json()
    };
    let wrong = set(&base, 51);
    assert!(wrong["text"].as_str().unwrap().contains("every_nth"), "{wrong:#}");
    let checked =
        client.wait("/api/pipeline", |pipeline| pipeline["checking"] == false && pipeline["diagnostics"] != json!([]));
    assert_eq!(checked["diagnostics"][0]["path"], json!(["key_points", "sampler", "step"]), "{checked:#}");
    set(&checked["revision"], 50);
    client.wait("/api/pipeline", |pipeline| pipeline["checking"] == false && pipeline["diagnostics"] == json!([]));
}
