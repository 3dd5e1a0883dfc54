"""Pictures for notebooks."""

from __future__ import annotations

import base64
import struct
import zlib

import pytest

import mimesh
from mimesh._display import _chunks


def test_a_picture_shows_the_mesh(horse) -> None:
    picture = horse.picture(size=200)
    assert picture.startswith(b"\x89PNG")
    width, height = struct.unpack(">II", picture[16:24])
    assert (width, height) == (200, 200)
    assert horse.picture(size=200) == picture != horse.picture(1, size=200)
    html = horse._repr_html_()
    assert base64.b64encode(horse.picture()).decode() in html and "1870 vertices" in html
    with pytest.raises(mimesh.UsageError, match="view"):
        horse.picture(view="below")


def test_an_animation_has_the_pictures_of_all_poses(horse) -> None:
    played = horse.animation(10, size=120)
    chunks = list(_chunks(played))
    frames, loops = struct.unpack(">II", dict(chunks)[b"acTL"])
    assert (frames, loops) == (len(horse.poses), 0)
    controls = [body for kind, body in chunks if kind == b"fcTL"]
    assert len(controls) == frames
    numbers = [struct.unpack(">I", body[:4])[0] for kind, body in chunks if kind in (b"fcTL", b"fdAT")]
    assert numbers == list(range(len(numbers)))
    for kind, body in chunks:
        assert len(kind) == 4 and zlib.crc32(kind + body) >= 0
    numerator, denominator = struct.unpack(">HH", controls[0][20:24])
    assert numerator / denominator == pytest.approx(0.1)
    # The data of each frame is that of a picture of its own.
    data = [b"".join(body for kind, body in chunks if kind == b"IDAT")]
    assert len(zlib.decompress(data[0])) > 120 * 120


def test_many_poses_are_thinned(horse) -> None:
    many = horse.with_poses([horse.vertices + i * 1e-3 for i in range(100)])
    frames = struct.unpack(">II", dict(_chunks(many.animation(size=32)))[b"acTL"])[0]
    assert 12 < frames <= 24


def test_a_result_plays(horse) -> None:
    result = mimesh.transfer(horse, horse.with_vertices(horse.vertices), metrics=[])
    assert "data:image/png" in result._repr_html_() and "4 poses" in result._repr_html_()
