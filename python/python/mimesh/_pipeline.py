"""Pipelines: what a YAML file declares."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from . import _mimesh
from ._document import CacheLike, Document, job, text_of
from ._errors import Diagnostic, Error, diagnostics_of
from ._progress import ProgressLike, reporter


class RunResult:
    """What the runs of a pipeline gave."""

    def __init__(self, told: dict[str, Any]) -> None:
        self.status: str = told["status"]
        """``done``, ``partly``, ``gate`` if a quality gate is broken, or ``failed``."""
        self.runs: list[dict[str, Any]] = told["runs"]
        """The runs by ``name``, each with its ``report``, or with ``diagnostics`` if it failed."""
        self.table: list[list[str]] = told["table"]
        """The table of all runs, its first row the names of the columns."""
        self.failed: list[Diagnostic] = diagnostics_of(told["failed_poses"])
        """Why poses are missing, if any is."""

    @property
    def reports(self) -> list[dict[str, Any]]:
        """The reports of the runs that gave results."""
        return [run["report"] for run in self.runs if "report" in run]

    @property
    def report(self) -> dict[str, Any]:
        """The report of the only run, as ``run.json`` has it."""
        reports = self.reports
        if len(reports) != 1:
            raise Error(f"the pipeline has {len(self.runs)} runs, of which {len(reports)} gave results: see `reports`")
        return reports[0]

    @property
    def verdict(self) -> str | None:
        """The verdict of the only run."""
        verdict: str | None = self.report.get("verdict")
        return verdict

    @property
    def outputs(self) -> list[Path]:
        """The files that were written."""
        return [Path(file["path"]) for report in self.reports for file in report.get("outputs", [])]

    def __repr__(self) -> str:
        return f"<mimesh.RunResult: {self.status}, {len(self.outputs)} files>"


class Pipeline:
    """A source with its poses, a target, and how the target takes the poses."""

    def __init__(self, file: str, text: str | None, meshes: Mapping[str, _mimesh.MeshData]) -> None:
        """Use `from_file`, `from_yaml` or `from_dict`."""
        self._file = file
        self._text = text
        self._meshes = list(meshes.items())

    @classmethod
    def from_file(cls, path: str | os.PathLike[str]) -> Pipeline:
        """The pipeline in a YAML file; its paths are relative to the file."""
        return cls(os.fspath(path), None, {})

    @classmethod
    def from_yaml(cls, source: str | os.PathLike[str]) -> Pipeline:
        """The pipeline of a YAML text, whose paths are relative to the current folder; or that in a file, if ``source`` is a path.

        A string of one line without a colon and blank is a path.
        """
        if isinstance(source, str) and ("\n" in source or ": " in source or source.lstrip().startswith("{")):
            return cls("pipeline", source, {})
        return cls.from_file(source)

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Pipeline:
        """The pipeline of a mapping with the keys of YAML.

        Stages may be objects, and ``rest`` of ``source`` and ``target`` a mesh of memory. Paths are relative to the current folder.
        """
        document = Document()
        return cls("pipeline", text_of(document.pipeline(values)), document.meshes)

    def check(
        self,
        *,
        set: Sequence[str] = (),
        out: str | os.PathLike[str] | None = None,
        roots: Sequence[str | os.PathLike[str]] = (),
    ) -> list[Diagnostic]:
        """All that can be found wrong without computing; an empty list for a pipeline that is ready to run."""
        asked = job(self._file, self._text, set=set, out=out, roots=roots)
        return diagnostics_of(_mimesh.check(asked, self._meshes))

    def plan(
        self,
        *,
        set: Sequence[str] = (),
        out: str | os.PathLike[str] | None = None,
        roots: Sequence[str | os.PathLike[str]] = (),
        cache: CacheLike = False,
    ) -> dict[str, Any]:
        """What would run and what is reused, and why; of several runs a mapping of their names to their plans."""
        asked = job(self._file, self._text, set=set, out=out, roots=roots, cache=cache)
        plans: list[dict[str, Any]] = json.loads(_mimesh.plan(asked, self._meshes))
        if len(plans) == 1:
            only: dict[str, Any] = plans[0]["plan"]
            return only
        return {plan["run"]: plan["plan"] for plan in plans}

    def run(
        self,
        *,
        progress: ProgressLike = None,
        threads: int | None = None,
        cache: CacheLike = False,
        set: Sequence[str] = (),
        out: str | os.PathLike[str] | None = None,
        roots: Sequence[str | os.PathLike[str]] = (),
        allow_commands: bool = False,
    ) -> RunResult:
        """Runs the pipeline and writes its results.

        Args:
            progress: A function that is called with a `Progress`, or ``True`` to print it.
            threads: Threads to use; results do not depend on their number. Left out, all.
            cache: Whether results of stages are cached: ``True`` for the user's own folder, or a folder.
            set: Values that replace those of the pipeline, e.g. ``["transfer.type=gradient"]``.
            out: The folder for all results, instead of those that the pipeline names.
            roots: Folders whose files meshes may open, beside their own and that of the pipeline.
            allow_commands: Whether stages may run programs that the pipeline names.

        Raises:
            mimesh.Error: If a single run fails; the failures of several are among the results.
        """
        asked = job(
            self._file,
            self._text,
            set=set,
            out=out,
            roots=roots,
            allow_commands=allow_commands,
            threads=threads,
            cache=cache,
        )
        return RunResult(json.loads(_mimesh.run(asked, self._meshes, reporter(progress))))

    def __repr__(self) -> str:
        return f"<mimesh.Pipeline: {self._file}>"
