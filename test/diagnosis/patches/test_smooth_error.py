# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A sensor's smooth error, measured on patches of several poses beside all that may be missing."""

from dataclasses import replace
from itertools import product

from diffcal_ros.diagnosis import nominal_fit
from diffcal_ros.diagnosis.patches.noise_model import kernel, NoiseModel
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.patches import Patches
from diffcal_ros.diagnosis.patches.smooth_error import (
    expected_smooth_error,
    measured_smooth_error,
    with_smooth_error,
)
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
import numpy as np
import pytest
from scipy.linalg import block_diag, null_space
from scipy.stats import multivariate_normal
from support.scenes import beam_scene
from support.watched import watched

_ASSUMED = NoiseModel(pixel=0.00014, is_measured=True)
_POSES = 4


def poses_with(
    size: float,
    standing: float,
    seed: int,
    *,
    length: float = 80.0,
    noise: NoiseModel = _ASSUMED,
    sides: tuple[int, int] = (13, 9),
) -> list[PatchGroup]:
    """Draw patches of several poses whose smooth error has a part in common."""
    random = np.random.default_rng(seed)
    steps = [np.arange(side) for side in sides]
    first = 24.0 * np.stack(np.meshgrid(*steps), -1).reshape(-1, 2)
    count = len(first)
    # Bodies lie elsewhere in every picture.
    centers = [first + random.uniform(-40.0, 40.0, 2) for _ in range(_POSES)]
    everywhere = np.concatenate(centers)
    pattern = _drawn(everywhere, length, random).reshape(_POSES, count)
    groups = []
    for view, own in enumerate(centers):
        smooth = np.sqrt(standing) * pattern[view]
        smooth = smooth + np.sqrt(1.0 - standing) * _drawn(own, length, random)
        white = np.hypot(noise.pixel / 10.0, noise.rough) * random.standard_normal(count)
        patches = Patches(
            values=size * smooth + white,
            jacobian=random.standard_normal((count, 3)),
            covariance=noise.depth_covariance(own, np.full(count, 100.0)),
            centers=own,
            cells=np.arange(count),
            weights=np.full(count, 100.0),
            common=noise.depth_common(count),
            standing=noise.depth_standing(count) if noise.standing else None,
        )
        mesh = 1e-4 * random.standard_normal(count)
        groups.append(PatchGroup(view, 'depth', view, patches, mesh, np.zeros(count, dtype=bool)))
    return groups


def _drawn(centers: np.ndarray, length: float, random: np.random.Generator) -> np.ndarray:
    values, turns = np.linalg.eigh(kernel(centers, length))
    return turns @ (np.sqrt(np.maximum(values, 0.0)) * random.standard_normal(len(values)))


@pytest.mark.parametrize('size', [0.0002, 0.0003, 0.0004, 0.0015])
@pytest.mark.slow_but_first
def test_the_size_is_found(size):
    found = [measured_smooth_error(poses_with(size, 0.5, seed), _ASSUMED) for seed in range(6)]
    sizes = [one.size for one in found]
    assert np.median(sizes) == pytest.approx(size, rel=0.15)
    assert {one.length for one in found} == {80.0}


@pytest.mark.slow
def test_what_a_scene_states_is_believed_as_it_is():
    stated = replace(_ASSUMED, smooth=0.0004, is_stated=True)
    # An effect that tangents do not follow looks like a sensor that is three times worse.
    found = measured_smooth_error(poses_with(0.0012, 0.9, 3, noise=stated), stated)
    assert found.size == pytest.approx(stated.smooth)
    as_stated = measured_smooth_error(poses_with(0.0004, 0.95, 3, noise=stated), stated)
    assert as_stated.standing > 0.7, 'what poses share of it is measured yet'
    assert expected_smooth_error(stated).size == stated.smooth
    guessed = replace(stated, is_stated=False)
    assert measured_smooth_error(poses_with(0.0012, 0.9, 3, noise=guessed), guessed).size > 0.001


