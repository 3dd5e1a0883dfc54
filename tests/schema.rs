//! The schema that editors complete and check pipelines with.
#![cfg(feature = "bundled")]

mod common;

use std::path::Path;

use common::{PIPELINE, Project, diagnostics, json, pipelines, with_targets};

#[test]
fn the_schema_accepts_every_pipeline_and_rejects_wrong_ones() {
    let project = Project::new();
    let schema = json(&project.mimesh(&["schema"]).stdout);
    let mut schemas = boon::Schemas::new();
    let mut compiler = boon::Compiler::new();
    compiler.add_resource("mimesh.json", schema).unwrap();
    let compiled = compiler.compile("mimesh.json", &mut schemas).unwrap_or_else(|error| panic!("{error:#}"));
    let valid = |text: &str| {
        let value = mimesh::document::Document::parse(Path::new("p.yaml"), text).unwrap().value;
        schemas.validate(&value, compiled).map_err(|error| format!("{error:#}"))
    };
    for file in pipelines() {
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(valid(&text).is_ok(), "{}: {}", file.display(), valid(&text).unwrap_err());
    }
    let targets = "targets: { a: { rest: x.obj, transfer: { reweightings: 1 } } }";
    let good = [
        PIPELINE.to_owned(),
        PIPELINE.replace("transfer: { type: copy_displacement }\n", ""),
        PIPELINE.replace("{ type: identity }", "auto") + "markers: auto\nproximity: ~\n",
        with_targets(targets),
        "include: base.yaml\ntransfer: { reweightings: 1 }\n".into(),
        PIPELINE.replace("{ type: identity }", "${method}") + "variables: { method: { type: identity } }\n",
        PIPELINE.replace("copy_displacement", "gradient, tolerance: ${t}") + "matrix: { variables.t: [0.1, 0.2] }\n",
    ];
    for text in good {
        assert!(valid(&text).is_ok(), "{text}: {}", valid(&text).unwrap_err());
    }
    let bad = [
        PIPELINE.replace("target:", "tarjet:"),
        PIPELINE.replace("copy_displacement", "gradient, tolerance: much"),
        PIPELINE.replace("{ type: copy_displacement }", "{ reweightings: 1 }"),
        PIPELINE.replace("{ type: copy_displacement }", "automatic"),
        with_targets("targets: { a: { rst: x.obj } }"),
        with_targets("targets: { a: { rest: x.obj, transfer: { type: gradiant } } }"),
        PIPELINE.to_owned() + "matrix: { transfer.k: 5 }\n",
        PIPELINE.to_owned() + "targets: { a: { rest: x.obj } }\n",
    ];
    for text in bad {
        assert!(valid(&text).is_err(), "{text}");
    }
}

#[test]
fn a_line_for_editors_is_a_comment() {
    let project = Project::new();
    project.write("p.yaml", &format!("# yaml-language-server: $schema=mimesh.schema.json\n{PIPELINE}"));
    assert_eq!(diagnostics(&project, &[]), [""; 0]);
}
