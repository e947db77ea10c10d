# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Upper limits: as from one explicit least-squares fit, and as from fits beside masses."""

from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.calibration.parameters.parameter_layout import make_parameters
from diffcal_ros.diagnosis.detection.limits import drawn_parameters, upper_limits
from diffcal_ros.diagnosis.nominal_fit import fit_nominal
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.diagnosis.screening.screening import screen
from diffcal_ros.effects.registry import EFFECTS
import numpy as np
import pytest
from support.scenes import beam_scene, observation, true_depth
from support.watched import several_frames

_WALL = 0.9  # [m]


def _tilt(screen):
    return next(s for s in screen.scores if s.candidate.identifier == 'gravity_tilt')


def test_a_limit_is_the_estimate_and_two_standard_errors(screened):
    screen = screened[2]
    score = _tilt(screen)
    normal = score.plain_columns.T @ score.plain_columns
    estimate = np.linalg.solve(normal, score.plain_columns.T @ score.plain_residual)
    spread = np.sqrt(screen.noise_scale * np.diag(np.linalg.inv(normal)))
    factor = EFFECTS['gravity_tilt'].component('a').shown_factor
    limits = upper_limits(screen)['gravity_tilt']
    expected = factor * (np.abs(estimate) + 1.96 * spread)
    assert [limits['a'], limits['b']] == pytest.approx(expected.tolist(), rel=1e-6)


def test_what_is_there_is_not_below_its_limit(screened):
    limits = upper_limits(screened[2])['gravity_tilt']
    assert max(limits['a'], limits['b']) > np.rad2deg(0.06)


def test_what_cannot_be_seen_has_no_limit(screened):
    screen = screened[2]
    score = _tilt(screen)
    blind = score.plain_columns.copy()
    blind[:, 1] = blind[:, 0]
    limits = upper_limits(replace(screen, scores=(replace(score, plain_columns=blind),)))
    assert limits['gravity_tilt'] == {'a': np.inf, 'b': np.inf}


def test_effects_beyond_tangents_have_none(screened):
    assert not {'contact_plane', 'strain_stiffening'} & set(upper_limits(screened[2]))


def _seen_with(mass: float):
    """Look at the beam with a mass that hangs on it [kg], and a wall behind."""
    scene = replace(beam_scene((6, 2, 2)), effects={'added_mass': {'mass': mass, 'at': 0.75}})
    parameters = make_parameters(scene, ('youngs_modulus',), with_edge_bias=False)
    plain = observation(true_depth())
    model = ForwardModel(scene, [plain], parameters)
    trace = model.views(parameters.start())[0].trace
    depth = np.full(plain.depth.shape, _WALL)
    depth[trace.rows, trace.columns] = np.nan_to_num(trace.depth, nan=_WALL)
    return several_frames(depth, np.random.default_rng(5))


@pytest.mark.slow
def test_a_modulus_follows_a_mass_as_tangents_say():
    scene = beam_scene((6, 2, 2))
    evaluator, nominal = fit_nominal(scene, [_seen_with(0.0)], None)
    masses = [c for c in candidates(scene) if c.identifier == 'added_mass']
    scores = screen(evaluator, nominal.coordinates, masses).scores
    (told,) = (score.follows[0, 0] for score in scores if score.candidate.at == 0.75)
    errors = []
    for mass in (0.004, 0.002, 0.001):
        _, beside = fit_nominal(scene, [_seen_with(mass)], None)
        slope = (beside.coordinates[0] - nominal.coordinates[0]) / mass
        errors.append(abs(slope / told - 1.0))
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 0.02
    assert told < -20.0  # Softer, by 2 % a gram.


def test_a_parameter_is_drawn_by_what_may_hide(screened):
    evaluator, _, screen = screened
    score = _tilt(screen)
    most = np.array([EFFECTS['gravity_tilt'].component(name).upper for name in 'ab'])
    # With what is known beforehand as observations more, and the modulus's response as it is.
    rows = np.vstack([score.plain_columns / np.sqrt(screen.noise_scale), np.diag(1.0 / most)])
    seen = np.append(score.plain_residual / np.sqrt(screen.noise_scale), [0.0, 0.0])
    estimate, *_ = np.linalg.lstsq(rows, seen, rcond=None)
    along = np.linalg.pinv(rows).T @ score.follows[0]
    expected = np.expm1(abs(score.follows[0] @ estimate) + 1.96 * np.linalg.norm(along))
    drawn = drawn_parameters(screen, evaluator.model.parameters)
    assert list(drawn) == ['youngs_modulus']
    assert drawn['youngs_modulus']['gravity_tilt'] == pytest.approx(expected, rel=1e-9)
    assert not {'contact_plane', 'strain_stiffening'} & set(drawn['youngs_modulus'])