def test_an_error_of_one_length_is_no_part_of_a_larger_one():
    """By lengths of all sizes alone 0.8 mm over 80 px are 2.3 mm over 160."""
    found = measured_smooth_error(poses_with(0.0008, 0.5, 2), _ASSUMED)
    assert found.size == pytest.approx(0.0008, rel=0.15)


@pytest.mark.slow
def test_it_is_that_of_whole_densities():
    """By the density of what is beside all tangents, with the whole covariance."""
    noise = replace(_ASSUMED, rough=5e-5)
    groups = poses_with(0.0003, 0.5, 2, noise=noise, sides=(8, 6))
    tangents = np.concatenate([group.patches.jacobian for group in groups])
    mesh = block_diag(*(group.mesh[:, None] for group in groups))
    beside = null_space(np.hstack([tangents, mesh]).T).T
    values = beside @ np.concatenate([group.patches.values for group in groups])
    centers = np.concatenate([group.patches.centers for group in groups])
    poses = np.repeat(np.arange(_POSES), len(groups[0].patches.values))
    rest = block_diag(
        *(
            group.patches.covariance
            + group.patches.common.covariance(group.patches.centers)
            - noise.smooth**2 * kernel(group.patches.centers, 80.0)
            for group in groups
        )
    )
    sizes = np.geomspace(0.25, 16.0, 49)
    levels = {}
    for length, standing, is_mixed in product((40.0, 80.0, 160.0), (0.0, 0.5, 0.9), (False, True)):
        shared = np.where(poses[:, None] == poses, 1.0, standing)
        smooth = noise.smooth**2 * shared * kernel(centers, length, is_mixed=is_mixed)
        for size in sizes:
            covariance = beside @ (rest + size**2 * smooth) @ beside.T
            prior = -0.5 * (np.log(size) / np.log(2.0)) ** 2
            density = multivariate_normal(np.zeros(len(values)), covariance).logpdf(values)
            levels[length, standing, is_mixed, size] = density + prior
    chances = np.exp(np.array(list(levels.values())) - max(levels.values()))
    chances /= chances.sum()
    squares = chances * np.array([size**2 for *_, size in levels])
    found = measured_smooth_error(groups, noise)
    assert found.size == pytest.approx(noise.smooth * np.sqrt(squares.sum()), rel=1e-3)
    shares = np.array([standing for _, standing, *_ in levels])
    assert found.standing == pytest.approx(squares @ shares / squares.sum(), abs=1e-3)
    by_length = {
        length: sum(c for c, (own, *_) in zip(chances, levels, strict=True) if own == length)
        for length in (40.0, 80.0, 160.0)
    }
    assert found.length == max(by_length, key=by_length.__getitem__)


@pytest.mark.parametrize(('true', 'least', 'most'), [(0.0, 0.0, 0.1), (0.95, 0.85, 0.9)])
@pytest.mark.slow
def test_what_all_poses_share_is_told_from_what_each_has_of_its_own(true, least, most):
    for seed in range(4):
        found = measured_smooth_error(poses_with(0.0003, true, seed), _ASSUMED)
        assert least - 1e-9 <= found.standing <= most + 1e-9


@pytest.mark.slow
def test_what_is_hidden_is_believed_no_larger_than_is_to_be_expected_of_a_sensor():
    expected = expected_smooth_error(_ASSUMED)
    random = np.random.default_rng(1)
    drawn = _ASSUMED.smooth * np.exp(np.log(2.0) * random.standard_normal(400_000))
    assert expected.size == pytest.approx(np.sqrt(np.mean(drawn**2)), rel=0.02)
    assert 0.3 < expected.standing < 0.6
    for size, is_less in ((0.0002, True), (0.002, False)):
        groups, still = poses_with(size, 0.5, 1), {0, 2, 3}
        seen = with_smooth_error([_ASSUMED] * _POSES, groups, still)[0]
        hidden, moving, *_ = with_smooth_error([_ASSUMED] * _POSES, groups, still, is_hidden=True)
        assert (seen.smooth < expected.size) == is_less
        own = [group for group in groups if group.view in still]
        most = measured_smooth_error(own, _ASSUMED, is_hidden=True)
        assert hidden.smooth == min(most.size, expected.size)
        assert hidden.smooth == pytest.approx(min(seen.smooth, expected.size), rel=1e-9)
        assert hidden.is_mixed
        assert moving == _ASSUMED


