# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a body lies on may be a bar below one place of it."""

from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.diagnosis.model_comparison.effect_refit import try_effects
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.patch_fits.refit import refit
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.diagnosis.screening.screening import screen
from diffcal_ros.diagnosis.screening.starts import more_starts
from diffcal_ros.effects.registry import EFFECTS
import numpy as np
import pytest
from support.scenes import beam_scene, MODULUS, observation, SIZE, true_depth
from support.watched import several_frames

PLACE, TOP = 0.5, -0.018


def _model(seen, settings, fit=('youngs_modulus',), counts=(8, 2, 2), modulus=MODULUS):
    scene = replace(beam_scene(counts, modulus=modulus), effects={'contact_plane': settings})
    parameters = make_parameters(scene, fit, with_edge_bias=False)
    return ForwardModel(scene, [seen], parameters)


def _heights(model):
    """Return height [m] and share of the free length of each node, shape (N,) each."""
    points = model.worlds(model.parameters.start())[0]
    rest = model.body(model.observations[0]).discretisation.rest_nodes
    return points[:, 1], model.effects.axes(0).fraction(rest)


@pytest.fixture(scope='module')
def on_bar():
    """A beam on a bar, from another mesh, seen for several frames."""
    model = _model(observation(true_depth()), {'height': TOP, 'at': PLACE}, counts=(10, 3, 3))
    view = model.views(model.parameters.start())[0]
    return several_frames(view.trace.full_depth(), np.random.default_rng(5))


def test_a_bar_bears_the_body_at_its_place_and_nowhere_else():
    seen = observation(true_depth())
    held, shares = _heights(_model(seen, {'height': TOP, 'at': PLACE}))
    flat, _ = _heights(_model(seen, {'height': TOP}))
    ahead = (shares - PLACE) * SIZE[0]
    clearance = held - (TOP - 0.5 * ahead**2 / 0.01)
    # A body that slopes touches what is round ahead of its top.
    assert clearance.min() == pytest.approx(0.0, abs=2e-4)
    assert abs(shares[clearance.argmin()] - PLACE) < 0.1
    # The rest hangs over it, as it cannot over a plane.
    assert held[shares > 0.9].min() < TOP - 0.005
    assert flat.min() == pytest.approx(TOP, abs=2e-4)


def test_points_follow_the_height_of_a_bar():
    model = _model(
        observation(true_depth()),
        {'at': PLACE},
        ('contact_plane.height', 'youngs_modulus'),
        counts=(4, 1, 1),
    )
    (place,) = (i for i, one in enumerate(model.parameters) if one.effect)
    here = model.parameters.start()
    here[place] = TOP
    exact = model.tangents(here)[0][place]
    assert np.abs(exact).max() > 0.5
    errors = []
    for step in (4e-5, 2e-5, 1e-5):
        ahead, behind = here.copy(), here.copy()
        ahead[place] += step
        behind[place] -= step
        ends = [model.solve(at).views[0].points for at in (ahead, behind)]
        errors.append(np.abs((ends[0] - ends[1]) / (2.0 * step) - exact).max())
    # What touches is the same set of nodes over these ways.
    assert max(errors) < 1e-2
    assert errors[-1] < 0.5 * errors[0] or errors[-1] < 1e-4


def test_a_plane_is_screened_everywhere_and_a_bar_at_its_places():
    listed = [own for own in candidates(beam_scene()) if own.identifier == 'contact_plane']
    planes = [own for own in listed if own.at is None]
    bars = [own for own in listed if own.at is not None]
    assert [own.components for own in planes] == [('height', 'a', 'b')]
    assert planes[0].settings == {}
    assert {own.components for own in bars} == {('height',)}
    assert [own.settings['at'] for own in bars] == list(EFFECTS['contact_plane'].screened_at)


def test_a_bar_is_tried_where_the_body_is_lowest_above_it(on_bar):
    evaluator, nominal = fit_nominal(beam_scene(), [on_bar], None)
    bars = {
        own.at: own
        for own in candidates(evaluator.model.scene)
        if own.identifier == 'contact_plane'
    }
    tried = {
        at: more_starts(evaluator, nominal, [own])[0]['contact_plane.height']
        for at, own in bars.items()
    }
    # The camera sees the side: the underside is within the picture of the outline.
    assert tried[PLACE] == pytest.approx(TOP, abs=0.003)
    assert tried[1.0] < TOP - 0.005
    assert tried[None] == pytest.approx(tried[1.0], abs=5e-3)


def test_a_bar_that_was_fitted_is_fitted_on_from_there(on_bar):
    evaluator, nominal = fit_nominal(beam_scene(), [on_bar], None)
    (bar,) = (
        own
        for own in candidates(evaluator.model.scene)
        if own.identifier == 'contact_plane' and own.at == PLACE
    )
    (name,) = bar.names
    first = try_effects(evaluator, nominal, [bar], {}, max_iterations=1)
    ended = {'youngs_modulus': np.log(0.9 * MODULUS), name: TOP + 0.001}
    on = try_effects(evaluator, nominal, [bar], ended, max_iterations=1)
    values = on.fit.values_by_name()
    assert {own: values[own] for own in ended} == pytest.approx(ended, rel=1e-9)
    assert abs(first.fit.values_by_name()[name] - ended[name]) > 5e-4


@pytest.mark.slow
def test_the_bar_at_its_place_explains_what_bars_elsewhere_do_not(on_bar):
    evaluator, nominal = fit_nominal(beam_scene(), [on_bar], None)
    listed = candidates(evaluator.model.scene)
    scores = {
        score.candidate.at: score.gain
        for score in screen(evaluator, nominal.coordinates, listed).scores
        if score.candidate.identifier == 'contact_plane'
    }
    assert scores[None] >= max(scores.values()) - 1e-6
    fits = {}
    for at in (0.25, PLACE, 0.875):
        model = _model(on_bar, {'at': at}, ('contact_plane.height', 'youngs_modulus'))
        own = evaluator.of(model)
        start = model.parameters.start()
        (place,) = (i for i, one in enumerate(model.parameters) if one.effect)
        start[place] = TOP - 0.001
        fits[at] = refit(own, start)
    best = max(fits, key=lambda at: fits[at].log_evidence)
    assert best == PLACE
    height = fits[PLACE].parameters.names.index('contact_plane.height')
    # Nodes are 7.5 mm apart: between two of them the top falls by 0.7 mm.
    assert fits[PLACE].coordinates[height] == pytest.approx(TOP, abs=1e-3)
