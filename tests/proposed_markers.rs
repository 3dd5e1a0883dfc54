//! Markers that a stage proposes, from the command line: in a run, as files, beside clicks and by a program.
#![cfg(feature = "bundled")]

#[path = "common/named_animals.rs"]
mod named_animals;

mod common;

use common::Project;
// Links the bundled stages.
use mimesh as _;
use nalgebra::Point3;
use named_animals::{Animal, animal};
use serde_json::{Value, json};

/// Writes a pipeline with `markers` as given, from a horse to a camel.
fn write_pipeline(project: &Project, markers: &str) {
    project.write(
        "p.yaml",
        &format!(
            "source: {{ generator: {{ type: quadruped, frames: 1, resolution: 30 }} }}\n\
             target: {{ generator: {{ type: quadruped, proportions: camel, frames: 1, resolution: 30, seed: 1 }} }}\n\
             markers: {markers}\ncorrespondence: {{ type: nonrigid_fit }}\ntransfer: {{ type: gradient }}\n\
             output: out/{{pose}}.obj\n"
        ),
    );
}

/// That pipeline, run to its report.
fn run(project: &Project, markers: &str) -> Value {
    write_pipeline(project, markers);
    let output = project.mimesh(&["run", "p.yaml", "--json"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    serde_json::from_str(&output.stdout).expect("a report")
}

#[test]
fn a_run_proposes_its_markers_once_and_tells_them() {
    let project = Project::new();
    let first = run(&project, "{ type: extremities }");
    let proposed = first["proposed_markers"].as_array().expect("proposed markers").clone();
    assert!(proposed.len() >= 4 && first["markers"] == proposed.len(), "{proposed:?}");
    let stage = |report: &Value| {
        report["stages"].as_array().unwrap().iter().find(|stage| stage["stage"] == "landmarks").unwrap().clone()
    };
    assert_eq!(stage(&first)["type"], "extremities");
    let plan = project.mimesh(&["plan", "p.yaml"]).stdout;
    assert!(plan.contains("landmarks (extremities)") && !plan.contains("run:"), "{plan}");
    let check = project.mimesh(&["check", "p.yaml"]).stdout;
    assert!(check.contains("markers by extremities"), "{check}");
    // A default spelled out is the same stage; another setting is not.
    let again = run(&project, "{ type: extremities, points_per_limb: 2 }");
    assert_eq!((&stage(&again)["reused"], &again["proposed_markers"]), (&json!(true), &json!(proposed)));
    let other = run(&project, "{ type: extremities, points_per_limb: 1 }");
    assert!(stage(&other)["reused"].is_null() && other["markers"].as_u64() < first["markers"].as_u64());
}

/// The named points of both animals as clicks, of which the first is only proposed.
fn write_clicks(project: &Project, count: usize) {
    let (source, target) =
        (animal(json!({ "resolution": 30 })), animal(json!({ "resolution": 30, "proportions": "camel", "seed": 1 })));
    let mut text = "markers:\n".to_owned();
    for (k, name) in source.names.iter().take(count).enumerate() {
        let at = |animal: &Animal| {
            let place = animal.places[animal.names.iter().position(|other| other == name).expect("the same names")];
            let distance = |v: &usize| (animal.surface.positions[*v] - place).norm();
            (0..animal.surface.vertex_count()).min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("vertices")
        };
        let status = if k == 0 { ", status: proposed, confidence: 0.5" } else { "" };
        text += &format!("  - {{ name: {name}, source: {}, target: {}{status} }}\n", at(&source), at(&target));
    }
    project.write("clicks.yaml", &text);
}

#[test]
fn clicks_are_kept_beside_what_a_stage_proposes() {
    let project = Project::new();
    write_clicks(&project, 4);
    let report = run(&project, "{ type: extremities, clicks: clicks.yaml }");
    let proposed = report["proposed_markers"].as_array().expect("markers");
    let sure: Vec<_> = proposed.iter().take_while(|marker| marker["confidence"] == 1.0).collect();
    assert!(sure.len() >= 3 && proposed.len() > 6, "{proposed:?}");
    let warnings = report["warnings"].to_string();
    assert!(warnings.contains("1 pair of the clicks is only proposed"), "{warnings}");
    assert_eq!(report["settings"]["markers"]["clicks"], "clicks.yaml");
    let inputs = report["inputs"].to_string();
    assert!(inputs.contains("clicks.yaml"), "{inputs}");

    // Clicks alone are all there is.
    let given = run(&project, "{ type: given, clicks: clicks.yaml }");
    assert_eq!(given["markers"], 3);
    let none = check_with(&project, "{ type: given }");
    assert!(none.contains("there are no clicks to give") && none.contains("clicks: pairs.yaml"), "{none}");
    let missing = check_with(&project, "{ type: given, clicks: other.yaml }");
    assert!(missing.contains("no such file: other.yaml"), "{missing}");
    let unknown = check_with(&project, "{ type: given, click: clicks.yaml }");
    assert!(unknown.contains("unknown key `click`"), "{unknown}");
}

/// What a run with other markers says on standard error.
fn check_with(project: &Project, markers: &str) -> String {
    let output = project.mimesh(&["run", "p.yaml", "--set", &format!("markers={markers}")]);
    assert_ne!(output.status, 0);
    output.stderr
}

#[cfg(unix)]
#[test]
fn a_program_proposes_markers_only_where_it_is_allowed() {
    let project = Project::new();
    // A matcher that gives the vertices that lie farthest along each axis, and counts how often it ran.
    project.write(
        "matcher.py",
        "import json, os, sys\n\
         def read(path):\n    return [[float(x) for x in l.split()[1:]] for l in open(path) if l.startswith('v ')]\n\
         a, b = read(sys.argv[1]), read(sys.argv[2])\n\
         open(os.path.join(os.path.dirname(__file__), 'ran'), 'a').write('x')\n\
         pairs = []\n\
         for k in range(3):\n    for best in (min, max):\n        \
             i, j = (best(range(len(m)), key=lambda v: m[v][k]) for m in (a, b))\n        \
             pairs.append({'source': i, 'target': j, 'confidence': 0.9})\n\
         print(json.dumps({'pairs': pairs}))\n",
    );
    let ran = project.path("ran");
    let markers = "{ type: external, command: [python3, matcher.py, '{source}', '{target}'] }";
    write_pipeline(&project, markers);
    for command in ["check", "plan", "run"] {
        let output = project.mimesh(&[command, "p.yaml"]);
        assert!(!ran.exists(), "{command} ran it");
        assert_eq!(output.status == 0, command != "run", "{command}: {}", output.stderr);
        if command == "run" {
            assert!(output.stderr.contains("it would run the command `python3"), "{}", output.stderr);
            assert!(output.stderr.contains("`--allow-commands`"), "{}", output.stderr);
        }
    }
    // No setting says what only the command line may.
    let set = project.mimesh(&["run", "p.yaml", "--set", "markers.allow_commands=true"]);
    assert!(set.status != 0 && !ran.exists(), "{}", set.stderr);

    let run = |project: &Project| {
        let output = project.mimesh(&["run", "p.yaml", "--allow-commands", "--json"]);
        assert!([0, 3].contains(&output.status), "{}", output.stderr);
        serde_json::from_str::<Value>(&output.stdout).expect("a report")
    };
    let report = run(&project);
    // Some extremes are one vertex.
    let count = report["proposed_markers"].as_array().expect("markers").len();
    assert!((4..=6).contains(&count), "{report}");
    run(&project);
    assert_eq!(std::fs::read(&ran).expect("it ran"), b"x", "the second answer is cached");
    // Another program is asked anew.
    project.write("matcher.py", &(project.read("matcher.py") + "# changed\n"));
    run(&project);
    assert_eq!(std::fs::read(&ran).expect("it ran"), b"xx");

    project.write("matcher.py", "import sys\nprint('no weights', file=sys.stderr)\nsys.exit(3)\n");
    let failed = project.mimesh(&["run", "p.yaml", "--allow-commands"]);
    assert!(failed.stderr.contains("exit status: 3: no weights"), "{}", failed.stderr);
}

#[test]
fn proposed_pairs_are_written_corrected_and_taken_up_again() {
    let project = Project::new();
    let report = run(&project, "{ type: extremities }");
    let file = format!("{}.obj", report["poses"][0]["name"].as_str().expect("a name"));
    let propose = |arguments: &[&str]| {
        let all = [&["markers", "propose", "--pipeline", "p.yaml", "-o", "pairs.yaml"], arguments].concat();
        project.mimesh(&all)
    };
    let first = propose(&[]);
    assert_eq!(first.status, 0, "{}", first.stderr);
    let text = project.read("pairs.yaml");
    let pairs: Vec<&str> = text.lines().filter(|line| line.starts_with("  - ")).collect();
    assert!(pairs.len() >= 4 && pairs.iter().all(|line| line.contains("status: proposed, confidence: ")), "{text}");
    assert!(project.bytes("pairs.png").starts_with(b"\x89PNG"));
    let again = propose(&[]);
    assert!(again.status != 0 && again.stderr.contains("--force"), "{}", again.stderr);

    // What is written runs as markers, and gives what the stage itself gives.
    let by_stage = project.read(&format!("out/{file}"));
    let by_file = project.mimesh(&["run", "p.yaml", "--set", "markers=pairs.yaml", "--out", "again", "--json"]);
    assert_eq!(by_file.status, 0, "{}", by_file.stderr);
    let numbers = |text: &str| -> Vec<f64> {
        let lines = text.lines().filter_map(|line| line.strip_prefix("v "));
        lines.flat_map(str::split_whitespace).map(|word| word.parse().expect("a number")).collect()
    };
    let (by_file, by_stage) = (numbers(&project.read(&format!("again/{file}"))), numbers(&by_stage));
    let difference = by_file.iter().zip(&by_stage).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // Coordinates in the file sum to 1 but for the last bit, which the fit carries on; the animals are 2 units long.
    assert!(by_file.len() == by_stage.len() && difference < 1e-6, "the file's pairs lead elsewhere by {difference}");

    // A confirmed pair comes first and stays, the others are found anew.
    project.write("pairs.yaml", &text.replacen(", status: proposed", ", status: confirmed", 1));
    let kept = propose(&["--clicks", "pairs.yaml", "--force", "--json"]);
    assert_eq!(kept.status, 0, "{}", kept.stderr);
    let report: Value = serde_json::from_str(&kept.stdout).expect("JSON");
    assert_eq!((&report["clicks"], &report["pairs"][0]["confidence"]), (&json!(1), &json!(1.0)));
    let text = project.read("pairs.yaml");
    let first = text.lines().find(|line| line.starts_with("  - ")).expect("a pair");
    assert!(!first.contains("status"), "{text}");

    let unknown = propose(&["--type", "magic", "--force"]);
    assert!(
        unknown.stderr.contains("no stage `magic`") && unknown.stderr.contains("mimesh list"),
        "{}",
        unknown.stderr
    );
}

/// With clicks at one end alone, the next one belongs elsewhere.
#[test]
fn the_next_click_is_away_from_the_known_ones() {
    let project = Project::new();
    run(&project, "{ type: extremities }");
    write_clicks(&project, 6);
    let suggest = |arguments: &[&str]| {
        let all = [&["markers", "suggest", "--pipeline", "p.yaml"], arguments].concat();
        let output = project.mimesh(&all);
        (output.status, output.stdout, output.stderr)
    };
    let (status, stdout, stderr) = suggest(&["--clicks", "clicks.yaml", "--json"]);
    assert_eq!(status, 0, "{stderr}");
    let point: Value = serde_json::from_str(&stdout).expect("JSON");
    let place: [f64; 3] = serde_json::from_value(point["source_at"].clone()).expect("a place");
    let horse = animal(json!({ "resolution": 30 }));
    let nearest =
        horse.places[..6].iter().map(|known| (known - Point3::from(place)).norm()).fold(f64::INFINITY, f64::min);
    // A tenth of the animal is more than a hoof.
    assert!(nearest > 0.1 * horse.surface.diagonal(), "{nearest} from a known point: {point}");
    assert!(point["target_at"].is_array() && point["known"] == 6, "{point}");

    let (status, stdout, stderr) = suggest(&[]);
    assert!(status == 0 && stdout.starts_with("click next, beside "), "{stdout}{stderr}");
    let (status, _, stderr) = suggest(&["--type", "given", "--clicks", "clicks.yaml"]);
    assert!(status != 0 && stderr.contains("given suggests no points") && stderr.contains("extremities"), "{stderr}");
}

#[cfg(unix)]
#[test]
fn the_example_of_a_program_runs() {
    let project = Project::new();
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/external/external.yaml");
    let output = project.mimesh(&["run", example, "--allow-commands", "--out", "out", "--json"]);
    assert!([0, 3].contains(&output.status), "{}", output.stderr);
    let report: Value = serde_json::from_str(&output.stdout).expect("a report");
    assert_eq!(report["proposed_markers"].as_array().map(Vec::len), Some(6), "{report}");
}
