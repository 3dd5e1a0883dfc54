"""The stages of the kind ``metric`` that are a part of mimesh."""

from ._registry import install

install(globals(), "metric")
