//! Disks that are full, and folders that are closed.

use std::{
    ffi::OsStr,
    fs,
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
    process::Command,
};

use crate::{
    common::{Output, Project},
    sets::{assert_report_is_of, assert_same, old_and_new, project, run, set},
};

/// Runs a command of `sh` that ends in `mimesh run`.
fn by_shell(project: &Project, before: &str) -> Output {
    let mimesh = project.command(&["run", "p.yaml", "--no-cache", "--quiet"]);
    let words: Vec<&OsStr> = std::iter::once(mimesh.get_program()).chain(mimesh.get_args()).collect();
    let mut command = Command::new("sh");
    command.arg("-c").arg(format!("{before} exec \"$@\"")).arg("sh").args(words).current_dir(project.path("."));
    mimesh.get_envs().for_each(|(name, value)| _ = command.env(name, value.unwrap_or_default()));
    let output = command.output().expect("sh runs");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
    Output { status: output.status.code().unwrap_or(-1), stdout: text(output.stdout), stderr: text(output.stderr) }
}

#[test]
fn a_disk_that_takes_no_more_leaves_the_old_results_and_nothing_else() {
    let project = project();
    let (old, _) = old_and_new(&project);
    // The largest file that may be written has a block of 512 bytes: the file of all poses, or an OBJ, is longer. The limit has a
    // signal, which ends a program unless it is ignored.
    for before in ["trap '' XFSZ; ulimit -f 1;", "ulimit -f 1;"] {
        let output = by_shell(&project, before);
        assert_eq!(output.status, 73, "{before} {}", output.stderr);
        assert!(
            output.stderr.contains("cannot write") || output.stderr.contains("File too large"),
            "{}",
            output.stderr
        );
        assert_same(&set(&project), &old, "afterwards");
    }
}

/// A small file system in memory, until it is dropped.
struct SmallDisk(PathBuf);

impl SmallDisk {
    /// Takes the place of `folder`; only the superuser can do that.
    fn mounted(folder: PathBuf, kilobytes: usize) -> Self {
        let _ = fs::create_dir(&folder);
        let size = format!("size={kilobytes}k");
        mount("mount", &["-t", "tmpfs", "-o", &size, "tmpfs"], &folder);
        Self(folder)
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        mount("umount", &[], &self.0);
    }
}

fn mount(program: &str, options: &[&str], folder: &Path) {
    let done = Command::new(program).args(options).arg(folder).status();
    assert!(done.is_ok_and(|status| status.success()), "{program} {}", folder.display());
}

/// Runs on disks of more and more room, from one that just holds the old results to one on which the new ones fit beside them.
#[test]
#[ignore = "needs the superuser; .ci/long runs it"]
fn a_disk_that_fills_up_at_any_moment_leaves_the_old_results_or_has_the_new_ones() {
    let project = project();
    let (old, new) = old_and_new(&project);
    let report = project.bytes("out/run.json");
    let in_out = |set: &crate::sets::Set| set.iter().filter(|(name, _)| name.starts_with("out/")).count();
    let (mut full, mut fit) = (0, 0);
    // Each file takes whole pages.
    let pages: usize = old.values().map(|bytes| bytes.len().div_ceil(4096)).sum::<usize>() + 8;
    for kilobytes in (2 * pages..12 * pages).step_by(4) {
        let _ = fs::remove_dir_all(project.path("out"));
        let disk = SmallDisk::mounted(project.path("out"), kilobytes);
        let put = |(name, bytes): (&String, &Vec<u8>)| fs::write(project.path(name), bytes).is_ok();
        let holds_old = old.iter().all(put) && fs::write(project.path("out/run.json"), &report).is_ok();
        if holds_old {
            let output = project.mimesh(&["run", "p.yaml", "--no-cache", "--quiet"]);
            let found = set(&project);
            match output.status {
                0 => {
                    assert_same(&found, &new, &format!("{kilobytes} kB"));
                    assert_report_is_of(&project, &new);
                    fit += 1;
                }
                73 => {
                    assert!(output.stderr.contains("the disk is full"), "{}", output.stderr);
                    assert_same(&found, &old, &format!("{kilobytes} kB: {}", output.stderr));
                    assert_eq!(project.bytes("out/run.json"), report);
                    full += 1;
                }
                other => panic!("status {other} with {kilobytes} kB: {}", output.stderr),
            }
            assert_eq!(project.names("out").len(), in_out(&old) + 1, "{:?}", project.names("out"));
        }
        drop(disk);
    }
    println!("{full} disks were full, {fit} held both sets");
    assert!(full > 4 && fit > 4, "{full} disks were full, {fit} were not");
    run(&project);
}

#[test]
fn a_closed_folder_is_refused_before_anything_is_computed() {
    let project = project();
    let (old, new) = old_and_new(&project);
    fs::set_permissions(project.path("more"), fs::Permissions::from_mode(0o555)).expect("a folder");
    // Nobody closes a folder to the superuser.
    let closed = fs::write(project.path("more/try"), "").is_err();
    let output = project.mimesh(&["run", "p.yaml", "--no-cache", "--quiet"]);
    fs::set_permissions(project.path("more"), fs::Permissions::from_mode(0o755)).expect("a folder");
    let _ = fs::remove_file(project.path("more/try"));
    if closed {
        assert_eq!(output.status, 73, "{}", output.stderr);
        assert!(output.stderr.contains("no permission to make files in"), "{}", output.stderr);
        assert_same(&set(&project), &old, "afterwards");
    } else {
        assert_eq!(set(&project).len(), new.len());
    }
}
