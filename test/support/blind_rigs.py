# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rigs of bodies of other kinds than bars: drawn ones, and those in which they hang level."""

from collections import Counter
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from benchmarks.blind.cases import Case
from benchmarks.blind.faults import Faults
from benchmarks.blind.other_bodies import OtherShape
from benchmarks.blind.other_rigs import draw_other_setup, OtherSetup, UnfitError
from benchmarks.blind.rotations import rigid
from benchmarks.blind.rubber import LAWS, Rubber
from benchmarks.blind.sensor import DRAWN, lidar
from benchmarks.blind.setups import Camera, GRAVITY, Observation
from benchmarks.blind.simulation import make_specimen, settle


def drawn_rig(family: str, seed: int = 0, **more: Any) -> OtherSetup:
    """Draw a rig of two poses, the first one that can be filmed.

    Args:
        family: of the body.
        seed: of the draw.
        more: see `draw_other_setup`.
    """
    for attempt in range(50):
        try:
            return draw_other_setup(
                family,
                poses=2,
                sensor='l515',
                law='stable',
                random=np.random.default_rng([seed, attempt]),
                **more,
            )
        except UnfitError:
            continue
    raise AssertionError(f'no rig of {family}')


def level_rig(shape: OtherShape) -> OtherSetup:
    """Return a rig in which a body hangs level, and sags by some hundredths of its length."""
    turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    return OtherSetup(
        shape=shape,
        youngs_modulus=100.0e3 * GRAVITY * shape.free**3 / min(shape.section) ** 2,
        start_modulus=1.0e5,
        poissons_ratio=0.48,
        density=1100.0,
        camera=Camera(640, 480, 600.0, 600.0, 319.5, 239.5),
        depth_from_world=np.eye(4),
        sensor=lidar(0.0002),
        observations=(Observation('level', rigid(turn, np.zeros(3))),),
        rubber=Rubber(),
    )


def largest_move(shape: OtherShape, refinement: float) -> float:
    """Return how far the node that sags most comes to rest from where it was made [m].

    Args:
        shape: of the body.
        refinement: by which its cells are smaller.
    """
    setup = level_rig(shape)
    specimen = make_specimen(setup, Faults(), refinement)
    rest = settle(specimen, setup, setup.observations[0], Faults())
    return float(np.linalg.norm(rest - specimen.mesh.nodes, axis=1).max())


def check_spread(cases: Sequence[Case], families: Collection[str], poses: set[int]) -> None:
    """Check that cases are of all bodies, sensors and laws about as often, and of some poses.

    Args:
        cases: of a set.
        families: of its bodies.
        poses: how many of them cases have.
    """
    for name, every in (('family', families), ('sensor', DRAWN), ('law', LAWS)):
        counts = Counter(getattr(case, name) for case in cases)
        assert set(counts) == set(every)
        assert max(counts.values()) <= 1.6 * len(cases) / len(every) + 1.0
    assert {case.poses for case in cases} == poses
