//! Landmarks without clicks, on the built-in animals, whose generator knows the true partner of each point.
#![cfg(feature = "bundled")]

mod common;

use common::Project;
// Links the bundled stages.
use mimesh as _;
use mimesh_core::{
    Result,
    mesh::{MeshSequence, Surface},
    plugin::{configured, instance},
    random::Random,
    stage::{Generator, Landmarks, Marker, Proposal, TransferPair},
    testkit::meshes,
};
use nalgebra::{Matrix3, Point3, Unit, Vector3};
use serde_json::{Value, json};

/// A point farther than this share of the diagonal from its true partner is wrong: a hoof is 4 % wide, a head 15 % long.
const WRONG: f64 = 0.08;

/// An animal, its points by name, and its surface.
struct Animal {
    names: Vec<String>,
    places: Vec<Point3<f64>>,
    surface: Surface,
}

fn animal(settings: Value) -> Animal {
    let mut all = json!({ "type": "quadruped", "gait": "none", "resolution": 60 });
    all.as_object_mut().unwrap().extend(settings.as_object().unwrap().clone());
    let sequence: MeshSequence = configured::<dyn Generator>(all).expect("a quadruped").make().expect("an animal");
    let surface = Surface::new(&sequence.rest).expect("a surface");
    let place = |point| surface.point(point).expect("a point").position(&surface, &surface.positions);
    Animal {
        names: sequence.landmarks.iter().map(|landmark| landmark.name.clone()).collect(),
        places: sequence.landmarks.iter().map(|landmark| place(landmark.point)).collect(),
        surface,
    }
}

fn propose(source: &Surface, target: &Surface) -> Result<Proposal> {
    let stage = instance::<dyn Landmarks>("extremities").expect("the stage is linked");
    stage.propose(TransferPair { source, target, markers: &[], proximity: None })
}

