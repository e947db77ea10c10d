# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""An exported body: moduli that a pull measures, masses where they are, groups of one material."""

from dataclasses import replace

from diffcal_ros.errors import InputError
from diffcal_ros.export.exported_body import constants_at_rest, exported_body
from diffcal_ros.export.material_groups import material_groups
from diffcal_ros.fem.laws import find_law, law_names
from diffcal_ros.material import lame_lambda, lame_mu, LameConvention, Material
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import HeldPart
import numpy as np
import pytest
from support.recorded_beam import write_beam_scene
from support.released_beam import CHANGES

MODULUS, NU = 80e3, 0.45


def material(shares, convention=LameConvention.CONSISTENT):
    return Material(np.array([MODULUS]), np.array([NU]), np.ones(1), convention, shares)


@pytest.mark.parametrize('law', law_names())
def test_consistent_moduli_stay_as_they_are(law):
    modulus, nu = constants_at_rest(material(find_law(law).CONVERSION))
    np.testing.assert_allclose([modulus[0], nu[0]], [MODULUS, NU], rtol=1e-12)


def test_the_papers_convention_is_exported_as_what_a_pull_measures():
    """Smith et al. 2018, equation 13, with plain Lame numbers, pulled by second differences."""
    mu, lam = lame_mu(MODULUS, NU), lame_lambda(MODULUS, NU)

    def energy(along, across):
        squares = (1.0 + along) ** 2 + 2.0 * (1.0 + across) ** 2
        growth = (1.0 + along) * (1.0 + across) ** 2 - 1.0 - 0.75 * mu / lam
        return 0.5 * (mu * (squares - 3.0 - np.log(squares + 1.0)) + lam * growth**2)

    h = 1e-3
    along = (energy(h, 0) - 2.0 * energy(0, 0) + energy(-h, 0)) / h**2
    across = (energy(0, h) - 2.0 * energy(0, 0) + energy(0, -h)) / h**2
    both = (energy(h, h) - energy(h, -h) - energy(-h, h) + energy(-h, -h)) / (4.0 * h**2)
    shares = find_law('stable_neo_hookean').CONVERSION
    modulus, nu = constants_at_rest(material(shares, LameConvention.PAPER))
    assert modulus[0] == pytest.approx(along - both**2 / across, rel=1e-4)
    assert nu[0] == pytest.approx(both / across, rel=1e-4)
    assert modulus[0] < 0.8 * MODULUS


def test_masses_are_where_the_tetrahedra_are(body):
    whole = (body.density * body.mesh.volumes).sum()
    assert body.mass == pytest.approx(whole, rel=1e-12)
    center = body.vertex_masses @ body.mesh.rest_positions / body.mass
    weights = body.density * body.mesh.volumes / whole
    np.testing.assert_allclose(center, weights @ body.mesh.centroids, rtol=1e-12)
    assert np.ptp(body.vertex_masses) > 0.0


def test_stiffness_damping_takes_the_same_power_out_of_a_bar_that_is_pulled(body):
    """A strain rate e, and -nu e across: both potentials, written out."""
    nu, rate = body.poissons_ratio, 0.7
    across = -nu * rate
    ours = 0.5 * body.damping * (rate**2 + 2.0 * across**2)
    rayleighs = 0.5 * body.stiffness_damping * body.youngs_modulus * rate**2
    np.testing.assert_allclose(rayleighs, ours, rtol=1e-12)


def test_a_region_is_one_group_and_a_field_several(body):
    groups = material_groups(body)
    assert [group.name for group in groups] == ['tip', 'root']
    assert [group.youngs_modulus for group in groups] == pytest.approx([60e3, 150e3], rel=1e-12)
    relative = np.exp(np.linspace(-0.2, 0.3, body.mesh.tet_count))
    groups = material_groups(replace(body, youngs_modulus=body.youngs_modulus * relative))
    assert len(groups) > 2
    tets = np.concatenate([group.tets for group in groups])
    assert np.array_equal(np.sort(tets), np.arange(body.mesh.tet_count))
    for group in groups:
        own = (body.youngs_modulus * relative)[group.tets]
        assert np.abs(own / group.youngs_modulus - 1.0).max() < 0.051


def test_only_what_stays_is_held_and_a_body_that_nothing_holds_is_refused(tmp_path):
    scene = load_scene(write_beam_scene(tmp_path, CHANGES))
    setup = scene.observations[0]
    body = exported_body(scene, setup)
    stays = np.unique(np.concatenate([part.vertices for part in setup.staying]))
    assert np.array_equal(body.held, stays)
    assert len(stays) < sum(len(part.vertices) for part in setup.held)
    let_go = replace(setup, held=tuple(HeldPart('hand', part.vertices) for part in setup.held))
    let_go = replace(let_go, motion=replace(setup.motion, released=('hand',)))
    with pytest.raises(InputError, match='needs a clamp that stays'):
        exported_body(scene, let_go)


def test_what_an_asset_cannot_have_is_said(tmp_path):
    changes = {
        'held.clamp.box': {'x': [0.1, 1.0]},
        'held.clamp.turn': {'axis': [1, 0, 0], 'angle_deg': 20},
        'effects': {'gravity_tilt': {'a': 0.01}},
    }
    scene = load_scene(
        write_beam_scene(tmp_path, {'held': {'clamp': {'box': {'x': [0.1, 1.0]}}}, **changes})
    )
    body = exported_body(scene, scene.observations[0])
    assert [note.split()[0] for note in body.notes] == ['the', 'effects']
    off = body.held_positions - body.mesh.rest_positions[body.held]
    assert np.abs(off).max() > 1e-3
