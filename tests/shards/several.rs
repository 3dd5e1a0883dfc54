//! Several runs of one file, split over poses and runs.

use crate::{
    common::{Project, cube, with_targets},
    mimesh,
};

/// Two targets of one source, each with a file of all poses.
fn herd() -> Project {
    let project = Project::new();
    project.write("tall.obj", &cube(|[x, y, z]| [x, 5.0 * y, z]));
    let text = with_targets("targets: { wide: { rest: target.obj }, tall: { rest: tall.obj } }");
    project.write(
        "p.yaml",
        &text.replace(
            "output: out/{target}/{pose}.obj",
            "output: [ 'out/{target}/{pose}.obj', 'out/{target}/all.glb' ]",
        ),
    );
    project
}

#[test]
fn a_shard_is_one_of_each_run_and_a_merge_writes_all() {
    let (whole, split) = (herd(), herd());
    mimesh(&whole, "run", &[], 0);
    mimesh(&split, "run", &["--shard", "1/2"], 0);
    for target in ["wide", "tall"] {
        assert_eq!(split.names(&format!("out/{target}")), ["10.obj"]);
    }
    let refused = mimesh(&split, "merge", &[], 75);
    for target in ["wide", "tall"] {
        let expected = format!(
            "error: p.yaml: {target}: 2 of 3 poses not computed: 0-1\n  hint: compute them first: \
             `mimesh run p.yaml --run {target} --frames 0-1`\n"
        );
        assert!(refused.stderr.contains(&expected), "{}", refused.stderr);
    }
    mimesh(&split, "run", &["--shard", "0/2"], 0);
    let merged = mimesh(&split, "merge", &[], 0);
    assert!(merged.stdout.contains("2 runs done in "), "{}", merged.stdout);
    for file in ["wide/1.obj", "wide/10.obj", "wide/all.glb", "tall/2.obj", "tall/all.glb"] {
        let name = format!("out/{file}");
        assert!(split.bytes(&name) == whole.bytes(&name), "{name}");
    }
}

#[test]
fn one_of_several_runs_is_taken_by_its_name() {
    let (whole, split) = (herd(), herd());
    mimesh(&whole, "run", &[], 0);
    mimesh(&split, "prepare", &["--run", "tall"], 0);
    for frame in ["0", "1", "2"] {
        mimesh(&split, "run", &["--run", "tall", "--frames", frame], 0);
    }
    // The other run is missing, and not asked for.
    mimesh(&split, "merge", &[], 75);
    let report = mimesh(&split, "merge", &["--run", "tall", "--json"], 0).json();
    assert_eq!(report["run"]["name"], "tall");
    assert!(!split.has("out/wide"));
    for file in ["1.obj", "2.obj", "10.obj", "all.glb"] {
        let name = format!("out/tall/{file}");
        assert!(split.bytes(&name) == whole.bytes(&name), "{name}");
    }
    let plan = mimesh(&split, "plan", &["--run", "tall", "--run", "wide", "--json"], 0).json();
    assert_eq!(plan.as_array().map(Vec::len), Some(2));
}

#[test]
fn names_of_files_do_not_depend_on_which_runs_are_asked_for() {
    let project = herd();
    let text = project.read("p.yaml").replace("out/{target}/", "out/{target}-");
    project.write("p.yaml", &text);
    mimesh(&project, "run", &["--run", "tall"], 0);
    let names = ["run-tall.json", "tall-1.obj", "tall-10.obj", "tall-2.obj", "tall-all.glb"];
    assert_eq!(project.names("out"), names, "both runs report into one folder");
    let elsewhere = mimesh(&project, "run", &["--run", "tall", "--out", "other", "--json"], 0).json();
    assert_eq!(elsewhere["place"], "other/tall/run.json");
}

#[test]
fn an_unknown_run_lists_those_that_are_there() {
    let project = herd();
    for command in ["run", "plan", "prepare", "merge"] {
        let refused = mimesh(&project, command, &["--run", "tal"], 2);
        let expected = "error: there is no run `tal`, but `wide`, `tall`\n  hint: did you mean `tall`?\n";
        assert_eq!(refused.stderr, expected, "{command}");
    }
    let single = mimesh(&Project::new(), "run", &["--run", "tall"], 2);
    assert!(single.stderr.contains("the pipeline declares one, without a name"), "{}", single.stderr);
}
