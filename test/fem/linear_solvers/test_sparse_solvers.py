# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
import ctypes
import gc
from pathlib import Path
import resource

from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.linear_solvers import make_solver, NotPositiveDefiniteError, SOLVER_NAMES
import numpy as np
import pytest
from support.beams import beam_mesh
from support.bodies import GRAVITY, hanging_beam, uniform_material

NAMED = [name for name in SOLVER_NAMES if name != 'auto']


@pytest.fixture
def solver(request) -> str:
    """Name of a sparse solver that is installed."""
    try:
        make_solver(hanging_beam(Element.LINEAR).solver.stiffness.pattern, request.param)
    except ImportError:
        pytest.skip(f'{request.param} is not installed')
    return str(request.param)


def _resident() -> int:
    """Return how much memory is held [bytes], less what the allocator keeps for later."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    return int(Path('/proc/self/statm').read_text().split()[1]) * resource.getpagesize()


@pytest.mark.parametrize('solver', SOLVER_NAMES, indirect=True)
def test_every_solver_finds_the_same_equilibrium(solver) -> None:
    expected = hanging_beam(Element.LINEAR, solver='superlu')
    material = uniform_material(expected.mesh, 8e3)
    positions = expected.solve_equilibrium(material, GRAVITY).positions
    body = hanging_beam(Element.LINEAR, solver=solver)
    np.testing.assert_allclose(
        body.solve_equilibrium(material, GRAVITY).positions, positions, atol=1e-9
    )


@pytest.mark.parametrize('solver', NAMED, indirect=True)
def test_every_solver_refuses_an_indefinite_matrix(solver, random) -> None:
    pattern = hanging_beam(Element.LINEAR).solver.stiffness.pattern
    values = np.zeros(pattern.entry_count)
    values[pattern.diagonal_slots] = 1.0
    engine = make_solver(pattern, solver)
    engine.factor(values)
    right = random.normal(size=(pattern.size, 2))
    np.testing.assert_allclose(engine.solve(right), right)
    np.testing.assert_allclose(engine.solve(right[:, 0]), right[:, 0])
    values[pattern.diagonal_slots[pattern.size // 2]] = -1.0
    with pytest.raises(NotPositiveDefiniteError):
        engine.factor(values)


def test_unknown_solver_is_named_with_the_known_ones() -> None:
    with pytest.raises(ValueError, match="'cudss' is unknown: use one of auto, pardiso"):
        hanging_beam(solver='cudss')


@pytest.mark.parametrize('solver', NAMED, indirect=True)
@pytest.mark.slow_but_first
def test_a_solver_that_is_gone_gives_its_memory_back(solver) -> None:
    pattern = hanging_beam(Element.QUADRATIC, beam_mesh((8, 3, 3))).solver.stiffness.pattern
    values = np.zeros(pattern.entry_count)
    values[pattern.diagonal_slots] = 1.0

    def taken(count: int) -> int:
        """Return what so many solvers, one after the other, leave behind [bytes]."""
        before = _resident()
        for _ in range(count):
            make_solver(pattern, solver).factor(values)
        return _resident() - before

    taken(3)
    assert taken(20) < 2 * 8 * pattern.entry_count
