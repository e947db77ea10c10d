# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where else along itself a proposed body fits nearly as well, and when that is said."""

from dataclasses import replace

from diffcal_ros.proposal.clamp_plane import ClampPlane
from diffcal_ros.proposal.find_body import _slides_alike, FoundBody
from diffcal_ros.proposal.hold import Hold
from diffcal_ros.proposal.place_fit import PlaceFit
from diffcal_ros.proposal.propose import _slide_doubts
import numpy as np
import pytest
from support.beams import beam_mesh

MESH = beam_mesh((6, 2, 2))
LENGTH = float(MESH.rest_positions[:, 0].max())


def _fit(plane: float) -> PlaceFit:
    """A body held at its far end, from a plane on."""
    return PlaceFit(
        hold=Hold(np.array([1.0, 0.0, 0.0]), plane),
        world_from_object=np.eye(4),
        youngs_modulus=1e5,
        points=MESH.rest_positions + np.array([0.0, 0.0, 0.5]),
        result=None,  # It is not read here.
        clamp=ClampPlane(plane, 0.003, is_seen=True, is_oblique=False),
        calibration=None,
    )


BEST = _fit(LENGTH - 0.040)


def _elsewhere() -> PlaceFit:
    return replace(BEST, points=BEST.points + np.array([0.2, 0.0, 0.0]))


def _other_end() -> PlaceFit:
    other = _fit(LENGTH - 0.01)
    return replace(other, hold=Hold(np.array([-1.0, 0.0, 0.0]), 0.0))


@pytest.mark.parametrize(
    ('merit', 'fit'),
    [
        (0.5, _fit(LENGTH - 0.015)),
        (0.89, _elsewhere()),
        (0.89, _other_end()),
        (0.89, replace(BEST, clamp=replace(BEST.clamp, plane=0.0, is_seen=False))),
    ],
    ids=['far worse', 'another place', 'the other end', 'no clamp in sight'],
)
def test_what_is_no_slide_of_the_same_place_says_nothing(merit, fit):
    slides = _slides_alike([(0.9, BEST), (merit, fit)])
    assert slides == (BEST.clamp.plane,)
    assert _slide_doubts(FoundBody(BEST, 0.9, (), slides), MESH) == []


def test_slides_that_come_near_are_told_as_a_range():
    slides = _slides_alike(
        [(0.9, BEST), (0.89, _fit(LENGTH - 0.015)), (0.85, _fit(LENGTH - 0.03))]
    )
    assert len(slides) == 3
    (doubt,) = _slide_doubts(FoundBody(BEST, 0.9, (), slides), MESH)
    assert '15 to 40 mm of it may be held, where 40 are proposed' in doubt


def test_a_slide_within_the_planes_own_doubt_is_not_told_again():
    slides = _slides_alike([(0.9, BEST), (0.89, _fit(LENGTH - 0.038))])
    assert len(slides) == 2
    assert _slide_doubts(FoundBody(BEST, 0.9, (), slides), MESH) == []
