"""The stages of the kind ``clusterer`` that are a part of mimesh."""

from ._registry import install

install(globals(), "clusterer")
