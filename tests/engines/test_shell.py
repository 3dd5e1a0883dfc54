"""The script of a shell, by itself."""

import subprocess

from conftest import CHUNK, FRAMES, TARGETS, Project

TASKS = len(TARGETS) * -(-FRAMES // CHUNK)


def submitted(project: Project) -> list[str]:
    project.mimesh("submit", "--to", "shell", "herd.yaml", "--chunk", str(CHUNK), "--threads", "1")
    return ["bash", "herd-job/job.sh"]


def test_all_tasks_give_the_bytes_of_a_whole_run(project: Project, expected: dict[str, bytes]) -> None:
    script = submitted(project)
    count = subprocess.run([*script, "count"], cwd=project.folder, capture_output=True, text=True, check=True).stdout
    assert count.split() == [str(len(TARGETS)), str(TASKS)]
    subprocess.run([*script, "all", "2"], cwd=project.folder, check=True)
    assert project.results() == expected
    project.nothing_ran()


def test_merge_says_what_is_missing(project: Project, expected: dict[str, bytes]) -> None:
    script = submitted(project)
    subprocess.run([*script, "prepare", "0"], cwd=project.folder, check=True)
    for task in (2, 0):
        subprocess.run([*script, "transfer", str(task)], cwd=project.folder, check=True)
    merge = project.mimesh("merge", "herd.yaml", "--run=camel", "--cache", "herd-job/cache", status=75)
    assert "5-9" in merge.stderr
    subprocess.run([*script, "transfer", "1"], cwd=project.folder, check=True)
    subprocess.run([*script, "merge", "0"], cwd=project.folder, check=True)
    of_camel = {name: data for name, data in expected.items() if name.startswith("out/camel/")}
    assert project.results() == of_camel


def test_the_script_has_no_faults_of_shells(project: Project) -> None:
    submitted(project)
    subprocess.run(["shellcheck", "--severity=style", project.folder / "herd-job/job.sh"], check=True)
    wrong = subprocess.run(["bash", "herd-job/job.sh", "transfer", str(TASKS)], cwd=project.folder, capture_output=True, text=True)
    assert wrong.returncode == 2 and "there is no task" in wrong.stderr
