"""The stages of the kind ``proximity`` that are a part of mimesh."""

from ._registry import install

install(globals(), "proximity")
