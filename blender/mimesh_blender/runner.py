"""A job beside the window: it reads in slices, computes in a thread, and can be stopped at any time."""

from __future__ import annotations

import threading
import time

from .job import Job, Step
from .messages import Cancelled

# How long frames are read at a time, in seconds.
_SLICE = 0.08

# What the panel shows while a transfer runs.
running: Step | None = None


class Runner:
    """Runs a job up to what is left to be written."""

    def __init__(self, job: Job) -> None:
        global running
        self.job = job
        self._reading = job.read()
        self._thread: threading.Thread | None = None
        self._error: BaseException | None = None
        self._stop = threading.Event()
        running = Step("Reading", 0.0)

    def advance(self) -> bool:
        """Goes on for a moment; whether the results are there. Raises what went wrong."""
        global running
        if self._thread is None:
            end = time.monotonic() + _SLICE
            while time.monotonic() < end:
                step = next(self._reading, None)
                if step is None:
                    self._thread = threading.Thread(target=self._compute, name="mimesh", daemon=True)
                    self._thread.start()
                    break
                running = step
            return False
        if self._thread.is_alive():
            return False
        if self._error is not None:
            raise self._error
        return True

    def stop(self) -> None:
        """Ends the job. A thread under way ends at its next report, and its result is dropped."""
        global running
        self._stop.set()
        running = None
        try:
            self._reading.close()
        except ReferenceError:
            # Another file was loaded, and there is nothing left to be brought back.
            pass

    def _compute(self) -> None:
        def report(step: Step) -> None:
            global running
            if self._stop.is_set():
                raise Cancelled
            running = step

        try:
            self.job.compute(report)
        except BaseException as error:
            self._error = error
