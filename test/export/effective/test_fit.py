# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effective moduli: they make the simulator's body lie where the calibrated one does."""

from dataclasses import replace

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.cli.options.effective_option import SIMULATORS as LISTED
from diffcal_ros.errors import InputError
from diffcal_ros.export.effective import fit as fit_module
from diffcal_ros.export.effective.fit import fit_effective
from diffcal_ros.export.effective.simulators import find_run, find_simulator, SIMULATORS
from diffcal_ros.export.effective.target_scene import placed_observations
from diffcal_ros.export.effective_numbers import EffectiveNumbers, with_effective
from diffcal_ros.export.exported_body import exported_body
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.rigid_transform import apply
import numpy as np
import pytest
from support.scenes import beam_scene, MODULUS, noisy, observation, true_depth

from .conftest import calibrated, settle_linear

SVK = 'st_venant_kirchhoff'


@pytest.fixture(scope='module')
def modelled(beam):
    """The beam for a simulator that is only modelled."""
    return fit_effective(beam.calibration, beam.result, beam.fitted, find_simulator('sofa'))


def sag(positions, body):
    return np.linalg.norm(positions - body.mesh.rest_positions, axis=1).max()


def test_the_command_lists_the_simulators():
    assert tuple(SIMULATORS) == LISTED
    assert find_run(find_simulator('sofa')) is None
    with pytest.raises(InputError, match="simulator is 'unity': use one of mujoco, newton"):
        find_simulator('unity')


def test_the_effective_modulus_is_lower_and_leaves_less(beam, modelled):
    (modulus,) = modelled.moduli
    assert modulus.material == pytest.approx(MODULUS, rel=0.05)
    assert modulus.effective < 0.95 * modulus.material
    first, second = modelled.poissons_ratios['part_0']
    assert (first, second < first) == (0.45, True)
    # With the material's modulus most of the body is beyond the truncation of the gap.
    assert modelled.gap_material.coverage < 0.5 < 0.95 < modelled.gap_effective.coverage
    assert modelled.off_effective < 0.25 * modelled.off_material
    assert modelled.gap_own is beam.result.gap_end


def test_the_exported_body_sags_as_far_as_the_calibrated_one(beam, modelled):
    """By another route: the numbers go into the asset, and the asset is simulated alone."""
    body = exported_body(beam.fitted, beam.fitted.observations[0])
    numbers = EffectiveNumbers(
        {'': modelled.moduli[0].effective},
        {name: own for name, (_, own) in modelled.poissons_ratios.items()},
    )
    effective = with_effective(body, numbers)
    (world,) = beam.calibration.model.worlds(beam.calibration.coordinates)
    calibrated_sag = sag(world[: body.mesh.vertex_count], body)
    assert sag(settle_linear(body, SVK), body) < 0.9 * calibrated_sag
    assert sag(settle_linear(effective, SVK), body) == pytest.approx(calibrated_sag, rel=0.03)
    assert effective.mass == body.mass


def test_swings_die_out_as_fast_whatever_the_elements_need(beam):
    """Rayleigh's factor is damping over stiffness: of bodies that are as stiff it is the same."""
    body = exported_body(beam.fitted, beam.fitted.observations[0])
    body = replace(body, damping=np.full(body.mesh.tet_count, 90.0))
    moduli, ratios = {'': 0.6 * body.region_moduli[0]}, {'part_0': 0.2}
    softer = with_effective(body, EffectiveNumbers(moduli, ratios))
    np.testing.assert_allclose(softer.stiffness_damping, body.stiffness_damping, rtol=1e-12)
    assert softer.damping.max() < 0.8 * body.damping.min()
    found = with_effective(body, EffectiveNumbers(moduli, ratios, {'': 70.0}))
    np.testing.assert_array_equal(found.damping, np.full(body.mesh.tet_count, 70.0))


def test_errors_are_carried_over_in_proportion(beam, modelled):
    (modulus,) = modelled.moduli
    fitted = beam.result['youngs_modulus']
    statistical = np.sqrt(fitted.std_error**2 - fitted.mesh_error**2) / fitted.value
    assert modulus.effective_std / modulus.effective >= statistical * (1 - 1e-12)
    assert modulus.effective_std < modulus.material_std


