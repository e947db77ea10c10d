# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Starts beyond the reach of tangents and of a robust fit."""

from dataclasses import replace

from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.diagnosis.screening.starts import more_starts
import numpy as np
import pytest
from support.scenes import beam_scene
from support.watched import watched

_STEP = 0.03  # More than the 20 mm at which a robust fit gives pixels up [m].


@pytest.fixture(scope='module')
def stepped():
    """One frame of a beam whose second half reads too far."""
    scene, seen = beam_scene((6, 2, 2)), watched(seed=5)
    evaluator, fit = fit_nominal(scene, [seen], None)
    view = evaluator.model.views(fit.coordinates)[0]
    is_second = evaluator.comparers[0].is_second(view.trace)
    depth = seen.depth.copy()
    window = depth[view.trace.rows, view.trace.columns]
    window[is_second & np.isfinite(view.trace.depth)] += _STEP
    single = replace(seen, depth=depth, frame_count=1, noise=float('nan'))
    return scene, *fit_nominal(scene, [single], None)


def test_the_step_between_materials_is_read_from_the_residuals(stepped):
    scene, evaluator, fit = stepped
    listed = [c for c in candidates(scene) if c.identifier == 'depth_bias_by_region']
    plain, proposed = more_starts(evaluator, fit, listed)
    assert plain == {}
    assert proposed['depth_bias_by_region.bias'] == pytest.approx(_STEP, abs=0.003)


def test_the_step_is_read_before_the_fit_too_where_that_followed_it(stepped):
    scene, evaluator, fit = stepped
    names = evaluator.model.parameters.names
    first = evaluator.model.parameters.start()
    misled = fit.coordinates.copy()
    misled[names.index('youngs_modulus')] += np.log(4.0)  # The second half lies along the rest.
    listed = [c for c in candidates(scene) if c.identifier == 'depth_bias_by_region']
    starts = more_starts(evaluator, replace(fit, coordinates=misled), listed)
    assert starts[0] == {}
    steps = [start['depth_bias_by_region.bias'] for start in starts[1:]]
    assert len(steps) == 2
    assert abs(steps[1] - _STEP) < abs(steps[0] - _STEP)
    assert starts[2]['youngs_modulus'] == first[names.index('youngs_modulus')]


def test_a_step_beyond_a_robust_fit_is_found(stepped):
    scene, evaluator, fit = stepped
    listed = [c for c in candidates(scene) if c.identifier == 'depth_bias_by_region']
    found = try_effects(evaluator, fit, listed, {})
    assert found is not None
    value = found.amplitudes(listed[0])[0].value
    assert value == pytest.approx(1e3 * _STEP, abs=2.0)


def test_other_effects_have_the_starts_of_their_tangents(stepped):
    scene, evaluator, fit = stepped
    listed = [c for c in candidates(scene) if c.identifier == 'clamp_offset'][:1]
    assert more_starts(evaluator, fit, listed) == [{}]
