"""The stages of the kind ``deformer`` that are a part of mimesh."""

from ._registry import install

install(globals(), "deformer")
