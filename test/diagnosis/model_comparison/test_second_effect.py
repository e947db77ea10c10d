# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A second effect is one that no form of the first explains, in every pose."""

from collections.abc import Sequence
from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison import any_form, second_effect
from diffcal_ros.diagnosis.model_comparison.any_form import Sight
from diffcal_ros.diagnosis.model_comparison.form_basis import FormBasis
from diffcal_ros.diagnosis.model_comparison.form_places import Places, places_of
from diffcal_ros.diagnosis.model_comparison.form_ways import Ways, ways_at
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.model_comparison.second_effect import Explained, explained
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.patches.noise_model import kernel, NoiseModel
from diffcal_ros.diagnosis.patches.smooth_sizes import size_factors
from diffcal_ros.diagnosis.screening.candidates import Candidate
import numpy as np
import pytest
from scipy.stats import multivariate_normal
from support.judged_models import refitted_with

# How far the body of each pose moves by the same tilt: no pose is like another.
_POSES = (1.0, -0.6, 1.4)


def _slopes(fit: Refit, own: Candidate) -> list[np.ndarray]:
    """Return what an effect's amplitudes do to the patches of each group [m]."""
    places = [fit.parameters.names.index(name) for name in own.names]
    return [g.patches.jacobian[:, places] @ fit.coordinates[places] for g in fit.groups]


def _in_poses(
    hypothesis: Hypothesis, amounts: Sequence[float], more: float = 0.0
) -> tuple[Refit, list[Places]]:
    """Return a fit of several poses, and where their patches are.

    Args:
        hypothesis: in one pose; its first effect does another share of that in each.
        amounts: of that effect in each pose beyond its amplitude, as shares of it.
        more: bias of depth in all poses that no model has [m].
    """
    fit, first = hypothesis.fit, hypothesis.added[0]
    points = [view.points for view in hypothesis.evaluator.model.views(fit.coordinates)]
    columns = [fit.parameters.names.index(name) for name in first.names]
    slopes, here = _slopes(fit, first), places_of(hypothesis.evaluator.model, fit.groups, points)
    groups, places = [], []
    for view, (share, amount) in enumerate(zip(_POSES, amounts, strict=True)):
        for group, slope, place in zip(fit.groups, slopes, here, strict=True):
            jacobian = group.patches.jacobian.copy()
            jacobian[:, columns] *= share
            values = group.patches.values - amount * share * slope
            values = values + more * (group.kind == 'depth')
            patches = replace(group.patches, jacobian=jacobian, values=values)
            groups.append(replace(group, view=view, recording=view, patches=patches))
            own = np.eye(len(_POSES))[view]
            places.append(replace(place, own=own, pose=view, pose_count=len(_POSES)))
    return replace(fit, groups=groups), places


def _by(
    fit: Refit,
    places: Sequence[Places],
    pair: Hypothesis,
    kept: Sequence[Candidate],
    basis: FormBasis,
) -> Explained:
    return explained(fit, pair.added, kept, ways_at(places, fit, basis, kept))


def _adds(pair: Hypothesis, basis: FormBasis, amounts: Sequence[float], bias: float) -> Explained:
    fit, places = _in_poses(pair, amounts, bias)
    alone = [_by(fit, places, pair, [own], basis) for own in pair.added]
    return _by(fit, places, pair, pair.added, basis).above(alone)


def test_without_tolerances_it_is_the_evidence_of_the_fit(tilted, basis, monkeypatch):
    monkeypatch.setattr(any_form, 'OF_FORM', np.zeros(1))
    monkeypatch.setattr(any_form, 'BY_POSE', np.zeros(1))
    fit = tilted.fit
    places = places_of(tilted.evaluator.model, fit.groups, basis.points)
    found = _by(fit, places, tilted, tilted.added, basis)
    # The fit came to rest: what is left of its slope is worth a few hundredths.
    assert found.log_evidence == pytest.approx(fit.log_evidence, abs=0.1)
    assert found.log_transfer == 0.0, 'a single pose tells nothing of others'


def test_transfer_is_the_density_of_each_pose_given_the_others(monkeypatch):
    monkeypatch.setattr(any_form, 'OF_FORM', np.array([0.3]))
    monkeypatch.setattr(any_form, 'BY_POSE', np.array([0.5]))
    random = np.random.default_rng(4)
    own, by_pose, form = random.normal(size=(3, 9, 6))
    views = np.array([0, 1, 2, 0, 1, 2, 2, 1, 0])
    values = random.normal(size=9)
    known = own @ own.T + np.eye(9)
    volumes = random.random(9)
    prices = random.random(9)
    sight = Sight(values, own, np.eye(6), by_pose, form, views, volumes, prices, np.zeros(9))
    covariance = known + 0.25 * by_pose @ by_pose.T + 0.09 * form @ form.T
    for view in range(3):
        here, others = views == view, views != view
        gain = covariance[np.ix_(here, others)] @ np.linalg.inv(covariance[np.ix_(others, others)])
        spread = covariance[np.ix_(here, here)] - gain @ covariance[np.ix_(others, here)]
        expected = multivariate_normal.logpdf(values[here], gain @ values[others], spread)
        found = sight.level() - sight.without(view).level()
        expected -= 0.5 * (volumes + prices)[here].sum()
        assert found == pytest.approx(expected + 1.5 * np.log(2.0 * np.pi))


@pytest.mark.parametrize('bias', [0.0, 0.003])
def test_a_second_effect_that_is_there_is_seen_beside_the_first(pair, basis, bias):
    added = _adds(pair, basis, (0.0, 0.0, 0.0), bias)
    assert (added.log_evidence > 8.0) == (bias > 0.0)
    assert (added.log_transfer > 4.0) == (bias > 0.0)


