# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Masses, states at stamps, and going back through a march with few states in memory."""

from diffcal_ros.fem.elements.element import discretise, Element
from diffcal_ros.fem.motion.checkpoints import CheckpointPlan, Checkpoints
from diffcal_ros.fem.motion.frame_reader import FrameReader
from diffcal_ros.fem.motion.lumped_mass import lumped_fractions, lumped_masses
import numpy as np
import pytest
from support.beams import beam_mesh


@pytest.mark.parametrize('element', list(Element))
def test_lumped_masses_keep_mass_and_its_middle(element) -> None:
    mesh = beam_mesh((3, 2, 2))
    discretisation = discretise(mesh, element)
    density = np.linspace(900.0, 1300.0, mesh.tet_count)
    masses = lumped_masses(discretisation, lumped_fractions(discretisation), density)
    assert (masses > 0.0).all()
    weights = density * mesh.volumes
    assert masses.sum() == pytest.approx(weights.sum(), rel=1e-12)
    middles = mesh.rest_positions[mesh.tets].mean(axis=1)
    np.testing.assert_allclose(masses @ discretisation.rest_nodes, weights @ middles, rtol=1e-12)


TIMES = np.array([0.0, 0.1, 0.25, 0.3, 0.5])
STAMPS = np.array([-0.2, 0.0, 0.07, 0.1, 0.28, 0.31, 0.5])


def _cubic(times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return 1.0 - times**2 + 4.0 * times**3, -2.0 * times + 12.0 * times**2


def test_frames_of_a_cubic_motion_are_exact() -> None:
    reader = FrameReader(TIMES, STAMPS)
    reader.begin((1, 1))
    for place, (value, rate) in enumerate(zip(*_cubic(TIMES), strict=True)):
        reader.add(place, np.full((1, 1), value), np.full((1, 1), rate))
    values, rates = _cubic(np.maximum(STAMPS, 0.0))
    np.testing.assert_allclose(reader.frames.ravel(), values, atol=1e-14)
    np.testing.assert_allclose(reader.rates.ravel(), rates, atol=1e-13)


def test_adjoints_of_frames_are_the_transpose(random) -> None:
    reader = FrameReader(TIMES, STAMPS)
    states = random.normal(size=(2, len(TIMES), 4, 3))
    by_frames = random.normal(size=(len(STAMPS), 4, 3))
    reader.begin((4, 3))
    backward = 0.0
    for place in range(len(TIMES)):
        reader.add(place, states[0, place], states[1, place])
        adjoints = np.zeros((2, 4, 3))
        reader.add_adjoints(place, by_frames, adjoints[0], adjoints[1])
        backward += float((adjoints * states[:, place]).sum())
    assert backward == pytest.approx(float((reader.frames * by_frames).sum()), rel=1e-12)


@pytest.mark.parametrize('states', [18, 25, 60, 500])
@pytest.mark.parametrize('step_count', [1, 7, 150])
def test_checkpoints_give_every_state_back_within_their_bound(step_count, states) -> None:
    plan = CheckpointPlan.within(step_count, 48, states * 48)
    kept = Checkpoints(plan)
    for step in range(step_count):
        kept.offer(step, (np.full(3, float(step)), np.zeros(3)))
    runs = 0

    def advance(state, begin, end):
        nonlocal runs
        assert state[0][0] == begin
        runs += end - begin
        return np.full(3, float(end)), np.zeros(3)

    visited = [(step, state[0][0]) for step, state in kept.backward(step_count, advance)]
    assert visited == [(step, float(step)) for step in reversed(range(step_count))]
    assert kept.largest_count <= states
    # Each halving of a stretch runs half of it again.
    assert runs <= step_count * (1.0 + 0.5 * np.log2(step_count + 1))


def test_too_little_memory_for_checkpoints_is_refused() -> None:
    with pytest.raises(ValueError, match='MB at least'):
        CheckpointPlan.within(1000, 1000, 10_000)
