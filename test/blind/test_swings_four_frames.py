# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Mirrors and exposures of the set `swings_four` do what their labels say."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind.faults import Faults
from benchmarks.blind.observe import true_rendering
from benchmarks.blind.renderer import Rendering
from benchmarks.blind.rotations import applied
from benchmarks.blind.setups import Setup
from benchmarks.blind.shutter import filmed_views, in_turn, swept, swept_share
from benchmarks.blind.simulation import Specimen
from benchmarks.blind.smoothing import on_window
from benchmarks.blind.stamping import moments, stamps
from benchmarks.blind.swings_four_forms import SWINGS_FOUR_FORMS
from benchmarks.blind.timing import draw_swing, PERIOD, Timing

FORMS = {form.key: form for form in SWINGS_FOUR_FORMS}
TURN = Faults(depth_form='in turn', depth_scale=2.5, depth_turn=1)


def _timing() -> Timing:
    return draw_swing(np.random.default_rng(1))


@pytest.mark.parametrize('step', [1e-1, 1e-2, 1e-3])
def test_a_mirror_goes_as_a_spring_lets_it(setup: Setup, step: float) -> None:
    """Where the beam is swings by the sine of the time: fastest amid the image."""
    camera = setup.camera
    last, width = camera.width - 1.0, 0.5 * (camera.width - 1.0)
    ends = swept_share(camera, np.array([-5.0, 0.0, 0.5 * last, last, last + 5.0]))
    np.testing.assert_allclose(ends, [0.0, 0.0, 0.5, 1.0, 1.0], atol=1e-12)
    for column in (40.0, 200.0, 319.5, 500.0):
        one, two = swept_share(camera, np.array([column + step, column - step]))
        away = column - width
        rate = 1.0 / (np.pi * np.sqrt(width**2 - away**2))
        assert (one - two) / (2.0 * step) == pytest.approx(rate, rel=1e-3)
        back = width - width * np.cos(np.pi * swept_share(camera, np.array([column]))[0])
        assert back == pytest.approx(column)


@pytest.mark.parametrize('is_back', [False, True])
def test_each_node_is_seen_when_the_beam_comes_by(
    setup: Setup, plain: Specimen, is_back: bool
) -> None:
    """Nodes that move evenly through the room: column and moment by a fixed point of each."""
    observation, velocity = setup.observations[0], np.array([0.3, -0.05, 0.7])
    half, nodes = 0.012, plain.mesh.nodes
    times = np.linspace(-half, half, 9)
    seen = swept(nodes + times[:, None, None] * velocity, setup, observation, is_back=is_back)
    when = (seen - nodes) @ velocity / (velocity @ velocity)
    np.testing.assert_allclose(seen, nodes + when[:, None] * velocity, atol=1e-12)
    to_camera = setup.depth_from_world @ observation.world_from_object
    columns = setup.camera.project(applied(to_camera, seen))[:, 0]
    across = 2.0 * columns / (setup.camera.width - 1.0) - 1.0
    way = -1.0 if is_back else 1.0
    np.testing.assert_allclose(when, way * half * np.arcsin(across) * 2.0 / np.pi, atol=1e-7)
    assert np.ptp(when) > 0.15 * half


def _tossed(plain: Specimen, time: float) -> np.ndarray:
    """Return a body that falls and turns a little, at a time [s]."""
    nodes = plain.mesh.nodes
    falls = np.array([0.0, 0.1, -0.5]) - 3.0 * nodes[:, :1] * np.array([0.0, 0.0, 1.0])
    return np.asarray(nodes + time * falls)


def test_a_swept_image_has_each_column_of_the_moment_of_its_beam(
    setup: Setup, plain: Specimen
) -> None:
    observation, half, camera = setup.observations[0], 0.012, setup.camera
    times = np.linspace(-half, half, 9)
    places = np.array([_tossed(plain, time) for time in times])
    view = true_rendering(
        plain,
        setup,
        observation,
        Faults(),
        swept(places, setup, observation, is_back=True),
    )
    standing = true_rendering(plain, setup, observation, Faults(), _tossed(plain, 0.0))
    begun, errors, wrong = view.column, [], []
    for part in (0.2, 0.5, 0.8):
        column = begun + int(part * view.depth.shape[1])
        when = half * (1.0 - 2.0 * swept_share(camera, np.array([column]))[0])
        still = true_rendering(plain, setup, observation, Faults(), _tossed(plain, when))
        for found, other in ((errors, still), (wrong, standing)):
            one, two = view.depth, on_window(other, view)
            both = np.isfinite(one) & np.isfinite(two)
            both[:, : column - begun], both[:, column - begun + 1 :] = False, False
            assert both.sum() > 50
            found.append(np.abs(one[both] - two[both]).mean())
    assert max(errors) < 2e-5
    assert max(wrong) > 1e-4


