//! `mimesh plan --shards`: what each shard has to do.

use serde_json::Value;

use crate::{FRAMES, GALLOP, mimesh, project};

fn shards(plan: &Value) -> Vec<(String, u64, u64)> {
    let one = |shard: &Value| {
        let number = |key: &str| shard[key].as_u64().expect("a number");
        (shard["frames"].as_str().expect("frames").to_owned(), number("poses"), number("cached"))
    };
    plan["shards"].as_array().expect("shards").iter().map(one).collect()
}

#[test]
fn a_plan_has_the_poses_of_each_shard_and_how_many_are_cached() {
    let project = project(GALLOP);
    let plan = mimesh(&project, "plan", &["--shards", "5", "--json"], 0).json();
    let frames = ["0-2", "3-5", "6-7", "8-9", "10-11"];
    let expected: Vec<_> =
        frames.iter().zip([3, 3, 2, 2, 2]).map(|(frames, poses)| (frames.to_string(), poses, 0)).collect();
    assert_eq!(shards(&plan), expected);
    assert!(plan["steps"].is_array(), "beside the plan of the whole");
    for shard in plan["shards"].as_array().expect("shards") {
        assert!(shard.get("seconds").is_none() && shard.get("memory_bytes").is_none(), "nothing is known yet: {shard}");
    }
    mimesh(&project, "run", &["--frames", "1-3"], 0);
    let plan = mimesh(&project, "plan", &["--shards", "5", "--json"], 0).json();
    assert_eq!(shards(&plan).iter().map(|shard| shard.2).collect::<Vec<_>>(), [2, 1, 0, 0, 0]);
    let seconds = |shard: usize| plan["shards"][shard]["seconds"].as_f64().expect("an estimate");
    assert!(seconds(0) < seconds(1) && seconds(3) > 0.0, "one pose is left, or two, or all: {plan}");
    if cfg!(target_os = "linux") {
        assert!(plan["shards"][4]["memory_bytes"].as_u64().expect("an estimate") > 1 << 20);
    }
    let text = mimesh(&project, "plan", &["--shards", "5"], 0).stdout;
    assert!(text.contains("shards\n") && text.contains("10-11"), "{text}");
    mimesh(&project, "run", &["--shard", "0/1"], 0);
    let done = mimesh(&project, "plan", &["--shards", "1", "--json"], 0).json();
    assert_eq!(shards(&done), [("0-11".to_owned(), FRAMES as u64, FRAMES as u64)]);
    assert!(done["shards"][0].get("seconds").is_none(), "nothing is left to do");
}

#[test]
fn shards_without_poses_are_shown_and_none_at_all_is_refused() {
    let project = crate::common::Project::new();
    let plan = mimesh(&project, "plan", &["--shards", "5", "--json"], 0).json();
    let poses: Vec<_> = shards(&plan).iter().map(|shard| shard.1).collect();
    assert_eq!(poses, [1, 1, 1, 0, 0]);
    assert_eq!(plan["shards"][4]["shard"], "4/5");
    mimesh(&project, "plan", &["--shards", "0"], 2);
    assert!(mimesh(&project, "plan", &["--json"], 0).json().get("shards").is_none());
}