@pytest.mark.parametrize('length', [40.0, 80.0, 160.0])
def test_a_whole_picture_has_more_in_common_than_by_one_length(length):
    centers = np.array([[0.0, 0.0], [5.0, 0.0], [0.0, 200.0]])
    shared = kernel(centers, length, is_mixed=True)
    one = np.exp(-np.array([0.0, 25.0, 200.0**2]) / length**2)
    np.testing.assert_allclose(shared, shared.T)
    np.testing.assert_allclose(shared[0, :2], one[:2], atol=1e-3)
    assert shared[0, 2] > one[2]
    # A mixture of Gaussian kernels: squares of their inverse lengths are exponential.
    random = np.random.default_rng(2)
    drawn = np.exp(-(200.0**2) * random.exponential(size=200_000) / length**2)
    assert shared[0, 2] == pytest.approx(drawn.mean(), rel=0.02)


def _with_more(groups: list[PatchGroup], more: list[np.ndarray]) -> list[PatchGroup]:
    """Return patches that are off by more [m], shape (n,) each."""
    return [
        replace(own, patches=replace(own.patches, values=own.patches.values + by))
        for own, by in zip(groups, more, strict=True)
    ]


@pytest.mark.slow
def test_what_effects_may_have_put_there_is_not_taken_for_the_sensor():
    groups = poses_with(0.0002, 0.5, 7)
    lacking = _with_more(
        groups, [group.patches.jacobian @ [0.01, -0.02, 0.03] for group in groups]
    )
    plain, with_gap = (measured_smooth_error(own, _ASSUMED) for own in (groups, lacking))
    assert with_gap.size == pytest.approx(plain.size, rel=1e-6)


def test_a_sensor_is_trusted_no_more_than_assumed():
    small = measured_smooth_error(poses_with(2e-5, 0.5, 3), _ASSUMED)
    assert small.size == _ASSUMED.smooth


@pytest.mark.slow
def test_a_bad_sensor_is_told_by_a_small_gap_and_not_by_a_large_one():
    groups, still = poses_with(0.002, 0.5, 3), range(_POSES)
    told = with_smooth_error([_ASSUMED] * _POSES, groups, still)
    hidden = with_smooth_error([_ASSUMED] * _POSES, groups, still, is_hidden=True)
    assert told[0].smooth == pytest.approx(0.002, rel=0.15)
    assert hidden[0].smooth == expected_smooth_error(_ASSUMED).size


def _beside_all_that_is_smooth(rough, size):
    """Return patches with rough errors of a size, beside tangents that take most smooth ways.

    Args:
        rough: independent error of each patch [m].
        size: smooth one [m].
    """
    random = np.random.default_rng(4)
    groups = poses_with(size, 0.0, 4, sides=(9, 6))
    shared = [kernel(group.patches.centers, 80.0) for group in groups]
    smoothest = [np.linalg.eigh(own)[1][:, -24:] for own in shared]
    every = np.split(block_diag(*smoothest), len(groups))
    groups = _with_more(groups, [rough * random.standard_normal(len(own)) for own in every])
    return [
        replace(group, patches=replace(group.patches, jacobian=own))
        for group, own in zip(groups, every, strict=True)
    ]


def test_what_edges_leave_is_not_taken_for_a_smooth_error():
    """Where tangents take what is smooth, what is rough would be the tail of an error of mm."""
    even, rough = (
        measured_smooth_error(_beside_all_that_is_smooth(own, 2e-4), _ASSUMED)
        for own in (0.0, 4e-4)
    )
    assert rough.size == pytest.approx(even.size, rel=0.1)
    # Beside a gap that hides it all that is left may be it, and no more is believed than of any.
    most = measured_smooth_error(_beside_all_that_is_smooth(4e-4, 2e-4), _ASSUMED, is_hidden=True)
    assert most.size > 4.0 * rough.size


