"""The stages of the kind ``correspondence`` that are a part of mimesh."""

from ._registry import install

install(globals(), "correspondence")
