//! Key points from the command line, and biharmonic transfer with them.
#![cfg(feature = "bundled")]

mod common;

use common::{Project, cube};
use mimesh::core::{
    mesh::{Surface, SurfacePoint},
    plugin::instance,
    spatial::Similarity,
    stage::{BindInput, Marker, Transfer, TransferPair, Work},
    testkit::{data::data, meshes, random::Random},
};
use nalgebra::{Point3, Rotation3, Vector3};

fn project() -> Project {
    let project = Project::new();
    // A shear is one affine map: a few handles tell it exactly, and no more than a few are added.
    project.write(
        "p.yaml",
        "source: { rest: rest.obj, poses: pose-*.obj }\ntarget: { rest: target.obj }\n\
         key_points: { type: greedy, max_count: 4, threshold: 0, sampler: { type: farthest_point, count: 8 } }\nmarkers: k.markers.yaml\n\
         transfer: { type: biharmonic }\noutput: out/{pose}.obj\n",
    );
    project.write("target.obj", &cube(|[x, y, z]| [2.0 * x, 2.0 * y, 2.0 * z]));
    project
}

#[test]
fn key_points_are_written_without_targets_and_a_run_names_the_missing_ones() {
    let project = project();
    let output = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.status, 66, "{}", output.stderr);

    let output = project.mimesh(&["keypoints", "p.yaml", "--curve", "curve.svg"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert!(output.stdout.contains("written: k.markers.yaml"), "{}", output.stdout);
    let text = project.read("k.markers.yaml");
    assert!(text.contains("name: \"key 1\"") && text.contains("target: null") && text.contains("side"), "{text}");
    assert!(project.read("curve.svg").contains("<polyline"));

    let output = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.status, 65, "{}", output.stderr);
    let count = text.matches("target: null").count();
    assert!(output.stderr.contains("k.markers.yaml:"), "{}", output.stderr);
    assert!(
        output.stderr.contains(&format!("{count} of {count} markers have no target: key 1 (")),
        "{}",
        output.stderr
    );
    assert!(!project.path("out").exists(), "nothing is written");
}

