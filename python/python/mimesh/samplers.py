"""The stages of the kind ``sampler`` that are a part of mimesh."""

from ._registry import install

install(globals(), "sampler")
