"""The stages of the kind ``key_points`` that are a part of mimesh."""

from ._registry import install

install(globals(), "key_points")
