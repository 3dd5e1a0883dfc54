"""Meshes that tests share."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mimesh


@pytest.fixture(scope="session")
def horse() -> mimesh.Mesh:
    return mimesh.generators.Quadruped(proportions="horse", gait="gallop", frames=4, resolution=30).generate()


@pytest.fixture(scope="session")
def camel() -> mimesh.Mesh:
    return mimesh.generators.Quadruped(proportions="camel", gait="gallop", frames=4, resolution=34, seed=1).generate()


@pytest.fixture(scope="session")
def repository() -> Path:
    return Path(__file__).resolve().parents[2]


@pytest.fixture
def grid() -> mimesh.Mesh:
    return make_grid(12)


def make_grid(n: int) -> mimesh.Mesh:
    """A wavy sheet of n × n vertices."""
    x, y = np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n))
    vertices = np.column_stack([x.ravel(), y.ravel(), 0.1 * np.sin(5 * x.ravel()) * np.cos(3 * y.ravel())])
    corner = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate(
        [np.column_stack([corner, corner + 1, corner + n]), np.column_stack([corner + 1, corner + n + 1, corner + n])]
    )
    return mimesh.Mesh(vertices, faces)


def rotation(seed: int = 0) -> np.ndarray:
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return q if np.linalg.det(q) > 0 else -q
