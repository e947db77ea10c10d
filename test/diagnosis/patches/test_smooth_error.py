# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A sensor's smooth error, measured on patches of several poses beside all that may be missing."""

from dataclasses import replace

from diffcal_ros.diagnosis import diagnose
from diffcal_ros.diagnosis.patches.noise_model import kernel, NoiseModel
from diffcal_ros.diagnosis.patches.patch_evaluator import PatchEvaluator
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.patches import Patches
from diffcal_ros.diagnosis.patches.smooth_error import measured_smooth_error, with_smooth_error
from diffcal_ros.diagnosis.patches.whitened import Part, whiten
import numpy as np
import pytest
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


@pytest.mark.parametrize('size', [0.0002, 0.0003, 0.0004])
def test_the_size_is_found(size):
    found = [measured_smooth_error(poses_with(size, 0.5, seed), _ASSUMED) for seed in range(6)]
    sizes = [one.size for one in found]
    assert np.median(sizes) == pytest.approx(size, rel=0.15)
    assert {one.length for one in found} == {80.0}


@pytest.mark.parametrize(('true', 'found'), [(0.0, 0.0), (0.95, 0.9)])
def test_what_all_poses_share_is_told_from_what_each_has_of_its_own(true, found):
    for seed in range(4):
        assert measured_smooth_error(poses_with(0.0003, true, seed), _ASSUMED).standing == found


def test_what_effects_may_have_put_there_is_not_taken_for_the_sensor():
    groups = poses_with(0.0002, 0.5, 7)
    lacking = [
        replace(
            group,
            patches=replace(
                group.patches,
                values=group.patches.values + group.patches.jacobian @ [0.01, -0.02, 0.03],
            ),
        )
        for group in groups
    ]
    plain, with_gap = (measured_smooth_error(own, _ASSUMED) for own in (groups, lacking))
    assert with_gap.size == pytest.approx(plain.size, rel=1e-6)


def test_a_sensor_is_trusted_no_more_than_assumed_and_no_gap_makes_it_a_bad_one():
    small, large = (
        measured_smooth_error(poses_with(size, 0.5, 3), _ASSUMED) for size in (2e-5, 0.003)
    )
    assert small.size == _ASSUMED.smooth
    assert large.size == 2.0 * _ASSUMED.smooth


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


def test_beside_a_large_gap_the_error_is_not_measured(screened, monkeypatch):
    looked = []

    def look(evaluator, coordinates, listed):
        looked.append(len(listed))
        return (), evaluator.groups(coordinates)

    monkeypatch.setattr(diagnose, 'library_groups', look)
    tilted, tilted_fit, _ = screened
    clean = diagnose.fit_nominal(beam_scene((6, 2, 2)), [watched(seed=3)], None)
    # One pose tells nothing, and no effect is looked at for it.
    assert diagnose.with_smooth_error(*clean) == clean
    assert looked == []
    monkeypatch.setattr(PatchEvaluator, 'tells_smooth_error', True)
    assert diagnose.with_smooth_error(tilted, tilted_fit) == (tilted, tilted_fit)
    assert looked == []
    diagnose.with_smooth_error(*clean)
    assert len(looked) == 1
