# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What effects may do besides: as large as what they do, and of their own kind."""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.model_comparison.form_ways import Ways, ways_of
from diffcal_ros.diagnosis.model_comparison.hypothesis import Hypothesis
from diffcal_ros.diagnosis.patch_fits.refit import Refit
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.diagnosis.screening.screening import library_groups
from diffcal_ros.effects.registry import EFFECTS
import numpy as np
import pytest


def _size(columns: list[np.ndarray]) -> np.ndarray:
    return np.sqrt(np.mean(np.concatenate(columns) ** 2, axis=0))


def test_a_clamp_that_gives_way_may_move_as_one_that_is_off(screened, basis):
    """Two routes: motions of the clamp in the world, and the offset's amplitudes in its frame."""
    evaluator, nominal, _ = screened
    offset = [own for own in candidates(evaluator.model.scene) if own.identifier == 'clamp_offset']
    names, groups = library_groups(evaluator, nominal.coordinates, offset)
    first = len(nominal.coordinates)
    own = [first + n for n, name in enumerate(names) if name.startswith('clamp_offset.')]
    expected = np.concatenate([group.patches.jacobian[:, own] for group in groups])
    moved = [np.full(len(group.patches.values), 0.002) for group in groups]
    found = basis.besides_of(EFFECTS['compliant_clamp'], groups, moved)
    columns = np.concatenate(found)
    weights, *_ = np.linalg.lstsq(expected, columns, rcond=None)
    assert columns.shape[1] == 6
    assert np.abs(columns - expected @ weights).max() < 1e-3 * np.abs(columns).max()
    # What is hardly seen, as a turn about the body's own axis, is not blown up.
    sizes = _size(found)
    assert (sizes < 0.002 * 1.001).all()
    assert sizes.max() == pytest.approx(0.002)


def test_only_what_says_so_does_anything_besides(screened, basis):
    _, nominal, _ = screened
    moved = [np.ones(len(group.patches.values)) for group in nominal.groups]
    for identifier, effect in EFFECTS.items():
        count = basis.besides_of(effect, nominal.groups, moved)[0].shape[1]
        assert (count > 0) == (identifier in {'compliant_clamp', 'contact_plane'}), identifier
        bends = basis.bends_of(effect, nominal.groups, moved)[0].shape[1]
        assert (bends > 0) == (effect.group == 'shape'), identifier


def test_what_does_nothing_in_a_pose_does_nothing_besides_there(screened, basis):
    _, nominal, _ = screened
    moved = [np.zeros(len(group.patches.values)) for group in nominal.groups]
    found = basis.besides_of(EFFECTS['contact_plane'], nominal.groups, moved)
    assert not np.concatenate(found).any()


@pytest.fixture(scope='module')
def stepped(screened) -> Hypothesis:
    evaluator, nominal, _ = screened
    listed = candidates(evaluator.model.scene)
    step = next(own for own in listed if own.identifier == 'depth_bias_by_region')
    start = {'depth_bias_by_region.bias': 0.004}
    return try_effects(evaluator, nominal, [step], start, max_iterations=1)


def test_a_step_of_depth_may_begin_before_its_border_or_after(screened, basis, stepped):
    evaluator = stepped.evaluator
    ways: Ways = ways_of(evaluator.model, stepped.fit, basis, stepped.added)
    slopes = [group.patches.jacobian[:, -1] for group in stepped.fit.groups]
    for group, slope, form in zip(stepped.fit.groups, slopes, ways.form, strict=True):
        if group.kind != 'depth':
            continue
        first = np.abs(slope) < 0.5
        # Where the library's error is none the step of another form is some.
        assert np.abs(form[first]).max() > 0.002
        assert not form[first][:, : form.shape[1] // 2].all()
    assert any(group.kind == 'depth' for group in stepped.fit.groups)


def test_an_amplitude_of_which_nothing_is_known_moves_nothing_by_itself(screened, basis):
    """A time in which something relaxes is no multiple of what it does."""
    evaluator, nominal, _ = screened
    tilt = next(own for own in candidates(evaluator.model.scene) if len(own.components) == 2)
    found = try_effects(evaluator, nominal, [tilt], {}, max_iterations=2)
    places = [found.fit.parameters.names.index(name) for name in tilt.names]
    assert all(abs(found.fit.coordinates[place]) > 0.0 for place in places)

    def form_of(fit: Refit) -> np.ndarray:
        return np.concatenate(ways_of(found.evaluator.model, fit, basis, [tilt]).form)

    listed = list(found.fit.parameters)
    second = listed[places[1]]
    unknown = replace(second.quantity, prior_mean=None, prior_std=None)
    listed[places[1]] = replace(second, quantity=unknown)
    without = found.fit.coordinates.copy()
    without[places[1]] = 0.0
    parameters = replace(found.fit.parameters, parameters=tuple(listed))
    told = form_of(replace(found.fit, parameters=parameters))
    assert np.allclose(told, form_of(replace(found.fit, coordinates=without)))
    assert not np.allclose(told, form_of(found.fit))