#[test]
fn completed_key_points_move_the_target() {
    let project = project();
    let output = project.mimesh(&["keypoints", "p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    // The target is the source twice as large, vertex by vertex.
    let completed: String = project
        .read("k.markers.yaml")
        .lines()
        .map(|line| match line.split_once("source: ").and_then(|(_, rest)| rest.split_once(", target: null")) {
            Some((vertex, _)) => line.replace("target: null", &format!("target: {vertex}")) + "\n",
            None => line.to_owned() + "\n",
        })
        .collect();
    project.write("k.markers.yaml", &completed);
    project.write("truth.obj", &cube(|[x, y, z]| [2.0 * (x + z), 2.0 * y, 2.0 * z]));
    // Affine maps without rigidity: a shear is one of them.
    project.edit("type: biharmonic", "type: biharmonic, deformer: { type: linear_blend }");
    let output = project.mimesh(&["run", "p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    let output = project.mimesh(&["score", "out/10.obj", "truth.obj", "--rest", "target.obj", "--json"]);
    let score: serde_json::Value =
        serde_json::from_str(&output.stdout).unwrap_or_else(|error| panic!("{error}: {}", output.stderr));
    let mean = score.pointer("/over_poses/average/mean").and_then(serde_json::Value::as_f64).expect("a score");
    // Maps are drawn to rigid motions by a slight regularisation; doing nothing is 40 % off.
    assert!(mean < 0.5, "{mean} % of the diagonal");
}

#[test]
fn existing_markers_are_not_replaced_without_an_option() {
    let project = project();
    assert_eq!(project.mimesh(&["keypoints", "p.yaml"]).status, 0);
    let before = project.read("k.markers.yaml");
    let output = project.mimesh(&["keypoints", "p.yaml"]);
    assert_eq!(
        (output.status, output.stderr.as_str()),
        (
            73,
            "error: k.markers.yaml: there are markers already\n  hint: `--resume` goes on from them, `--force` replaces \
             them, `--output FILE` writes others\n"
        )
    );
    assert_eq!(project.read("k.markers.yaml"), before);

    let found = before.replacen("target: null", "target: 5", 1);
    project.write("k.markers.yaml", &found);
    let output = project.mimesh(&["keypoints", "p.yaml", "--resume", "--set", "key_points.max_rounds=0"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert!(project.read("k.markers.yaml").contains("target: 5"), "a target that was found stays");
    assert_eq!(project.mimesh(&["keypoints", "p.yaml", "--force"]).status, 0);
    assert!(!project.read("k.markers.yaml").contains("target: 5"));

    let output = project.mimesh(&["keypoints", "p.yaml", "--output", "k.cons"]);
    assert_eq!(output.status, 2, "{}", output.stderr);
    assert!(output.stderr.contains("k.cons: key points are written as .yaml"), "{}", output.stderr);
}

#[test]
fn the_curve_replaces_no_other_file() {
    let project = project();
    let before = project.read("rest.obj");
    for curve in ["rest.obj", "k.yaml", "out"] {
        let output = project.mimesh(&["keypoints", "p.yaml", "--output", "k.yaml", "--curve", curve]);
        assert_eq!(output.status, 2, "{}", output.stderr);
        assert!(output.stderr.contains(&format!("--curve {curve}: expected a .svg file")), "{}", output.stderr);
        assert!(!project.has("k.yaml"), "nothing is written");
    }
    assert_eq!(project.read("rest.obj"), before);
    #[cfg(unix)]
    {
        // Another name of an input is that input.
        std::os::unix::fs::symlink(project.path("rest.obj"), project.path("rest.svg")).expect("a link");
        let output = project.mimesh(&["keypoints", "p.yaml", "--curve", "rest.svg"]);
        assert_eq!(output.status, 73, "{}", output.stderr);
        assert!(output.stderr.contains("--curve rest.svg: the pipeline reads this file"), "{}", output.stderr);
        assert_eq!(project.read("rest.obj"), before);
    }
}

#[test]
fn other_slots_may_use_what_the_matrix_defines() {
    let project = project();
    project.edit("output:", "matrix: { variables.t: [0.1, 0.2] }\ngates: { volume: ${t} }\noutput:");
    let output = project.mimesh(&["keypoints", "p.yaml"]);
    assert_eq!(output.status, 0, "{}", output.stderr);
    project.edit("threshold: 0,", "threshold: ${t},");
    let output = project.mimesh(&["keypoints", "p.yaml", "--force"]);
    assert_eq!(output.status, 78, "{}", output.stderr);
    assert!(output.stderr.contains("undefined variable `t`"), "{}", output.stderr);
}

#[cfg(unix)]
#[test]
fn an_interrupted_search_is_written_and_resumed_to_the_same_end() {
    use std::{
        io::{BufRead, BufReader, Read},
        process::{Command, Stdio},
    };
    let project = project();
    let bar = meshes::bar([12, 4, 4], [3.0, 0.9, 0.7]);
    let obj = |positions: &[Point3<f64>]| -> String {
        let vertices = positions.iter().map(|p| format!("v {} {} {}\n", p.x, p.y, p.z));
        let faces = bar.triangles.iter().map(|t| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
        vertices.chain(faces).collect()
    };
    project.write("rest.obj", &obj(&bar.positions));
    project.write("pose-1.obj", &obj(&bent(&bar)));
    project.edit("pose-*.obj", "pose-1.obj");
    // Judging every candidate up to 60 points takes far longer than this test waits.
    project.edit("max_count: 4", "max_count: 60, exhaustive: true");
    project.edit("count: 8", "count: 80");

    let mut child = project
        .command(&["keypoints", "p.yaml", "--curve", "curve.svg"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the command runs");
    let lines = BufReader::new(child.stderr.take().expect("a pipe")).lines();
    let mut steps = 0;
    for line in lines.map(|line| line.expect("UTF-8")) {
        assert!(line.contains("key points, error"), "{line}");
        steps += 1;
        // In the middle of the search for the third.
        if steps == 2 {
            let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
            assert!(sent.success());
        }
    }
    let mut out = String::new();
    child.stdout.take().expect("a pipe").read_to_string(&mut out).expect("UTF-8");
    assert_eq!(child.wait().expect("an end").code(), Some(130), "{out}");
    assert!(out.contains("written: k.markers.yaml") && out.contains("written: curve.svg"), "{out}");
    let written = project.read("k.markers.yaml");
    assert!(steps >= 2 && written.matches("target: null").count() == steps, "{steps} steps, and {written}");

    let count = format!("key_points.max_count={}", steps + 1);
    let search = ["keypoints", "p.yaml", "--set", &count, "--set", "key_points.max_rounds=0"];
    let output = project.mimesh(&[&search[..], &["--resume"]].concat());
    assert_eq!(output.status, 0, "{}", output.stderr);
    let resumed = project.read("k.markers.yaml");
    assert_eq!(resumed.matches("target: null").count(), steps + 1);
    let output = project.mimesh(&[&search[..], &["--force"]].concat());
    assert_eq!(output.status, 0, "{}", output.stderr);
    assert_eq!(resumed, project.read("k.markers.yaml"), "as without interruption");
}

/// The JSON of `mimesh keypoints p.yaml` with these settings of `key_points`.
fn chosen(project: &Project, settings: &[&str]) -> serde_json::Value {
    let sets = settings.iter().flat_map(|setting| ["--set".to_owned(), format!("key_points.{setting}")]);
    let args: Vec<String> =
        ["keypoints", "p.yaml", "--force", "--json"].map(String::from).into_iter().chain(sets).collect();
    let output = project.mimesh(&args.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(output.status, 0, "{}", output.stderr);
    output.json()
}

#[test]
fn a_small_source_gives_the_candidates_that_it_has() {
    let project = project();
    let chosen = chosen(&project, &["sampler.count=100", "max_count=20"]);
    assert_eq!(chosen["points"].as_array().map(Vec::len), Some(8), "{chosen}");
    let warning = "the source offers only 8 of the 100 candidates that the sampler is to find, so these were used";
    assert_eq!(chosen["figures"]["warnings"][0], warning, "{chosen}");
}

#[test]
fn the_fast_search_comes_as_close_to_the_poses_as_the_exhaustive_one() {
    let project = Project::new();
    project.write(
        "p.yaml",
        "source: { generator: { type: quadruped, resolution: 20, frames: 3 } }\n\
         key_points: { type: greedy, threshold: 0, max_count: 8, sampler: { type: farthest_point, count: 24 } }\n\
         targets: { a: {}, b: {} }\n",
    );
    let error = |seed: u32, exhaustive: bool| {
        let settings = [format!("sampler.seed={seed}"), format!("exhaustive={exhaustive}")];
        let chosen = chosen(&project, &settings.each_ref().map(String::as_str));
        chosen["figures"]["error"].as_f64().expect("an error")
    };
    let ratios: Vec<f64> = (0..3).map(|seed| error(seed, false) / error(seed, true)).collect();
    // Either search ends where no exchange that it judges helps, and which such end it meets is luck: hence the mean.
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    assert!(mean < 1.02, "{ratios:?}");
}

#[test]
fn a_step_without_help_from_the_short_list_does_not_end_the_search() {
    let Some(body) = data("bodies-2k/source") else { return };
    let project = Project::new();
    let [rest, twist] = ["rest.obj", "twist.obj"].map(|name| body.join(name).display().to_string());
    project.write(
        "p.yaml",
        &format!(
            "source: {{ rest: {rest}, poses: {twist} }}\ntarget: {{ rest: {rest} }}\ntransfer: {{ type: biharmonic }}\n\
             key_points: {{ type: greedy, threshold: 0, max_count: 7, max_rounds: 0, sampler: {{ type: farthest_point, count: 60 }} }}\n\
             output: out/{{pose}}.obj\n"
        ),
    );
    let chosen = chosen(&project, &[]);
    let errors: Vec<f64> =
        chosen["steps"].as_array().expect("steps").iter().filter_map(|s| s["error"].as_f64()).collect();
    assert_eq!(errors.len(), 7, "{chosen}");
    // The fifth point is found outside the short list, and lowers the error.
    assert!(errors[4] < errors[3], "{errors:?}");
    assert_eq!(chosen["figures"]["ended_by"], "max_count", "{chosen}");
}

#[test]
fn nested_stages_are_checked_like_others() {
    let project = project();
    project.edit("type: biharmonic }", "type: biharmonic, weights: { type: bounded_biharmonc } }");
    project.edit(
        "type: greedy,",
        "type: greedy, deformer: { type: arap_skinning, lamda: 1 }, ranking: { type: harmonc },",
    );
    let output = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(output.status, 78);
    for expected in [
        "unknown key `lamda`",
        "did you mean `lambda`?",
        "unknown weights `harmonc`",
        "did you mean `harmonic`?",
        "unknown weights `bounded_biharmonc`",
        "did you mean `bounded_biharmonic`?",
    ] {
        assert!(output.stderr.contains(expected), "{expected} in {}", output.stderr);
    }
}

#[test]
fn a_correspondence_that_is_not_made_cannot_be_kept() {
    let project = project();
    project.edit("output:", "keep_correspondence: map.json\noutput:");
    let said = project.mimesh(&["check", "p.yaml"]);
    assert_eq!(said.status, 78, "{}", said.stderr);
    assert!(said.stderr.contains("p.yaml:6:1: `keep_correspondence` without `correspondence`"), "{}", said.stderr);
}

fn markers(vertices: &[u32]) -> Vec<Marker> {
    let point = SurfacePoint::Vertex;
    vertices.iter().map(|&v| Marker { name: v.to_string(), source: point(v), target: point(v) }).collect()
}

fn bent(surface: &Surface) -> Vec<Point3<f64>> {
    let turn = |p: &Point3<f64>| Rotation3::from_axis_angle(&Vector3::z_axis(), 0.4 * p.x) * p;
    surface.positions.iter().map(turn).collect()
}

fn moved(settings: serde_json::Value, source: &Surface, target: &Surface, pose: &[Point3<f64>]) -> Vec<Point3<f64>> {
    let stage: Box<dyn Transfer> = serde_json::from_value(settings).expect("settings");
    let markers = markers(&[0, 20, 45, 70, 90]);
    let pair = TransferPair { source, target, markers: &markers, proximity: None };
    let bound = stage
        .bind(BindInput { pair, map: None, poses: &[pose.to_vec()], work: Work::UNWATCHED })
        .expect("markers suffice");
    bound.transfer(pose).expect("a finite pose").positions
}

#[test]
fn a_target_that_is_turned_scaled_and_elsewhere_moves_the_same_way_in_its_own_frame() {
    let source = meshes::bar([9, 3, 2], [3.0, 0.9, 0.7]);
    let pose = bent(&source);
    let place = Similarity {
        scale: 40.0,
        rotation: Random::new(3).rotation().to_rotation_matrix().into_inner(),
        translation: Vector3::new(-500.0, 40.0, 70.0),
    };
    let target = Surface { positions: source.positions.iter().map(|p| place.apply(p)).collect(), ..source.clone() };
    for reconstruction in ["gradients", "blend"] {
        let settings =
            serde_json::json!({ "type": "biharmonic", "orientation": "fitted", "reconstruction": reconstruction });
        let here = moved(settings.clone(), &source, &source, &pose);
        let there = moved(settings, &source, &target, &pose);
        let off = here.iter().zip(&there).map(|(a, b)| (place.apply(a) - b).norm()).fold(0.0, f64::max);
        // Weights are found to a relative gap of 1e-6 in their energies, on either side.
        assert!(off < 1e-5 * target.diagonal(), "{reconstruction}: {off}");
    }
}

#[test]
fn a_target_like_the_source_takes_its_poses_whole() {
    let source = meshes::bar([9, 3, 2], [3.0, 0.9, 0.7]);
    let pose = bent(&source);
    let off = |settings: serde_json::Value| {
        let result = moved(settings, &source, &source, &pose);
        result.iter().zip(&pose).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max) / source.diagonal()
    };
    for reconstruction in ["gradients", "blend"] {
        let with = |residual: bool| {
            off(serde_json::json!({ "type": "biharmonic", "reconstruction": reconstruction, "residual": residual }))
        };
        // The closest point of a surface to its own vertex is found to rounding. Gradients of the pose are integrated to the pose.
        assert!(with(true) < 1e-10, "{reconstruction}: {}", with(true));
        assert!(with(false) > 1e-3, "{reconstruction}: five maps alone: {}", with(false));
    }
}

#[test]
fn limbs_turn_about_the_joints_of_the_target_and_not_of_the_source() {
    // Rigid but for a joint: the half beyond x = 0 turns about the origin. On the target the joint sits elsewhere.
    let source = meshes::bar([13, 3, 3], [3.0, 0.6, 0.6]);
    let fold = |p: &Point3<f64>, joint: f64| {
        let blend = ((p.x - joint) / 0.5 + 0.5).clamp(0.0, 1.0);
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.9 * blend);
        Point3::new(joint, 0.0, 0.0) + turn * (p - Point3::new(joint, 0.0, 0.0))
    };
    let pose: Vec<_> = source.positions.iter().map(|p| fold(p, 0.0)).collect();
    // The half before the joint is twice as long.
    let stretched = |p: &Point3<f64>| Point3::new(if p.x < 0.0 { 2.0 * p.x } else { p.x }, p.y, p.z);
    let target = Surface { positions: source.positions.iter().map(stretched).collect(), ..source.clone() };
    let truth: Vec<_> = target.positions.iter().map(|p| fold(p, 0.0)).collect();
    let error = |reconstruction: &str| {
        let settings = serde_json::json!({ "type": "biharmonic", "reconstruction": reconstruction });
        let result = moved(settings, &source, &target, &pose);
        let count = truth.len() as f64;
        let shift = result.iter().zip(&truth).map(|(a, b)| a - b).sum::<Vector3<f64>>() / count;
        result.iter().zip(&truth).map(|(a, b)| (a - b - shift).norm()).sum::<f64>() / count / target.diagonal()
    };
    let (gradients, blend) = (error("gradients"), error("blend"));
    assert!(gradients < 0.75 * blend, "{gradients} and {blend} of the diagonal");
}

#[test]
fn default_stages_are_linked() {
    let stage = instance::<dyn Transfer>("biharmonic").expect("bundled");
    let settings = serde_json::to_value(&*stage).expect("settings");
    assert_eq!(settings["weights"]["type"], "bounded_biharmonic");
    assert_eq!(settings["deformer"]["type"], "arap_skinning");
}