def test_a_large_smooth_error_is_told_beside_rougher_noise():
    rough = [group.patches.values for group in _beside_all_that_is_smooth(1e-4, 0.0)]
    both = _with_more(poses_with(0.0015, 0.5, 3, sides=(9, 6)), rough)
    assert measured_smooth_error(both, _ASSUMED).size == pytest.approx(0.0015, rel=0.35)


@pytest.mark.parametrize('off', [0.004, -0.009])
@pytest.mark.slow
def test_a_few_patches_that_are_far_off_say_nothing_of_it(off):
    even = poses_with(0.0005, 0.5, 3)
    few = _with_more(even, [off * np.isin(own.patches.cells, [30, 31, 70]) for own in even])
    one, other = (measured_smooth_error(groups, _ASSUMED) for groups in (even, few))
    assert other.size == pytest.approx(one.size, rel=0.15)
    assert other.length == one.length


def test_views_of_a_motion_keep_their_noise():
    noises = with_smooth_error([_ASSUMED] * _POSES, poses_with(0.0004, 0.5, 1), still={0, 1})
    assert noises[0].smooth > 1.3 * _ASSUMED.smooth
    assert noises[2] == _ASSUMED
    assert with_smooth_error([_ASSUMED] * 4, poses_with(0.0004, 0.5, 1), still=()) == (
        (_ASSUMED,) * 4
    )


def test_whitened_patches_are_uncorrelated_across_poses():
    noise = replace(_ASSUMED, smooth=0.0004, standing=0.9)
    groups = poses_with(0.0004, 0.9, 5, noise=noise, sides=(6, 4))
    groups = [replace(group, mesh=np.zeros_like(group.mesh)) for group in groups]
    seen = whiten(groups, Part.ALL)
    # A shift of all depths costs as one error of the sensor, not as four.
    ones = [
        replace(
            group,
            patches=replace(group.patches, values=1e-6 * np.ones(24), jacobian=np.ones((24, 1))),
        )
        for group in groups
    ]
    together = np.sum(whiten(ones, Part.ALL).jacobian ** 2)
    apart = np.sum(whiten(ones, Part.ALL, is_apart=True).jacobian ** 2)
    assert together < 0.5 * apart
    own = np.concatenate([group.patches.covariance for group in groups]).shape[1]
    whole = np.zeros((4 * own, 4 * own))
    for view, group in enumerate(groups):
        rows = slice(view * own, (view + 1) * own)
        whole[rows, rows] = group.patches.covariance
    centers = np.concatenate([group.patches.centers for group in groups])
    whole += 0.9 * 0.0004**2 * kernel(centers, 80.0)
    values = np.concatenate([group.patches.values for group in groups])
    assert seen.chi_square == pytest.approx(values @ np.linalg.solve(whole, values), rel=1e-6)


def test_beside_a_large_gap_the_error_is_hidden(screened, monkeypatch):
    told = []

    def remember(evaluator, groups, *, is_hidden=False):
        told.append(is_hidden)
        return evaluator

    monkeypatch.setattr(nominal_fit, 'library_groups', lambda *_: ((), []))
    monkeypatch.setattr(PatchEvaluator, 'with_smooth_error', remember)
    tilted, tilted_fit, _ = screened
    clean = nominal_fit.fit_nominal(beam_scene((6, 2, 2)), [watched(seed=3)], None)
    # One pose tells nothing, and no effect is looked at for it.
    assert nominal_fit.with_smooth_error(*clean) == clean
    assert told == []
    monkeypatch.setattr(PatchEvaluator, 'tells_smooth_error', True)
    for evaluator, fit in ((tilted, tilted_fit), clean):
        nominal_fit.with_smooth_error(evaluator, fit)
    assert told == [True, False]