def test_cameras_stay_where_the_fit_found_them(beam):
    """The pose that is passed on sees every point where the fit's offset put it."""
    calibration = beam.calibration
    (placed,) = placed_observations(calibration, calibration.coordinates)
    (world,) = calibration.model.worlds(calibration.coordinates)
    seen = calibration.model.views(calibration.coordinates)[0].points
    np.testing.assert_allclose(apply(placed.depth_from_world, world), seen, atol=1e-12)
    offset = calibration.model.cameras.rigid_offset(calibration.coordinates)
    assert np.abs(offset).max() > 1e-5


def test_a_simulator_that_is_run_gives_the_modulus_of_its_law(beam, modelled, monkeypatch):
    """Run as a black box, this package's own elements need what they need when modelled."""
    monkeypatch.setattr(
        fit_module, 'find_run', lambda _: lambda body, start: settle_linear(body, SVK)
    )
    run = fit_effective(beam.calibration, beam.result, beam.fitted, find_simulator('sofa'))
    assert (run.is_run, modelled.is_run) == (True, False)
    assert run.moduli[0].effective == pytest.approx(modelled.moduli[0].effective, rel=1e-3)
    assert run.off_effective == pytest.approx(modelled.off_effective, rel=0.01)


def test_mujoco_itself_gives_the_modulus_of_its_law(beam, modelled):
    pytest.importorskip('mujoco', reason='mujoco is not installed')
    run = fit_effective(beam.calibration, beam.result, beam.fitted, find_simulator('mujoco'))
    assert run.is_run
    assert run.way == 'mujoco itself, derivatives by differences'
    assert run.moduli[0].effective == pytest.approx(modelled.moduli[0].effective, rel=2e-3)
    assert run.gap_effective.rms == pytest.approx(modelled.gap_effective.rms, rel=0.02)


def test_linear_elements_that_were_calibrated_need_no_other_modulus():
    scene = beam_scene(element=Element.LINEAR, modulus=75e3)
    depth = noisy(true_depth(), np.random.default_rng(3))
    own = calibrated(scene, depth)
    found = fit_effective(own.calibration, own.result, own.fitted, find_simulator('newton'))
    value = own.result['youngs_modulus'].value
    # Each of the two fits may end a tenth of a standard error from the minimum.
    effective = found.moduli[0]
    assert effective.effective == pytest.approx(value, abs=0.2 * effective.effective_std)
    assert effective.effective_std < 0.03 * value
    assert found.poissons_ratios['part_0'] == pytest.approx((0.45, 0.45), rel=1e-12)
    (world,) = own.calibration.model.worlds(own.calibration.coordinates)
    depth_of_sag = sag(world[: scene.mesh.vertex_count], scene)
    assert found.off_effective < 0.2 * effective.effective_std / value * depth_of_sag


@pytest.mark.parametrize(
    ('change', 'words'),
    [
        ({'effects': {'gravity_tilt': {'a': 0.01}}}, r'the scene has effects \(gravity_tilt\)'),
        ({}, ''),
    ],
)
def test_a_scene_beyond_a_run_is_modelled_and_that_is_said(beam, monkeypatch, change, words):
    monkeypatch.setattr(fit_module, 'find_run', lambda _: lambda body, start: start)
    scene = replace(beam.fitted, **change)
    is_run, notes = fit_module._choose(scene, find_simulator('mujoco'))
    assert is_run == (not change)
    assert len(notes) == len(change)
    assert all(words.replace('\\', '') in note for note in notes)


def test_a_package_that_is_missing_is_named(beam, monkeypatch):
    monkeypatch.setattr(fit_module, 'find_run', lambda _: None)
    _, (note,) = fit_module._choose(beam.fitted, find_simulator('mujoco'))
    assert "`pip install 'diffcal_ros[mujoco]'` runs it" in note


def test_without_a_modulus_there_is_nothing_to_find(beam):
    scene = beam_scene(fit=('rigid_offset',))
    calibration = Calibration(scene, [observation(true_depth())], CalibrationSettings())
    with pytest.raises(InputError, match="add youngs_modulus to 'fit'"):
        fit_effective(calibration, beam.result, scene, find_simulator('sofa'))
