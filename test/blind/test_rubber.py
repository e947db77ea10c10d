# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rubbers beside the scene's: slopes of their energies, rest, and what is small."""

from dataclasses import replace

import numpy as np
import pytest
from support.blind_law import stress_change, stress_of

from benchmarks.blind.body import make_body
from benchmarks.blind.fibres import Fibres
from benchmarks.blind.hexahedra import mesh_hexahedra
from benchmarks.blind.material import (
    Constants,
    constants,
    respond,
)
from benchmarks.blind.rubber import draw_rubber, LAWS, Rubber
from benchmarks.blind.shapes import Shape

MODULUS, NU = 2.0e5, 0.47
SLANTED = (0.6, 0.48, 0.64)
RUBBERS = [
    Rubber('plain'),
    Rubber('compressible', poissons_less=-0.03),
    Rubber('fibres', share=0.2, direction=SLANTED),
    Rubber('mooney', share=0.25),
]
each_rubber = pytest.mark.parametrize('rubber', RUBBERS, ids=lambda rubber: rubber.law)


def _numbers(rubber: Rubber, nu: float = NU) -> Constants:
    return rubber.numbers(np.array(MODULUS), nu)


def _compliance(numbers: Constants) -> np.ndarray:
    """Return the compliance of small strains by stresses, shape (3, 3, 3, 3)."""
    step, stiffness = 1e-6, np.zeros((3, 3, 3, 3))
    for k in range(3):
        for m in range(3):
            strain = np.zeros((3, 3))
            strain[k, m] += 0.5 * step
            strain[m, k] += 0.5 * step
            ends = [stress_of(np.eye(3) + sign * strain, numbers) for sign in (1.0, -1.0)]
            stiffness[:, :, k, m] = (ends[0] - ends[1]) / (2.0 * step)
    # It maps symmetric to symmetric: turns have no stiffness.
    return np.linalg.pinv(stiffness.reshape(9, 9), rcond=1e-8).reshape(3, 3, 3, 3)


def _pulled(compliance: np.ndarray, along: np.ndarray) -> float:
    """Return Young's modulus along a direction."""
    return float(1.0 / np.einsum('i,j,ijkm,k,m', along, along, compliance, along, along))


@each_rubber
@pytest.mark.parametrize('step', [1e-4, 1e-5, 1e-6])
def test_stress_is_the_slope_of_the_energy(rubber: Rubber, step: float) -> None:
    random = np.random.default_rng(2)
    F = np.eye(3) + random.uniform(-0.15, 0.2, size=(3, 3))
    direction = random.standard_normal((3, 3))
    numbers = _numbers(rubber)
    high, low = (respond(F + sign * step * direction, numbers).energy for sign in (1.0, -1.0))
    expected = float(np.sum(stress_of(F, numbers) * direction))
    # Second order in the step, beside the rounding of energies.
    bound = (1e2 * step**2 + 1e-11 / step) * MODULUS
    assert abs((high - low) / (2.0 * step) - expected) < bound
    assert bound < 0.01 * abs(expected)


@each_rubber
def test_nothing_is_stressed_at_rest_or_by_a_turn(rubber: Rubber) -> None:
    numbers = _numbers(rubber)
    turn = np.linalg.qr(np.random.default_rng(5).standard_normal((3, 3)))[0]
    turn *= np.linalg.det(turn)
    for F in (np.eye(3), turn):
        assert np.abs(stress_of(F, numbers)).max() < 1e-9 * MODULUS
        assert abs(respond(F, numbers).energy) < 1e-9 * MODULUS


@pytest.mark.parametrize('nu', [0.3, 0.47])
@pytest.mark.parametrize('rubber', [RUBBERS[0], RUBBERS[3]], ids=lambda rubber: rubber.law)
def test_small_strains_know_the_stated_numbers_alone(rubber: Rubber, nu: float) -> None:
    found, stated = (_compliance(_numbers(one, nu)) for one in (rubber, Rubber()))
    assert np.allclose(found, stated, rtol=0.0, atol=1e-4 / MODULUS)
    assert _pulled(found, np.array(SLANTED)) == pytest.approx(MODULUS, rel=1e-4)


def test_compressible_rubber_has_its_modulus_at_its_own_poissons_ratio() -> None:
    found = _compliance(_numbers(RUBBERS[1]))
    assert _pulled(found, np.array(SLANTED)) == pytest.approx(MODULUS, rel=1e-4)
    assert -found[1, 1, 0, 0] * MODULUS == pytest.approx(NU - 0.03, rel=1e-4)


