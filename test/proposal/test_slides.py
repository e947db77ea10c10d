# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where else along itself a proposed body fits nearly as well, and when that is said."""

from dataclasses import replace

from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.material import Material
from diffcal_ros.proposal.clamp_plane import ClampPlane
from diffcal_ros.proposal.find_body import _slides_alike, FoundBody
from diffcal_ros.proposal.hold import Hold
from diffcal_ros.proposal.place_fit import PlaceFit
from diffcal_ros.proposal.propose import _clamp_doubts, _slide_doubts
import numpy as np
import pytest
from support.beams import beam_mesh, held_end

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


def test_a_doubt_about_the_clamp_is_one_about_the_modulus():
    """With the free length's fourth power, which a bar under its weight is simulated for."""
    plane, doubt = LENGTH - 0.020, 0.002
    found = replace(BEST, clamp=ClampPlane(plane, doubt, is_seen=True, is_oblique=False))
    (told,) = _clamp_doubts(FoundBody(found, 0.9, (), (plane,)), MESH)
    assert told.startswith('the clamp may begin 2 mm nearer or farther')
    assert 'about 8 % lower or higher' in told
    sure = replace(found, clamp=replace(found.clamp, doubt=0.001))
    assert _clamp_doubts(FoundBody(sure, 0.9, (), (plane,)), MESH) == []
    # So much the modulus must fall for a bar that is shorter by the doubt to sag as far.
    sags = [_sag(length) for length in (0.100, 0.098)]
    assert 100.0 * (1.0 - sags[1] / sags[0]) == pytest.approx(8.0, abs=0.8)


def _sag(length: float) -> float:
    """Return how far the tip of a stiff bar sags [m]."""
    mesh = beam_mesh((8, 1, 1), (length, 0.008, 0.008))
    body = StaticBody(mesh, Element.QUADRATIC, held_end(mesh))
    ones = np.ones(mesh.tet_count)
    state = body.solve_equilibrium(
        Material(1e7 * ones, 0.3 * ones, 1000.0 * ones), np.array([0.0, 0.0, -9.81])
    )
    return float(np.abs(state.positions[: mesh.vertex_count] - mesh.rest_positions).max())
