# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bodies of one mesh that are held alike share what is found for its pattern, wherever placed."""

from dataclasses import replace
import gc

from diffcal_ros.fem.elements import sparse_pattern
from diffcal_ros.fem.elements.element import discretise, Element
from diffcal_ros.fem.elements.sparse_pattern import make_pattern
from diffcal_ros.fem.linear_solvers.frontal_plan import make_plan
from diffcal_ros.fem.own_frame import moved_mesh
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
import pytest
from support.beams import beam_mesh, held_end
from support.bodies import GRAVITY, uniform_material

_COUNTS, _SIZE = (9, 4, 3), (0.09, 0.05, 0.02)


def _turn() -> np.ndarray:
    turn, _ = np.linalg.qr(np.random.default_rng(4).standard_normal((3, 3)))
    return turn * np.sign(np.linalg.det(turn))


def _placed(mesh: TetMesh) -> TetMesh:
    return mesh.placed(mesh.rest_positions @ _turn().T + [0.3, -1.2, 0.7])


@pytest.mark.parametrize('element', list(Element))
def test_a_body_that_is_placed_elsewhere_has_the_same_pattern_and_plan(element):
    mesh = beam_mesh(_COUNTS, _SIZE)
    held = held_end(mesh)
    there = moved_mesh(_placed(mesh), np.array([0.1, 0.0, 0.0]))
    one, two = (make_pattern(discretise(own, element), held) for own in (mesh, there))
    assert one is two
    assert make_plan(one) is make_plan(two)
    assert make_plan(one, 1) is not make_plan(one)


def test_what_is_held_otherwise_or_another_body_has_its_own():
    mesh = beam_mesh(_COUNTS, _SIZE)
    body, held = discretise(mesh, Element.LINEAR), held_end(mesh)
    first = make_pattern(body, held)
    joined = [np.array([0, len(mesh.rest_positions) - 1])]
    other = beam_mesh(_COUNTS, (0.09, 0.05, 0.021))
    others = [
        make_pattern(body, held[:-1]),
        make_pattern(body, held, coupled_nodes=joined),
        make_pattern(discretise(other, Element.LINEAR), held),
        make_pattern(discretise(mesh, Element.QUADRATIC), held),
        # Of a mesh that does not say that it is the same body nothing is known.
        make_pattern(
            discretise(TetMesh(_placed(mesh).rest_positions, mesh.tets), Element.LINEAR), held
        ),
    ]
    assert len({id(pattern) for pattern in (first, *others)}) == len(others) + 1


def test_nothing_is_kept_of_bodies_that_are_gone():
    gc.collect()
    before = len(sparse_pattern._known)
    mesh = beam_mesh((8, 4, 3), _SIZE)
    pattern = make_pattern(discretise(mesh, Element.LINEAR), held_end(mesh))
    make_plan(pattern)
    assert len(sparse_pattern._known) == before + 1
    del pattern
    gc.collect()
    assert len(sparse_pattern._known) == before


@pytest.mark.parametrize('solver', ['multifrontal', 'qdldl'])
def test_bodies_side_by_side_come_out_as_each_by_itself(solver, monkeypatch):
    """Two placements of one body under loads of their own, sharing a pattern and not."""
    mesh = beam_mesh(_COUNTS, _SIZE)
    places, loads = (mesh, _placed(mesh)), (GRAVITY, np.array([3.0, -5.0, 2.0]))

    def settled():
        bodies = [StaticBody(own, Element.LINEAR, held_end(mesh), solver=solver) for own in places]
        material = uniform_material(mesh, 60e3)
        for body, load in zip(bodies, loads, strict=True):
            body.solve_equilibrium(material, load)
        patterns = [body.solver.stiffness.pattern for body in bodies]
        return [body.state.positions for body in bodies], patterns[0] is patterns[1]

    together, is_shared = settled()
    monkeypatch.setattr(sparse_pattern, '_known', {})
    monkeypatch.setattr(sparse_pattern, '_digest', lambda *_: bytes(len(sparse_pattern._known)))
    apart, is_shared_then = settled()
    assert (is_shared, is_shared_then) == (True, False)
    for one, other in zip(together, apart, strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_placement_is_no_other_body():
    mesh = beam_mesh(_COUNTS, _SIZE)
    twice = _placed(_placed(mesh))
    np.testing.assert_array_equal(twice.layout, mesh.rest_positions)
    assert not np.allclose(twice.rest_positions, mesh.rest_positions)
    # Cut finer, or bent, it is one of its own.
    assert twice.refined()[0].as_given is None
    assert replace(mesh, rest_positions=2.0 * mesh.rest_positions).as_given is None
