"""The stages of the kind ``landmarks`` that are a part of mimesh."""

from ._registry import install

install(globals(), "landmarks")