def test_fibres_stiffen_along_themselves_by_their_share_and_not_across() -> None:
    found = _compliance(_numbers(RUBBERS[2], 0.3))
    assert _pulled(found, np.array(SLANTED)) == pytest.approx(1.2 * MODULUS, rel=1e-4)
    # Where a pull leaves their length: sin^2 = 1 / (1 + nu) off them.
    across = np.cross(SLANTED, [0.0, 0.0, 1.0])
    across /= np.linalg.norm(across)
    angle = np.arcsin(np.sqrt(1.0 / 1.3))
    idle = np.cos(angle) * np.array(SLANTED) + np.sin(angle) * across
    assert _pulled(found, idle) == pytest.approx(MODULUS, rel=1e-4)


@pytest.mark.parametrize('step', [1e-4, 1e-5, 1e-6])
def test_stiffness_of_the_plain_law_is_the_slope_of_its_stress(step: float) -> None:
    random = np.random.default_rng(3)
    F = np.eye(3) + random.uniform(-0.15, 0.2, size=(3, 3))
    direction = random.standard_normal((3, 3))
    numbers = _numbers(RUBBERS[0])
    ends = [F + sign * step * direction for sign in (1.0, -1.0)]
    change = stress_change(F, numbers, direction, step)
    expected = np.subtract(*(stress_of(end, numbers) for end in ends)) / (2.0 * step)
    assert np.allclose(change, expected, rtol=0.0, atol=1e-5 * np.abs(expected).max())


@pytest.mark.parametrize('step', [1e-5, 1e-6, 1e-7])
def test_stiffness_of_a_body_with_fibres_is_the_slope_of_its_forces(step: float) -> None:
    breaks = ((0.0, 0.01, 0.03), (-0.008, 0.008), (-0.007, 0.007))
    shape = Shape('beam', breaks, np.ones((2, 1, 1), dtype=bool), 0.01)
    mesh, random = mesh_hexahedra(shape, 0.5), np.random.default_rng(7)
    modulus = np.full((len(mesh.cells), 8), MODULUS)
    # Nothing but fibres, so that no other term hides a slip in theirs.
    numbers = replace(
        constants(1e-12 * modulus, 0.0), fibres=Fibres(0.1 * modulus, np.array(SLANTED))
    )
    body = make_body(mesh.nodes, mesh.cells, mesh.held, numbers, 1000.0)
    places = mesh.nodes + random.uniform(-4e-4, 4e-4, size=mesh.nodes.shape)
    move = random.standard_normal(mesh.nodes.shape)
    ends = [body.evaluate(places + sign * step * move).gradient for sign in (1.0, -1.0)]
    blocks = body.evaluate(places).blocks
    assert blocks is not None
    own = move[mesh.cells].reshape(len(mesh.cells), 60)
    parts = (blocks @ own[..., None]).reshape(len(mesh.cells), 20, 3)
    found = np.zeros_like(move)
    np.add.at(found, mesh.cells, parts)
    expected = (ends[0] - ends[1]) / (2.0 * step)
    scale = np.abs(expected).max()
    # A fibre's force is a cubic of the places: second order in the step.
    assert np.abs(found - expected).max() < (1e7 * step**2 + 1e-6) * scale


def test_what_is_turned_inside_out_has_no_plain_energy() -> None:
    law = respond(np.diag([-0.5, 1.0, 1.0]), _numbers(RUBBERS[0]))
    assert law.energy == np.inf


@pytest.mark.parametrize('law', LAWS)
def test_rubbers_are_drawn_in_their_range(law: str) -> None:
    drawn = [draw_rubber(law, np.random.default_rng(seed)) for seed in range(20)]
    assert {rubber.law for rubber in drawn} == {law}
    assert all(-0.04 <= rubber.poissons_less <= 0.0 for rubber in drawn)
    assert all(0.0 <= rubber.share <= 0.3 for rubber in drawn)
    assert np.allclose([np.linalg.norm(rubber.direction) for rubber in drawn], 1.0)


@pytest.mark.parametrize(
    ('law', 'name'),
    [('compressible', 'poissons_less'), ('mooney', 'share'), ('fibres', 'direction')],
)
def test_rubbers_are_drawn_anew(law: str, name: str) -> None:
    drawn = [draw_rubber(law, np.random.default_rng(seed)) for seed in range(20)]
    assert len({str(getattr(rubber, name)) for rubber in drawn}) > 15


def test_an_unknown_law_says_which_there_are() -> None:
    with pytest.raises(ValueError, match='stable, plain, compressible, fibres, mooney'):
        draw_rubber('foam', np.random.default_rng(0))
