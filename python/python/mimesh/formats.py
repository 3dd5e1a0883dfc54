"""The stages of the kind ``format`` that are a part of mimesh."""

from ._registry import install

install(globals(), "format")
