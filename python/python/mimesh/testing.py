"""For tests of stages that are written in Python."""

from __future__ import annotations

import json
from typing import Any

from . import _mimesh
from ._document import Document
from ._stages import Stage


def check_contract(stage: type[Stage] | Stage) -> None:
    """Holds a stage, or a class with its defaults, to the contract of its kind: the same that mimesh's own stages are held to.

    Raises:
        AssertionError: With what the stage breaks.
    """
    settings: dict[str, Any] = {"type": stage.type} if isinstance(stage, type) else stage.to_dict()
    _mimesh.check_contract(stage.kind, stage.type, json.dumps(Document().value(settings)))
