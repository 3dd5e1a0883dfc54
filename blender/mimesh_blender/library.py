"""The package `mimesh`, which does the work."""

from __future__ import annotations

import importlib
from typing import Any

from .messages import Refusal


def load() -> Any:
    """The package; it is loaded when it is first needed, so that a wheel for another system stops nobody at the start."""
    try:
        return importlib.import_module("mimesh")
    except ImportError as error:
        hint = "Install the extension for this system; its README names the systems"
        raise Refusal(f"the library of mimesh cannot be loaded: {error}", hint) from error
