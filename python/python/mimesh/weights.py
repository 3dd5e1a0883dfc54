"""The stages of the kind ``weights`` that are a part of mimesh."""

from ._registry import install

install(globals(), "weights")
