"""How meshes and results look in a notebook."""

from __future__ import annotations

import base64
import html
import struct
import zlib
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _mimesh

if TYPE_CHECKING:
    from ._mesh import Mesh

MAX_FRAMES = 24
"""Poses that an animation shows at most."""


def pictures(mesh: Mesh, poses: Sequence[Any], view: str, up: str, size: int) -> list[bytes]:
    """A PNG of each pose, all seen from one place at one scale."""
    shown = [np.ascontiguousarray(pose, dtype=np.float64) for pose in poses]
    return _mimesh.draw(mesh._data, shown, view, up, size)


def animation(mesh: Mesh, poses: Sequence[Any], frames_per_second: float, view: str, up: str, size: int) -> bytes:
    """A PNG that plays the poses over and over; browsers and notebooks show it as any picture."""
    return animated(pictures(mesh, poses, view, up, size), frames_per_second)


def evenly_spaced(count: int) -> list[int]:
    """The numbers of at most `MAX_FRAMES` of so many poses."""
    step = max(1, -(-count // MAX_FRAMES))
    return list(range(0, count, step))


def as_html(picture: bytes, words: str) -> str:
    """A picture with a line below it."""
    data = base64.b64encode(picture).decode()
    return f'<figure style="margin:0"><img src="data:image/png;base64,{data}" alt="{html.escape(words)}"><figcaption>{html.escape(words)}</figcaption></figure>'


def animated(frames: Sequence[bytes], frames_per_second: float) -> bytes:
    """One animated PNG of PNGs of equal size and colours (https://wiki.mozilla.org/APNG_Specification)."""
    first = list(_chunks(frames[0]))
    header = first[0][1]
    width, height = struct.unpack(">II", header[:8])
    made = [b"\x89PNG\r\n\x1a\n", _chunk(b"IHDR", header), _chunk(b"acTL", struct.pack(">II", len(frames), 0))]
    made += [_chunk(kind, body) for kind, body in first if kind in (b"PLTE", b"tRNS", b"sRGB", b"gAMA")]
    number = 0
    for i, frame in enumerate(frames):
        delay = struct.pack(">HH", 1000, max(1, min(65535, round(1000 * frames_per_second))))
        made.append(_chunk(b"fcTL", struct.pack(">IIIII", number, width, height, 0, 0) + delay + b"\0\0"))
        number += 1
        for kind, body in _chunks(frame):
            if kind == b"IHDR" and body != header:
                raise ValueError("the frames have other sizes or colours")
            if kind == b"IDAT" and i == 0:
                made.append(_chunk(b"IDAT", body))
            elif kind == b"IDAT":
                made.append(_chunk(b"fdAT", struct.pack(">I", number) + body))
                number += 1
    return b"".join([*made, _chunk(b"IEND", b"")])


def _chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def _chunks(png: bytes) -> Iterator[tuple[bytes, bytes]]:
    at = 8
    while at < len(png):
        (length,) = struct.unpack(">I", png[at : at + 4])
        yield png[at + 4 : at + 8], png[at + 8 : at + 8 + length]
        at += 12 + length
