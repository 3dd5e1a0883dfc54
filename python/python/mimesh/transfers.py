"""The stages of the kind ``transfer`` that are a part of mimesh."""

from ._registry import install

install(globals(), "transfer")