@pytest.mark.parametrize('late', [9.0, -9.0])
def test_frames_are_swept_to_and_fro(setup: Setup, plain: Specimen, late: float) -> None:
    faults = Faults(stamps_form='swept', stamps_late=late)
    timing = replace(_timing(), release=0.02, frame_count=3)
    # Each frame's own moment is the middle of its sweep; its stamp is the end or the beginning.
    middles = np.array(moments(timing, faults))
    np.testing.assert_allclose(np.diff(middles), PERIOD)
    when = 1e-9 * np.array(stamps(timing, faults)) - timing.release
    np.testing.assert_allclose(when - middles, 1e-3 * late, atol=2e-9)
    observation = setup.observations[0]
    shown = filmed_views(plain, setup, observation, faults, timing)
    exact = replace(timing, release=timing.release + 1e-3 * late)
    quiet = filmed_views(plain, setup, observation, Faults(), exact)
    # The tip lies to one side: to and fro it is seen after the middle, and before.
    tip = applied(setup.depth_from_world @ observation.world_from_object, plain.mesh.nodes)
    side = np.sign(setup.camera.project(tip[plain.shares > 0.99])[:, 0].mean() - 320.0)
    lower = [_middle_row(one) - _middle_row(two) for one, two in zip(shown, quiet, strict=True)]
    # Of the frames after the release, whose numbers are odd and even, one is ahead of the other.
    assert side * lower[1] < 0.0
    assert side * lower[2] > 0.0


def _middle_row(view: Rendering) -> float:
    """Return the mean row of what is seen [px]."""
    counts = np.isfinite(view.depth).sum(axis=(1, 2))
    return float((view.row + np.arange(len(counts))) @ counts / counts.sum())


@pytest.mark.parametrize('size', range(3))
def test_a_sweep_is_over_before_the_next_frame(setup: Setup, size: int) -> None:
    ways = set()
    for seed in range(20):
        draw = FORMS['time_offset/swept'].draw
        faults = Faults(**draw(size, setup, np.random.default_rng(seed)))
        assert 2e-3 * abs(faults.stamps_late) < PERIOD
        ways.add(float(np.sign(faults.stamps_late)))
    assert ways == {-1.0, 1.0}


def test_every_other_frame_errs() -> None:
    scales = [in_turn(TURN, number).depth_scale for number in range(5)]
    assert scales == [0.0, 2.5, 0.0, 2.5, 0.0]
    other = [in_turn(replace(TURN, depth_turn=0), number).depth_scale for number in range(3)]
    assert other == [2.5, 0.0, 2.5]
    plain = replace(TURN, depth_form='')
    assert in_turn(plain, 0) is plain


def test_depths_of_every_other_frame_are_scaled(setup: Setup, plain: Specimen) -> None:
    timing = replace(_timing(), release=0.05, frame_count=4)
    shown, quiet = (
        filmed_views(plain, setup, setup.observations[0], each, timing)
        for each in (TURN, Faults())
    )
    for number, (one, two) in enumerate(zip(shown, quiet, strict=True)):
        seen = np.isfinite(two.depth)
        factor = 1.025 if number % 2 else 1.0
        np.testing.assert_allclose(one.depth[seen], factor * two.depth[seen], rtol=1e-12)


@pytest.mark.parametrize(('size', 'least', 'most'), [(1, 0.0033, 0.0047), (2, 0.0076, 0.0104)])
def test_sizes_of_the_second_exposure_are_seen(
    setup: Setup, size: int, least: float, most: float
) -> None:
    turns = set()
    for seed in range(12):
        draw = FORMS['depth_affine/in turn'].draw
        faults = Faults(**draw(size, setup, np.random.default_rng(seed)))
        off = 1e-2 * abs(faults.depth_scale) * np.linalg.norm(setup.depth_from_world[:3, 3])
        assert least < off < most
        turns.add(faults.depth_turn)
    assert turns == {0, 1}
