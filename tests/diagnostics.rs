//! Forty errors that people make in pipelines and in files of markers, all reported by one `mimesh check`.
#![cfg(feature = "bundled")]

mod common;

use common::Project;

/// Files of markers, each with an error of its own.
const FILES: [(&str, &str); 15] = [
    ("broken.pp", "<PickedPoints>\n <point name=\"a\" x=\"0\" y=\"0\" z=\"0\">\n</PickedPoints>\n"),
    ("count.cons", "5\n0, 0\n1, 1\n2, 2\n"),
    ("far.csv", "name,x,y,z\na,0,0,0\nb,1,0,0\nc,500,500,500\nd,0,2,0\n"),
    ("few.cons", "1\n0, 0\n"),
    ("from-one.cons", "4\n1, 1\n4, 4\n6, 6\n8, 8\n"),
    ("letters.cons", "2\n0, 0\none, 1\n"),
    ("nan.obj", "v 0 0 0\nv 1 0 nan\nv 0 1 0\nf 1 2 3\n"),
    ("ok.csv", "name,x,y,z\na,0,0,0\nb,2,0,0\nc,0,4,0\nd,0,0,6\n"),
    ("one-sided.cons", "3\n0, 0\n1\n2, 2\n"),
    (
        "own.markers.yaml",
        "source: { mesh: rest.obj, vertices: 8 }\ntarget: { mesh: target.obj, vertices: 8 }\nmarkers:\n  - { name: a, source: 0, target: 0 }\n  - { name: a, source: 1, target: 1 }\n  - { name: c, source: 2 }\n  - { name: d, sorce: 3, target: 3 }\n",
    ),
    ("points.csv", "name,x,y,z\na,0,0,0\nb,1,0\n"),
    (
        "points.pp",
        "<!DOCTYPE PickedPoints>\n<PickedPoints>\n <point name=\"a\" x=\"0\" y=\"0\" z=\"0\" active=\"1\"/>\n <point name=\"b\" x=\"1\" y=\"two\" z=\"0\" active=\"1\"/>\n</PickedPoints>\n",
    ),
    ("range.cons", "2\n0, 0\n7, 8\n"),
    ("twice.cons", "3\n0, 0\n1, 1\n1, 2\n"),
    ("wrap.json", "[[0, 0.2, 0.3], [99, 0.1, 0.1], [1, 0.9, 0.9]]"),
];

const PIPELINE: &str = r#"source: { rest: rest.obj, poses: [pose-1.obj, pose-1.obj, posé-*.obj] }
targets:
  a: { rest: target.obj, markers: one-sided.cons }
  b: { rest: target.obj, markers: count.cons }
  c: { rest: target.obj, markers: letters.cons }
  d: { rest: target.obj, markers: range.cons }
  e: { rest: target.obj, markers: twice.cons }
  f: { rest: target.obj, markers: from-one.cons }
  g: { rest: target.obj, markers: few.cons }
  h: { rest: target.obj, markers: { source: points.pp, target: ok.csv } }
  i: { rest: target.obj, markers: { source: broken.pp, target: ok.csv } }
  j: { rest: target.obj, markers: { source: wrap.json, target: ok.csv } }
  k: { rest: target.obj, markers: { source: points.csv, target: ok.csv } }
  l: { rest: target.obj, markers: { source: far.csv, target: ok.csv } }
  m: { rest: target.obj, markers: own.markers.yaml }
  n: { rest: target.obj, markers: { source: ok.csv } }
  o: { rest: target.obj, markers: pairs.txt }
  p: { rest: target.obj, markers: missing.cons }
  q: { rest: nan.obj }
  r: { rest: target.fbx }
  s: { rest: target.obj, correspondence: { type: identiti } }
  t: { rest: target.obj, correspondence: { type: nonrigid_fit, stiffness: soft } }
  u: { rest: target.obj, transfer: { type: gradient, tolerance: -1 } }
  v: { rest: target.obj, transfer: { type: gradient, smoothing: 1 } }
  w: { rest: target.obj, transfer: { type: multi_component, initial: { type: biharmonc } } }
  x: { rest: target.obj, gates: { point_eror: 2.0, volume: -1 } }
  y: { rest: target.obj, metrics: [{ type: point_error }] }
  z: { rest: target.obj, truth: "truth-{name}-{poze}.obj" }
variables: { detail: 1, unused: 2 }
matrix: { transfer.reweightings: [1, two], transfer.wieght: [1] }
correspondence: { type: nonrigid_fit }
transfer: { type: gradient }
formats: [{ type: glb, frames_per_second: 0 }, { type: glb }]
output: ["out/{name}/{pose}.obj", "out/{name}/all.obj", "out/{nam}/{pose}.ply", rest.obj]
ouput: x
"#;

