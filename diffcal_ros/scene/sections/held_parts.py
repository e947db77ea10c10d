# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The clamped parts of the body: which vertices they hold and how they turn."""

from collections.abc import Sequence
from itertools import combinations
import math

from diffcal_ros.scene.model import HeldPart, Turn
from diffcal_ros.scene.reading.section import Section
from diffcal_ros.scene.reading.selections import read_selection, select_vertices, selection_shape
from diffcal_ros.scene.reading.shapes import Interval, Keys, Number, vector
from diffcal_ros.scene.sections.placement import NEAR
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

# Held vertices nearer to one line than this share of their spread can turn about it.
_LINE_TOLERANCE = 1e-3
_TURNS = Interval(-3600.0, 3600.0)

TURN_SHAPE = Keys(
    {
        'axis': vector(3, 'direction in the world frame', NEAR),
        'angle_deg': Number('may exceed 360', _TURNS),
        'center': vector(3, "in m, world frame; default: the middle of the part's box", NEAR),
        'translation': vector(3, 'afterwards, in m, world frame', NEAR),
    },
    ('axis', 'angle_deg'),
    "how a held part moves from the mesh's rest shape to the pose that is filmed",
)
HELD_SHAPE = Keys(
    about='the clamp: parts of the body that are held',
    named=Keys({**selection_shape('vertices'), 'turn': TURN_SHAPE}),
    fewest=1,
)


def read_held(scene: Section, mesh: TetMesh | None) -> tuple[HeldPart, ...]:
    """Read `held`; without a mesh only what is written is looked at."""
    if not scene.required('held', 'name the clamped part, for example {clamp: {box: {x: [..]}}}'):
        return ()
    section = scene.child('held')
    if section is None:
        return ()
    parts = []
    for name in section.names:
        if not section.has(name):
            section.wrong(name, 'give a box or vertices')
            continue
        part = section.child(name)
        if part is not None:
            parts += _read_part(part, name, mesh)
    if not section.names:
        section.problems.add(section.key, 'is empty: hold at least one part')
    elif mesh is not None and section.is_sound:
        check_shared_vertices(parts, section)
        check_hold(section, mesh, parts)
    return tuple(parts)


def _read_part(part: Section, name: str, mesh: TetMesh | None) -> list[HeldPart]:
    selection = read_selection(part, 'vertices')
    turn_section = part.child('turn')
    turn = None if turn_section is None else read_turn(turn_section)
    part.refuse_unknown()
    if selection is None and part.is_sound:
        part.problems.add(part.key, 'holds nothing: give a box or vertices')
    if selection is None or mesh is None or not part.is_sound:
        return []
    vertices = select_vertices(selection, mesh)
    return [HeldPart(name, vertices, turn)] if part.is_sound else []


def read_turn(section: Section) -> Turn | None:
    """Read {axis, angle_deg, center, translation}; None when a mistake was noted."""
    axis = section.vector('axis', needed='give a direction in the world frame, [x, y, z]')
    degrees = section.number('angle_deg', needed='give the angle in degrees, within ten turns')
    in_world = 'give three numbers in metres in the world frame, [x, y, z]'
    has_center, has_translation = section.has('center'), section.has('translation')
    center = section.vector('center', needed=in_world) if has_center else None
    translation = (
        section.vector('translation', needed=in_world) if has_translation else np.zeros(3)
    )
    section.refuse_unknown()
    length = float(np.linalg.norm(axis))
    if section.is_sound and length < 1e-9:
        section.wrong('axis', 'give a direction that is not zero')
    if not section.is_sound:
        return None
    return Turn(axis / length, math.radians(degrees), center, translation)


def check_shared_vertices(parts: Sequence[HeldPart], section: Section) -> None:
    """Note two parts that hold the same vertex while one of them moves."""
    for first, second in combinations(parts, 2):
        if first.turn is None and second.turn is None:
            continue
        shared = np.intersect1d(first.vertices, second.vertices)
        if len(shared):
            section.problems.add(
                section.key,
                f'has {len(shared)} vertices that `{first.name}` and `{second.name}` both hold '
                f'while one of them turns (first: {shared[0]}): make the parts disjoint',
            )


def check_hold(section: Section, mesh: TetMesh, parts: Sequence[HeldPart]) -> None:
    """Note parts that together leave the body, or a piece of it, free to move as a whole."""
    held = np.unique(np.concatenate([part.vertices for part in parts]))
    if not _span_a_plane(mesh.rest_positions[held]):
        section.problems.add(
            section.key,
            f'holds {len(held)} vertices on one line: at least three that are not in line '
            'keep a body from turning',
        )
        return
    if len(held) == mesh.vertex_count:
        section.problems.add(
            section.key, f'holds all {len(held)} vertices: nothing is left to deform'
        )
    pieces = _pieces(mesh)
    for piece in np.unique(pieces):
        inside = held[pieces[held] == piece]
        if not _span_a_plane(mesh.rest_positions[inside]):
            section.problems.add(
                section.key,
                f'leaves a piece of {np.sum(pieces == piece)} vertices loose: the mesh falls '
                f'into {pieces.max() + 1} unconnected pieces, join them or hold each of them',
            )


def _span_a_plane(points: FloatArray) -> bool:
    if len(points) < 3:
        return False
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[1] > _LINE_TOLERANCE * spread[0])


def _pieces(mesh: TetMesh) -> IntArray:
    """Number the connected piece of each vertex, shape (V,)."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    edges, _ = mesh.edges
    size = (mesh.vertex_count, mesh.vertex_count)
    graph = coo_matrix((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=size)
    _, pieces = connected_components(graph, directed=False)
    return np.asarray(pieces, dtype=np.int32)
