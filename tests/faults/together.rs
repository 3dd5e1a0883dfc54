//! Two runs at once.

use std::process::{Child, Command, Stdio};

use crate::{
    common::Project,
    sets::{assert_report_is_of, lean, old_and_new, project, set},
};

/// Starts a run of `p.yaml` with the poses of `folder`, by `launcher` if there is one.
fn start(project: &Project, launcher: &[&str], folder: &str) -> Child {
    let poses = format!("source.poses={folder}/pose-*.obj");
    let mimesh = project.command(&["run", "p.yaml", "--no-cache", "--quiet", "--set", &poses]);
    let mut command = match launcher {
        [] => mimesh,
        [program, options @ ..] => {
            let mut command = Command::new(program);
            command.args(options).arg(mimesh.get_program()).args(mimesh.get_args()).current_dir(project.path("."));
            mimesh.get_envs().for_each(|(name, value)| _ = command.env(name, value.unwrap_or_default()));
            command
        }
    };
    command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("the command runs")
}

/// Runs twice at once, `times` times; one makes the old set, and one the new one.
fn both_at_once(launcher: &[&str], times: usize) {
    let project = project();
    let (old, new) = old_and_new(&project);
    let mut refused = 0;
    for (folder, by) in [("older", 0.1), ("newer", 0.5)] {
        lean(&project, by);
        for pose in project.names(".").into_iter().filter(|name| name.starts_with("pose-")) {
            project.write(&format!("{folder}/{pose}"), &project.read(&pose));
        }
    }
    for _ in 0..times {
        let both = ["older", "newer"].map(|folder| start(&project, launcher, folder));
        let statuses = both.map(|child| {
            let output = child.wait_with_output().expect("an end");
            let told = String::from_utf8_lossy(&output.stderr).into_owned();
            let status = output.status.code().expect("a status");
            assert!(status == 0 || (status == 75 && told.contains("another process is writing this file")), "{told}");
            status
        });
        refused += statuses.iter().filter(|status| **status == 75).count();
        assert!(statuses.contains(&0), "{statuses:?}");
        let found = set(&project);
        assert_report_is_of(&project, &found);
        assert!(found == old || found == new, "{:?}", found.keys());
    }
    println!("{refused} runs were refused");
}

#[test]
fn of_two_runs_at_once_one_writes_all_or_the_other() {
    both_at_once(&[], 6);
}

/// Both processes have the number 1, as in two containers on one volume.
#[test]
#[ignore = "needs the superuser; .ci/long runs it"]
fn of_two_runs_in_containers_of_their_own_one_writes_all_or_the_other() {
    both_at_once(&["unshare", "--pid", "--fork"], 30);
}
