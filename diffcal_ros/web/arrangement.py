# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a person arranges on the page: where the body is, what of it is held, and its stiffness."""

from dataclasses import dataclass, replace

from diffcal_ros.proposal.draft import Draft
from diffcal_ros.proposal.hold import Hold, possible_holds
from diffcal_ros.proposal.place_fit import CLAMP
from diffcal_ros.rigid_transform import rotation_matrix, rotation_vector, transform
from diffcal_ros.scene.model import HeldPart, Quantity, Scene
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

_BY_HAND = 'Set by hand on the page of `diffcal init --web`.'
_AXES = 'xyz'
# Two ends whose directions differ by less than this are one [1 - cos].
_SAME = 1e-6
# Changes below what a scene file holds are none: of places [m, rad] and planes [m].
_GRAIN = 5e-6


@dataclass(frozen=True)
class Arrangement:
    """A body in its place, held, of some modulus.

    Attributes:
        world_from_object: shape (4, 4).
        hold: what is held.
        youngs_modulus: where a fit starts [Pa].
    """

    world_from_object: FloatArray
    hold: Hold
    youngs_modulus: float

    @property
    def translation(self) -> FloatArray:
        """Of the place [m], shape (3,)."""
        return self.world_from_object[:3, 3].copy()

    @property
    def turn(self) -> FloatArray:
        """Of the place, axis times angle [rad], shape (3,)."""
        return rotation_vector(self.world_from_object[:3, :3])

    def placed(self, translation: FloatArray, turn: FloatArray) -> 'Arrangement':
        """Return the same body elsewhere.

        Args:
            translation: [m], shape (3,).
            turn: axis times angle [rad], shape (3,).
        """
        there = transform(rotation_matrix(np.asarray(turn, float)), np.asarray(translation, float))
        return replace(self, world_from_object=there)

    def held_from(self, plane: float) -> 'Arrangement':
        """Return the same with the clamp beginning elsewhere along its direction [m]."""
        return replace(self, hold=self.hold.moved(plane))

    def scene(self, scene: Scene) -> Scene:
        """Return a scene of one region with all its observations arranged so."""
        held = (HeldPart(CLAMP, self.hold.vertices(scene.mesh)),)
        region = scene.regions[0]
        usual = region.youngs_modulus
        start = float(np.clip(self.youngs_modulus, usual.lower, usual.upper))
        return replace(
            scene,
            observations=tuple(
                replace(setup, world_from_object=self.world_from_object, held=held)
                for setup in scene.observations
            ),
            regions=(replace(region, youngs_modulus=Quantity(start, usual.lower, usual.upper)),),
        )

    def problem(self, mesh: TetMesh) -> str:
        """Say why a body held like this cannot be simulated; nothing where it can."""
        held = mesh.rest_positions[self.hold.vertices(mesh)]
        if len(held) == mesh.vertex_count:
            return 'the clamp holds the whole body: nothing is left to deform'
        if len(held) < 3 or np.linalg.matrix_rank(held - held.mean(axis=0), tol=1e-6) < 2:
            return (
                f'the clamp holds {len(held)} vertices of the mesh: at least three that are not '
                'in line keep the body from turning'
            )
        return ''

    def draft(self, proposed: Draft, mesh: TetMesh) -> Draft:
        """Return a proposed scene with this arrangement in place of its own.

        What was set by hand is remarked so; what was not keeps the remarks of the proposal.

        Args:
            proposed: of `diffcal init`.
            mesh: the body at rest.
        """
        remarks = dict(proposed.remarks)
        if np.abs(self.world_from_object - proposed.world_from_object).max() > _GRAIN:
            remarks['placement'] = (f'world_from_object [m]. {_BY_HAND}',)
        if not same_hold(self.hold, proposed.hold):
            remarks['held'] = (_BY_HAND,)
        return replace(
            proposed,
            world_from_object=self.world_from_object,
            hold=self.hold,
            held=self.hold.vertices(mesh),
            youngs_modulus=self.youngs_modulus,
            remarks=remarks,
        )


def arrangement_of(draft: Draft) -> Arrangement:
    """Return what a proposed scene arranges."""
    return Arrangement(draft.world_from_object, draft.hold, draft.youngs_modulus)


def same_hold(first: Hold, second: Hold) -> bool:
    """Tell whether two holds begin at the same plane of the same end."""
    return _same_end(first, second) and abs(first.plane - second.plane) < _GRAIN


def ends(mesh: TetMesh, proposed: Hold) -> dict[str, Hold]:
    """Name the ends at which a body may be held, the proposed one first.

    Args:
        mesh: the body at rest.
        proposed: the end that is held now.
    """
    others = [own for own in possible_holds(mesh) if not _same_end(own, proposed)]
    named: dict[str, Hold] = {}
    for number, hold in enumerate([proposed, *others], start=1):
        axis = hold.axis
        if axis is None:
            named[f'end {number}'] = hold
        else:
            named[f'{"+" if hold.direction[axis] > 0.0 else "-"}{_AXES[axis]}'] = hold
    return named


def _same_end(first: Hold, second: Hold) -> bool:
    return bool(first.direction @ second.direction > 1.0 - _SAME)
