"""Transfers shape keys and animation from one mesh to another.

The work is done by the Python package `mimesh`, which comes with the extension as a wheel.
"""

from . import operators, panel, properties

_MODULES = (properties, operators, panel)


def register() -> None:
    for module in _MODULES:
        module.register()


def unregister() -> None:
    for module in reversed(_MODULES):
        module.unregister()
