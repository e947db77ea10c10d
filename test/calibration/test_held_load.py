# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A load that is held for long: rest in every frame, creep in its tangents, absence of it."""

from dataclasses import replace

from diffcal_ros.calibration.forward.forward_model import ForwardModel
from diffcal_ros.diagnosis.screening.candidates import candidates
from diffcal_ros.scene.model import QUASI_STATIC, Scene
import numpy as np
import pytest
from support.moving_beams import moving_model, moving_scene, slope_errors

TIMES = (0.02, 1.0, 4.0, 20.0)
PAIR = {'creep.share': 0.2, 'creep.tau': 3.0}
# Equilibria are found to 1e-9 m.
_SLOPE = 1e-4


def held_scene(fit: tuple[str, ...], counts: tuple[int, int, int] = (6, 2, 2)) -> Scene:
    return moving_scene(counts, modulus=150e3, fit=fit, integrator=QUASI_STATIC)


def _model(fit: tuple[str, ...]) -> tuple[ForwardModel, np.ndarray]:
    model = moving_model(held_scene(fit), TIMES)
    start = model.parameters.start()
    for place, name in enumerate(model.parameters.names):
        start[place] = PAIR.get(name, start[place])
    return model, start


def test_the_body_sags_on_while_it_creeps() -> None:
    model, start = _model(('creep',))
    sag = model.at(start).states[0].positions[:, :, 1].min(axis=1)
    assert sag[0] > sag[1] > sag[2] > sag[3]


@pytest.mark.slow
def test_tangents_of_all_frames() -> None:
    model, start = _model(('youngs_modulus', 'creep', 'release_time', 'gravity_tilt'))
    for place, parameter in enumerate(model.parameters):
        errors = slope_errors(model, start, place, (1e-2, 1e-3, 1e-4))
        # To first order in a tilt, which is a few degrees.
        assert min(errors) < (1e-2 if 'tilt' in parameter.name else _SLOPE), parameter.name


def test_no_creep_is_rest_bit_for_bit() -> None:
    plain = moving_model(held_scene(('rigid_offset',)), TIMES)
    there = moving_model(held_scene(('creep',)), TIMES)
    first, second = plain.views(plain.parameters.start()), there.views(there.parameters.start())
    for one, other in zip(first, second, strict=True):
        np.testing.assert_array_equal(one.points, other.points)


FITTED = (
    *('youngs_modulus', 'density', 'creep', 'release_time', 'clamp_offset', 'compliant_clamp'),
    *('added_mass', 'rest_curvature'),
)


def test_the_adjoint_agrees_with_the_tangents() -> None:
    model, start = _model(FITTED)
    tangents = np.stack(model.tangents(start))
    random = np.random.default_rng(1)
    by_points = [random.normal(size=tangents.shape[2:]) for _ in TIMES]
    pulled = model.pull_back(by_points, start)
    forward = np.einsum('skni,sni->k', tangents, np.stack(by_points))
    np.testing.assert_allclose(pulled, forward, rtol=1e-6)


def test_a_stated_pair_is_the_fitted_one() -> None:
    fitted, start = _model(('creep',))
    scene = replace(held_scene(('rigid_offset',)), effects={'creep': {'share': 0.2, 'tau': 3.0}})
    stated = moving_model(scene, TIMES)
    pairs = zip(fitted.views(start), stated.views(stated.parameters.start()), strict=True)
    for one, other in pairs:
        np.testing.assert_array_equal(one.points, other.points)


def test_creep_is_offered_for_held_loads_and_other_effects_for_swings() -> None:
    held = {c.identifier for c in candidates(held_scene(('youngs_modulus',)))}
    swinging = {c.identifier for c in candidates(moving_scene())}
    assert 'creep' in held
    assert not held & {'time_offset', 'air_drag'}
    assert 'creep' not in swinging