/// The first line of each error; lines of the file and hints follow it.
const EXPECTED: [&str; 41] = [
    "p.yaml:1:59: no file matches `posé-*.obj`",
    "p.yaml:9:35: nonrigid_fit needs at least 3 markers, there are 1",
    "p.yaml:16:35: missing key `target`",
    "p.yaml:17:35: no such file: pairs.txt",
    "p.yaml:18:35: no such file: missing.cons",
    "p.yaml:20:14: no such file: target.fbx",
    "p.yaml:21:50: unknown correspondence `identiti`",
    "p.yaml:22:64: unknown key `stiffness`",
    "p.yaml:23:65: `tolerance`: expected at least 0.000001, found -1",
    "p.yaml:24:54: unknown key `smoothing`",
    "p.yaml:25:78: unknown transfer `biharmonc`",
    "p.yaml:26:35: unknown gate `point_eror`",
    "p.yaml:26:60: `volume`: expected a number of at least 0, found -1",
    "p.yaml:27:36: the metric `point_error` without `truth`",
    "p.yaml:28:33: unknown placeholder `{poze}`",
    "p.yaml:30:11: unknown key `reweightings` (of `w`)",
    "p.yaml:30:38: `reweightings`: expected a whole number, 0 or more, found the string \"two\" (of `a-reweightings=two,wieght=1`, `b-reweightings=two,wieght=1`, `c-reweightings=two,wieght=1` and 22 more)",
    "p.yaml:30:44: unknown key `wieght`",
    "p.yaml:33:43: `frames_per_second`: expected 0.001 to 1000000, found 0",
    "p.yaml:33:56: a second entry for this format",
    "p.yaml:34:35: a .obj file holds one pose, so its name needs `{pose}`",
    "p.yaml:34:57: there are several targets and combinations, so the name of what is written needs `{name}`",
    "p.yaml:34:57: unknown placeholder `{nam}`",
    "p.yaml:34:81: there are several targets and combinations, so the name of what is written needs `{name}`",
    "p.yaml:34:81: a .obj file holds one pose, so its name needs `{pose}`",
    "p.yaml:35:1: unknown key `ouput`",
    "one-sided.cons:3: expected `source, target`, found `1`",
    "count.cons:1: the first line counts 5 pairs, found 3",
    "letters.cons:3: expected `source, target`, found `one, 1`",
    "range.cons:3: marker 2: the target has no vertex 8: expected 0 to 7",
    "twice.cons:4: marker 3 lies on the same point of the source as marker 2 (line 3)",
    "from-one.cons:5: marker 4: the source has no vertex 8: expected 0 to 7; none of them is vertex 0, so the numbers of the source seem to count from 1",
    "from-one.cons:5: marker 4: the target has no vertex 8: expected 0 to 7; none of them is vertex 0, so the numbers of the target seem to count from 1",
    "points.pp:4: `y`: expected a number, found `two`",
    "broken.pp:3: not valid XML: expected `</point>`, found `</PickedPoints>`",
    "wrap.json:1: expected `[triangle, u, v]` with u and v from 0 to 1 and a sum of 1 at most, found `[1, 0.9, 0.9]`",
    "points.csv:3: expected 4 values, found 3: `b, 1, 0`",
    "far.csv:4: point c lies 23053 % of the diagonal off the source: expected 5 % at most; the points span x 0 to 500, y 0 to 500, z 0 to 500, the source x 0 to 1, y 0 to 2, z 0 to 3",
    "own.markers.yaml:7:16: unknown key `sorce`",
    "own.markers.yaml:5:5: another marker is called a (line 4)",
    "nan.obj:2: vertex 2 has coordinate `nan`: expected a finite number",
];

#[test]
fn forty_errors_are_reported_together_each_at_its_location() {
    let project = Project::new();
    FILES.iter().for_each(|(name, text)| project.write(name, text));
    project.write("p.yaml", PIPELINE);
    let output = project.mimesh(&["check", "p.yaml"]);
    let found: Vec<_> = output.stderr.lines().filter_map(|line| line.strip_prefix("error: ")).collect();
    assert_eq!(found, EXPECTED);
    assert!(output.stderr.ends_with(&format!("\n{} mistakes\n", EXPECTED.len())), "{}", output.stderr);
    assert_eq!((output.status, output.stdout.as_str()), (78, ""));
    let json = project.mimesh(&["check", "p.yaml", "--json"]);
    assert_eq!(json.status, 78);
    assert_eq!(json.stdout.matches("\"message\"").count(), EXPECTED.len(), "{}", json.stdout);
    assert!(!project.has("out"), "something was written");
}

#[test]
fn a_run_reports_the_same_as_check_and_writes_nothing() {
    let project = Project::new();
    FILES.iter().for_each(|(name, text)| project.write(name, text));
    project.write("p.yaml", PIPELINE);
    let [check, run] = ["check", "run"].map(|command| project.mimesh(&[command, "p.yaml"]));
    assert_eq!((check.stderr, check.status), (run.stderr, run.status));
    assert!(!project.has("out"), "something was written");
}