def _with_standing_error(fit: Refit, noise: NoiseModel, size: float, seed: int) -> Refit:
    """Return a fit to what a sensor reads whose smooth error stands in the image of all poses.

    Args:
        fit: of poses whose patches are at the same places.
        noise: that is believed of the sensor; what stands of it goes to where that is counted.
        size: of the error [m].
        seed: of its draw.
    """
    groups = []
    for group in fit.groups:
        patches = group.patches
        if group.kind == 'depth':
            own = np.random.default_rng(seed)
            shared = kernel(patches.centers, noise.smooth_length, is_mixed=noise.is_mixed)
            error = own.multivariate_normal(np.zeros(len(shared)), size**2 * shared)
            patches = replace(
                patches,
                values=patches.values + error,
                covariance=patches.covariance - noise.standing * noise.smooth**2 * shared,
                standing=noise.depth_standing(len(shared)),
            )
        groups.append(replace(group, patches=patches))
    return replace(fit, groups=groups)


@pytest.mark.parametrize(
    ('bias', 'size', 'is_stated'),
    [
        (0.0, 0.0012, False),
        (0.0, 0.0008, True),
        (0.006, 0.0002, False),
        (0.006, 0.0002, True),
    ],
)
@pytest.mark.slow_but_first
def test_what_a_worse_sensor_reads_is_no_second_effect(pair, basis, bias, size, is_stated):
    noise = replace(pair.evaluator.noises[0], standing=0.9, is_stated=is_stated)
    poses, places = _in_poses(pair, (0.0, 0.0, 0.0), bias)
    alone = pair.added[:1]

    def added(fit, factors):
        both, one = (
            explained(
                fit,
                pair.added,
                kept,
                ways_at(places, fit, basis, kept),
                [noise] * len(_POSES),
                factors,
            )
            for kept in (pair.added, alone)
        )
        return both.above([one]).log_evidence

    read = [_with_standing_error(poses, noise, size, seed) for seed in range(8)]
    fixed = np.array([added(fit, (1.0,)) for fit in read])
    free = np.array([added(fit, size_factors([noise])) for fit in read])
    assert fixed.max() > 30.0, 'by a good sensor something is there'
    assert np.all(free > 8.0) if bias else np.all(free < 8.0)


@pytest.mark.parametrize('larger', [1.0, 4.0])
def test_sizes_of_an_error_are_weighed_by_their_whole_density(pair, basis, larger, monkeypatch):
    """One that is as believed is not taken for one four times as large, which leaves less."""
    monkeypatch.setattr(second_effect, 'log_beliefs', lambda _, factors: np.zeros(len(factors)))
    noise = replace(pair.evaluator.noises[0], standing=0.9)
    poses, places = _in_poses(pair, (0.0, 0.0, 0.0))
    gained = []
    for seed in range(6):
        fit = _with_standing_error(poses, noise, larger * noise.smooth, seed)
        ways = ways_at(places, fit, basis, pair.added)
        one, both = (
            explained(fit, pair.added, pair.added, ways, [noise] * len(_POSES), factors)
            for factors in ((1.0,), (1.0, 4.0))
        )
        gained.append(both.log_evidence - one.log_evidence)
    assert (np.mean(gained) > np.log(2.0)) == (larger > 1.0)


def test_what_a_single_pose_cannot_tell_is_not_asked_of_it(tilted, pair, basis):
    added = second_effect.second_adds([tilted], pair, basis)
    assert added.log_transfer == np.inf
    assert added.log_evidence < 8.0, 'nothing but the tilt is there'


@pytest.mark.parametrize('amounts', [(-0.2, 0.05, 0.15), (0.1, -0.2, 0.1)])
def test_an_amplitude_that_differs_from_pose_to_pose_is_no_second_effect(pair, basis, amounts):
    assert _adds(pair, basis, amounts, 0.0).log_evidence < 8.0
    fit, places = _in_poses(pair, amounts)
    tilt = pair.added[:1]
    ways = ways_at(places, fit, basis, tilt)
    same = replace(ways, by_pose=tuple(own[:, :0] for own in ways.by_pose))
    free, bound = (explained(fit, pair.added, tilt, own) for own in (ways, same))
    assert free.log_evidence > bound.log_evidence + 4.0


def test_a_lens_is_a_form_of_a_camera_that_is_off(screened, basis):
    camera = refitted_with(screened, 'camera_offset')
    fit = camera.fit
    names = [fit.parameters.names.index(name) for name in ('rigid_offset.x', 'rigid_offset.y')]
    coordinates = fit.coordinates.copy()
    coordinates[names] = 0.008, -0.005
    places = places_of(camera.evaluator.model, fit.groups, basis.points)
    bent = []
    for group, place in zip(fit.groups, places, strict=True):
        from_middle = place.across - np.array([0.45, 0.2])
        outwards = 0.03 * (from_middle**2).sum(axis=1)[:, None] * from_middle
        values = (group.patches.jacobian[:, names] * outwards).sum(axis=1)
        bent.append(replace(group, patches=replace(group.patches, values=values)))
    seen = replace(fit, coordinates=coordinates, groups=bent)
    lens = ways_at(places, seen, basis, camera.added)
    count = [len(own) for own in lens.form]
    nothing = tuple(np.zeros((n, 0)) for n in count)
    rigid = Ways(nothing, nothing)
    found = [explained(seen, camera.added, camera.added, own) for own in (rigid, lens)]
    assert found[1].log_evidence > found[0].log_evidence + 8.0
