"""The stages of the kind ``generator`` that are a part of mimesh."""

from ._registry import install

install(globals(), "generator")
