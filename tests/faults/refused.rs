//! System calls that fail once, each in its turn: the quota is used up, the disk is broken, the file system became read-only.

use std::fs;

use crate::{
    calls::traced,
    sets::{assert_report_is_of, assert_same, old_and_new, project, put_back, results, run, set},
};

/// The calls by which results are written and moved.
const CALLS: [&str; 8] = ["write", "rename", "link", "linkat", "unlink", "fsync", "fdatasync", "flock"];

#[test]
#[ignore = "takes minutes and needs strace; .ci/long runs it"]
fn a_system_call_that_is_refused_leaves_the_old_results_or_has_the_new_ones() {
    let project = project();
    let sets = old_and_new(&project);
    let report = "out/run.json";
    let (mut refused, mut done) = (0, 0);
    for (call, error) in CALLS.iter().flat_map(|call| ["EDQUOT", "EIO", "EROFS"].map(|error| (call, error))) {
        for number in 1.. {
            put_back(&project, &sets.0);
            let report_before = project.bytes(report);
            let inject = format!("inject={call}:error={error}:when={number}");
            let output = traced(&project, &["-e", &format!("trace={call}"), "-e", &inject])
                .output()
                .expect("strace is installed");
            let trace = fs::read_to_string(project.path("trace.txt")).expect("a trace");
            if !trace.contains("(INJECTED)") {
                break;
            }
            let when = format!("{call} {number} with {error}");
            // Each thread counts its own calls, so that the message may be refused too.
            let is_told = !trace.lines().any(|line| line.contains("write(2, ") && line.contains("(INJECTED)"));
            let said = String::from_utf8(output.stderr).expect("text");
            let found = results(&set(&project));
            match output.status.code() {
                // What a run can do without, such as removing what it kept, it does without.
                Some(0) => {
                    assert_same(&found, &sets.1, &when);
                    assert_report_is_of(&project, &sets.1);
                    done += 1;
                }
                Some(73) => {
                    assert!(said.starts_with("error: ") || !is_told, "{when}: {said}");
                    if found == sets.0 {
                        assert_eq!(project.bytes(report), report_before, "{when}");
                    } else if is_told {
                        // What could not be put back is named, and the next run ends it.
                        assert!(
                            said.contains("put back") || said.contains("so the files are of two runs"),
                            "{when}: {said}"
                        );
                    }
                    refused += 1;
                }
                status => panic!("{when}: status {status:?}: {said}"),
            }
            run(&project);
            assert_same(&set(&project), &sets.1, &format!("{when}: the next run"));
        }
    }
    println!("{refused} runs were refused, {done} ended well");
    assert!(refused > 100, "only {refused} runs were refused");
}