/// How far the target's point of `marker` lies from its true partner, relative to the diagonal, and the name of the nearest landmark.
///
/// The partner lies beside that landmark as the source's point does, for which both animals stand alike.
fn error_of(marker: &Marker, source: &Animal, target: &Animal, on: &Surface) -> (f64, String) {
    let p = marker.source.position(&source.surface, &source.surface.positions);
    let q = marker.target.position(on, &target.surface.positions);
    let distance = |k: &usize| (source.places[*k] - p).norm();
    let nearest = (0..source.places.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("landmarks");
    let name = &source.names[nearest];
    let partner = target.places[target.names.iter().position(|other| other == name).expect("the same names")];
    let offset = (p - source.places[nearest]) * (target.surface.diagonal() / source.surface.diagonal());
    ((q - (partner + offset)).norm() / target.surface.diagonal(), name.clone())
}

fn check_pairs(case: &str, proposal: &Proposal, source: &Animal, target: &Animal, on: &Surface) {
    let mut found = Vec::new();
    // Only the ends of limbs have partners that the generator knows.
    for pair in proposal.pairs.iter().filter(|pair| pair.marker.name.starts_with("limb")) {
        let (error, name) = error_of(&pair.marker, source, target, on);
        assert!(error < WRONG, "{case}: {} at the {name} is {error} off: {:?}", pair.marker.name, proposal.figures);
        found.push(name);
    }
    for leg in ["left_front", "right_front", "left_hind", "right_hind"] {
        assert!(found.iter().any(|name| name.starts_with(leg)), "{case}: no point of the {leg} leg among {found:?}");
    }
}

#[test]
fn built_in_animals_are_paired_with_the_right_legs_and_heads() {
    let kinds = ["horse", "camel", "giraffe"];
    for (a, b) in kinds.iter().flat_map(|a| kinds.iter().map(move |b| (a, b))) {
        let (source, target) = (animal(json!({ "proportions": a })), animal(json!({ "proportions": b, "seed": 1 })));
        let proposal = propose(&source.surface, &target.surface).unwrap();
        check_pairs(&format!("{a} to {b}"), &proposal, &source, &target, &target.surface);
    }
}

/// The target turned, made larger, moved, and with its vertices and triangles in another order, is the same shape.
#[test]
fn axes_size_place_and_order_of_the_target_do_not_matter() {
    let (source, target) = (animal(json!({})), animal(json!({ "proportions": "camel", "seed": 1 })));
    for (k, turn) in turns().into_iter().enumerate() {
        let mut on = shuffled(&target.surface, k as u64);
        on.positions.iter_mut().for_each(|p| *p = turn * *p * 37.0 + Vector3::new(900.0, -40.0, 5.0));
        let proposal = propose(&source.surface, &on).unwrap();
        // The pairs are judged where the target stood before.
        on.positions.iter_mut().for_each(|p| *p = turn.transpose() * (*p - Vector3::new(900.0, -40.0, 5.0)) / 37.0);
        let there = Animal { surface: on.clone(), names: target.names.clone(), places: target.places.clone() };
        check_pairs(&format!("turn {k}"), &proposal, &source, &there, &on);
        let figures = &proposal.figures;
        assert!(figures.number("next_score") > figures.number("score"), "turn {k}: another turn fits as well");
    }
}

/// The rotations that take axes to axes.
fn turns() -> Vec<Matrix3<f64>> {
    let quarter = |axis: Unit<Vector3<f64>>, times: u32| {
        let angle = f64::from(times) * std::f64::consts::FRAC_PI_2;
        nalgebra::Rotation3::from_axis_angle(&axis, angle).matrix().map(f64::round)
    };
    // What was up points to each of six sides, in four turns about it.
    let sides = [
        quarter(Vector3::x_axis(), 0),
        quarter(Vector3::x_axis(), 1),
        quarter(Vector3::x_axis(), 2),
        quarter(Vector3::x_axis(), 3),
    ];
    let others = [1, 3].map(|times| quarter(Vector3::z_axis(), times));
    sides
        .iter()
        .chain(&others)
        .flat_map(|side| [0, 1, 2, 3].map(|times| side * quarter(Vector3::y_axis(), times)))
        .collect()
}

/// The same surface with its vertices and triangles in another order.
fn shuffled(surface: &Surface, seed: u64) -> Surface {
    let mut random = Random::new(seed);
    let mut order = |count: usize| {
        let mut order: Vec<usize> = (0..count).collect();
        (1..count).rev().for_each(|k| order.swap(k, random.index(k + 1)));
        order
    };
    let (vertices, triangles) = (order(surface.vertex_count()), order(surface.triangle_count()));
    let mut number = vec![0; vertices.len()];
    (0u32..).zip(&vertices).for_each(|(new, &old)| number[old] = new);
    let positions = vertices.iter().map(|&v| surface.positions[v]).collect();
    let triangles = triangles.iter().map(|&t| surface.triangles[t].map(|v| number[v as usize])).collect();
    Surface::from_triangles(positions, triangles).unwrap()
}

#[test]
fn shapes_without_limbs_are_refused_with_a_way_out() {
    let horse = animal(json!({})).surface;
    for round in [meshes::icosphere(3), meshes::bar([9, 3, 2], [3.0, 0.9, 0.7])] {
        let error = propose(&horse, &round).unwrap_err();
        assert!(error.to_string().starts_with("the target has "), "{error}");
        assert!(error.hint().is_some_and(|hint| hint.contains("markers by hand")), "{error}");
    }
}

#[test]
fn a_target_that_is_inside_out_gives_the_same_points_and_a_warning() {
    let (source, mut target) = (animal(json!({})), animal(json!({ "seed": 1 })));
    target.surface.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let proposal = propose(&source.surface, &target.surface).unwrap();
    check_pairs("inside out", &proposal, &source, &target, &target.surface);
    let warnings = &proposal.figures.warnings;
    assert!(warnings.iter().any(|warning| warning.contains("point inwards")), "{warnings:?}");
}

#[test]
fn a_target_turned_by_any_angle_is_found() {
    let (source, target) = (animal(json!({})), animal(json!({ "seed": 1 })));
    let axes = [Vector3::y_axis(), Unit::new_normalize(Vector3::new(1.0, 2.0, -0.5))];
    for (axis, degrees) in [(axes[0], 29.0_f64), (axes[0], 140.0), (axes[1], 65.0)] {
        let turn = nalgebra::Rotation3::from_axis_angle(&axis, degrees.to_radians());
        let mut on = target.surface.clone();
        on.positions.iter_mut().for_each(|p| *p = turn * *p);
        let proposal = propose(&source.surface, &on).unwrap();
        // The pairs are judged where the target stood before.
        check_pairs(&format!("{degrees} degrees"), &proposal, &source, &target, &target.surface);
    }
}

#[test]
fn right_matches_are_sure_and_wrong_ones_are_doubtful_or_refused() {
    let sureness = |source: &Surface, target: &Surface| {
        let proposal = propose(source, target).ok()?;
        let mean = proposal.pairs.iter().map(|pair| pair.confidence).sum::<f64>() / proposal.pairs.len() as f64;
        Some((mean, !proposal.figures.warnings.is_empty(), proposal.figures.number("agreement")?))
    };
    let [horse, camel] = ["horse", "camel"].map(|kind| animal(json!({ "proportions": kind })).surface);
    let (mean, is_doubtful, agreement) = sureness(&horse, &camel).expect("landmarks");
    // Half of what is possible, as that is where landmarks become doubtful.
    assert!(mean > 0.5 && !is_doubtful && agreement > 0.75, "{mean} {agreement}");
    // A star of six arms has limbs, none of which are those of an animal.
    let star = star();
    for (source, target) in [(&horse, &star), (&star, &horse)] {
        if let Some((mean, is_doubtful, agreement)) = sureness(source, target) {
            assert!(is_doubtful && mean < 0.5, "{mean} {agreement}");
        }
    }
}

/// A ball drawn out along both ways of each axis.
fn star() -> Surface {
    let mut ball = meshes::icosphere(4);
    for p in &mut ball.positions {
        let most = p.coords.amax();
        p.coords *= 1.0 + 3.0 * most.powi(20);
    }
    ball
}

/// A ball that is no turn of itself, as a head is: it has a nose, a chin, and ears of two sizes.
fn head(nose: f64) -> Surface {
    let mut ball = meshes::icosphere(4);
    let bumps = [([0.0, 0.0, 1.0], nose), ([0.0, -0.8, 0.6], 0.25), ([0.9, 0.3, 0.0], 0.3), ([-0.9, 0.3, -0.2], 0.2)];
    for p in &mut ball.positions {
        let rise =
            |(at, height): &([f64; 3], f64)| height * (-8.0 * (p.coords - Vector3::from(*at)).norm_squared()).exp();
        let grown = 1.0 + bumps.iter().map(rise).sum::<f64>();
        *p = Point3::new(0.8 * p.x * grown, 1.2 * p.y * grown, p.z * grown);
    }
    ball
}

#[test]
fn shapes_without_limbs_that_lie_alike_are_paired_by_place() {
    let (source, target) = (head(0.4), head(0.5));
    for turn in [turns()[0], turns()[5]] {
        let mut on = target.clone();
        on.positions.iter_mut().for_each(|p| *p = turn * *p * 10.0);
        let proposal = propose(&source, &on).unwrap();
        assert!(proposal.pairs.len() >= 8, "{:?}", proposal.pairs);
        for pair in &proposal.pairs {
            // Both heads are one ball, vertex by vertex.
            let q = pair.marker.target.position(&target, &target.positions);
            let p = pair.marker.source.position(&target, &target.positions);
            assert!((p - q).norm() < 0.03 * target.diagonal(), "{} is {} off", pair.marker.name, (p - q).norm());
        }
    }
}

/// A pipeline with `markers` as given, run to its report.
fn run(project: &Project, markers: &str) -> Value {
    project.write(
        "p.yaml",
        &format!(
            "source: {{ generator: {{ type: quadruped, frames: 1, resolution: 30 }} }}\n\
             target: {{ generator: {{ type: quadruped, proportions: camel, frames: 1, resolution: 30, seed: 1 }} }}\n\
             markers: {markers}\ncorrespondence: {{ type: nonrigid_fit }}\ntransfer: {{ type: gradient }}\n\
             output: out/{{pose}}.obj\n"
        ),
    );
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
    project.write(
        "p.yaml",
        &format!(
            "source: {{ generator: {{ type: quadruped, frames: 1, resolution: 30 }} }}\n\
             target: {{ generator: {{ type: quadruped, proportions: camel, frames: 1, resolution: 30, seed: 1 }} }}\n\
             markers: {markers}\ncorrespondence: {{ type: nonrigid_fit }}\ntransfer: {{ type: gradient }}\n\
             output: out/{{pose}}.obj\n"
        ),
    );
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
