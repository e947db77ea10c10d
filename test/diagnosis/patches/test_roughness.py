# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The error that no two patches share, measured on patches that also lack an effect."""

from dataclasses import replace

from diffcal_ros.diagnosis.patches.noise_model import NoiseModel
from diffcal_ros.diagnosis.patches.patch_group import PatchGroup
from diffcal_ros.diagnosis.patches.patches import Patches
from diffcal_ros.diagnosis.patches.roughness import (
    log_likelihoods,
    measured_noises,
    measured_roughness,
)
import numpy as np
import pytest

_ASSUMED = NoiseModel(pixel=0.00014, is_measured=True)


def seen_with(rough, seed, *, kind='depth', view=0, side=9):
    """Draw the patches of one view, whose own error is `rough` [m], with what is assumed."""
    random = np.random.default_rng(seed)
    centers = 14.0 * np.stack(np.meshgrid(np.arange(side), np.arange(side + 2)), -1).reshape(-1, 2)
    counts = random.uniform(60.0, 190.0, len(centers))
    true = replace(_ASSUMED, rough=rough).depth_covariance(centers, counts)
    values = np.linalg.cholesky(true) @ random.standard_normal(len(centers))
    patches = Patches(
        values=values,
        jacobian=random.standard_normal((len(centers), 2)),
        covariance=_ASSUMED.depth_covariance(centers, counts),
        centers=centers,
        cells=np.arange(len(centers)),
        weights=counts,
        common=_ASSUMED.depth_common(len(centers)),
    )
    mesh = 1e-4 * random.standard_normal(len(centers))
    return PatchGroup(view, kind, view, patches, mesh, np.zeros(len(centers), dtype=bool))


def with_more(group, more):
    return replace(group, patches=replace(group.patches, values=group.patches.values + more))


def smooth_cause(group):
    x, y = (group.patches.centers / 100.0).T
    return 0.004 * (x**3 - 0.7 * x * y**2 + 0.3 * y)


@pytest.mark.parametrize('rough', [1e-5, 2.5e-5, 5e-5, 1e-4])
def test_the_error_is_found_whatever_was_assumed(rough):
    found = [
        measured_roughness([seen_with(rough, 3 * seed + view) for view in range(3)], 5e-5)
        for seed in range(10)
    ]
    # Some 240 directions a time: a twentieth of the size, and pixels that hide the smallest.
    assert np.mean(found) == pytest.approx(rough, rel=0.1)
    assert np.std(found) < 0.2 * rough


def test_parameters_mesh_and_smooth_causes_are_not_taken_for_noise():
    groups = [seen_with(2e-5, seed) for seed in range(2)]
    lacking = [
        with_more(
            group,
            smooth_cause(group) + group.patches.jacobian @ [0.01, -0.02] + 3.0 * group.mesh,
        )
        for group in groups
    ]
    assert measured_roughness(lacking, 5e-5) == pytest.approx(
        measured_roughness(groups, 5e-5), rel=1e-6
    )


@pytest.mark.parametrize('count', [0, 1, 3, 9])
def test_a_view_with_few_patches_says_nothing(count):
    group, few = seen_with(2e-5, 3), seen_with(9e-5, 4)
    few = replace(few, patches=few.patches.chosen(np.arange(count)), mesh=few.mesh[:count])
    assert measured_roughness([group, few], 5e-5) == measured_roughness([group], 5e-5)


def test_the_likelihood_is_the_restricted_one():
    group, sizes = with_more(seen_with(3e-5, 7), 0.001), np.array([1e-5, 3e-5, 8e-5])
    x, y = (group.patches.centers / 60.0 - 1.0).T
    smooth = [x**i * y**j for i in range(4) for j in range(4 - i)]
    known = np.column_stack([group.patches.jacobian, group.mesh, *smooth])
    textbook = []
    for size in sizes:
        more = (size**2 - _ASSUMED.rough**2) * np.eye(len(x))
        inverse = np.linalg.inv(group.patches.covariance + more)
        information = known.T @ inverse @ known
        rest = inverse - inverse @ known @ np.linalg.solve(information, known.T @ inverse)
        determinants = np.linalg.slogdet(information)[1] - np.linalg.slogdet(inverse)[1]
        textbook.append(-0.5 * (determinants + group.patches.values @ rest @ group.patches.values))
    found = log_likelihoods(group, _ASSUMED.rough, sizes)
    assert np.diff(found) == pytest.approx(np.diff(textbook), rel=1e-5)


def test_too_few_patches_leave_what_was_assumed():
    few = seen_with(2e-4, 1, side=2)
    assert measured_roughness([few], 5e-5) == pytest.approx(5e-5, rel=0.6)
    assert measured_roughness([], 5e-5) == pytest.approx(
        measured_roughness([few], 5e-5), rel=1e-12
    )


def test_only_what_was_watched_at_rest_is_measured():
    noises = [_ASSUMED, replace(_ASSUMED, is_measured=False, rough=1.5e-4), _ASSUMED]
    groups = [seen_with(2e-5, 5 + view, view=view) for view in range(3)]
    found = measured_noises(noises, groups, still=[0, 1])
    assert found[0].rough == pytest.approx(2e-5, rel=0.25)
    assert found[1:] == tuple(noises[1:])
    # The same without the others, which say nothing of it.
    assert measured_noises(noises, groups[:1], still=[0, 1]) == found


def test_an_effect_that_is_not_smooth_does_not_raise_the_floor():
    group = seen_with(2e-5, 9)
    step = with_more(group, np.where(group.patches.centers[:, 0] > 60.0, 0.003, 0.0))
    assert measured_roughness([step], 5e-5) > 1e-4
    (found,) = measured_noises([_ASSUMED], [step], still=[0])
    assert found.rough == _ASSUMED.rough


def test_outlines_and_fixtures_say_nothing_of_it():
    group = seen_with(2e-5, 11)
    alone = measured_roughness([group], 5e-5)
    others = [seen_with(4e-4, 12, kind='edge'), replace(seen_with(4e-4, 13), is_rigid=True)]
    assert measured_roughness([group, *others], 5e-5) == alone
