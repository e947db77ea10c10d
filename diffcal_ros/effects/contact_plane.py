# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The body lies on something, which pushes back in proportion to how deep the surface is in it.

That is a plane, or what is round and reaches from side to side below one place: a bar, a rope, a
roller, the edge of a shelf.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from diffcal_ros.effects.along_body import at_share
from diffcal_ros.effects.effect import Component, DEGREE, Effect, FloatArray, Numbers
from diffcal_ros.effects.rigid import pair_of, tilt_components
from diffcal_ros.effects.site import FitsSeen, Site
from diffcal_ros.fem.elements.element import Discretisation
from diffcal_ros.fem.elements.sparse_pattern import SparsePattern
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.terms.conditions import Conditions
from diffcal_ros.fem.terms.potential_terms import AddedTerm, Potential, surface_areas
from diffcal_ros.rigid_motion import tilt_axes, upwards
from diffcal_ros.rigid_transform import rotation_matrix
import numpy as np

# Pressure of an obstacle on what is in it by so much [Pa/m]: a soft body's weight presses it in
# by hundredths of a millimetre.
_OBSTACLE = 2e8
_NORMAL_STEP = 1e-5  # Of a finite difference that is exact to rounding [rad].
# Places along the body, and their width, of the forces that stand in for it.
_PUSHED, _PUSHED_WIDTH = (0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0), 0.05
_HELD = (0.25, 0.5, 0.75, 1.0)
_OTHERWISE_WIDTH = 0.15
# Places along the body at each of which it may lie higher or lower than on the plane.
_RAISED = np.linspace(0.0, 1.0, 7)[1:]
# What is round has this radius [m]: a place is what matters, and any bar touches about there.
_RADIUS = 0.01
# Amplitudes of a bar: it is level, and reaches from side to side.
_BAR = ('height',)
# A plane is first tried at the lowest point seen, below a body of half the modulus: what lies on
# something is stiffer in a model that knows of nothing below it. Without a modulus it is tried so
# much above that point [m].
_SOFTER, _RISE = float(np.log(2.0)), 0.003
_MODULUS = 'youngs_modulus'
_LOWEST_FRACTION = 0.01


class ContactPlane(Effect):
    """A rigid frictionless half-space under the body, nearly level; there at height zero, too.

    With a place, `at` beyond zero, it is a level bar below that share of the free length.
    """

    identifier = 'contact_plane'
    group = 'load'
    components = (
        # As far from the world's origin as a body may be placed.
        Component('height', 'm', -100.0, 100.0, 0.010, 'mm', 1e3, 0.4, has_prior=False),
        *(replace(part, longest_step=0.6) for part in tilt_components(5.0 * DEGREE)),
    )
    variants = (('height', 'a', 'b'), _BAR)
    settings = {'at': 0.0}  # noqa: RUF012  Where a bar is; nowhere: it is a plane.
    screened_at = _PUSHED
    sentence = 'the body lies on something'
    settles = ('a pose in which it cannot touch',)
    twins = ('added_mass',)
    has_tangent = has_limit = False
    beyond_robust_fit = ('height',)
    needs_long_look = True
    # Friction is as large as what presses.
    most_besides = 2.0
    form = 'what it lies on is higher or lower along the body'
    forms = tuple(
        Component(f'rise_{number}', 'm', -0.1, 0.1, 0.010, 'mm', 1e3, 0.4, where=at_share(at))
        for number, at in enumerate(_RAISED, 1)
    )
    # The forces that stand in for it would be masses in a motion.
    is_at_rest_only = True

    def conditions(self, own: Numbers, site: Site) -> Conditions:
        """Return the plane."""
        # What tilts gravity in a fit does not tilt the plane; and a tilt about a world origin far
        # away would lift it off the body, or bury it.
        normal = _normal(own, site.stated_gravity)
        level = float((normal - upwards(site.stated_gravity)) @ site.pivot)
        plane = Plane(normal, own['height'] + level, _rises(own, self.forms, site))
        return Conditions(potentials=(plane,))

    def change(self, component: str, own: Numbers, site: Site) -> Change:
        """Return a rise of the plane, of a place on it, or a turn of its normal."""
        change = Plane(np.zeros(3), 1.0)
        if component in {part.name for part in self.forms}:
            change = Plane(np.zeros(3), 0.0, _rises({component: 1.0}, self.forms, site))
        elif component != 'height':
            ahead, behind = (
                _normal({**own, component: own.get(component, 0.0) + step}, site.stated_gravity)
                for step in (_NORMAL_STEP, -_NORMAL_STEP)
            )
            turned = (ahead - behind) / (2.0 * _NORMAL_STEP)
            change = Plane(turned, float(turned @ site.pivot))
        return Change(conditions=Conditions(potentials=(change,)))

    def places_of(self, components: tuple[str, ...]) -> tuple[float | None, ...]:
        """Return the places of a bar; a plane has none."""
        return self.screened_at if components == _BAR else (None,)

    def stand_ins(self, site: Site) -> tuple[Change, ...]:
        """Return upward forces, which have a tangent before the body touches."""
        return tuple(
            Change(conditions=Conditions(added_masses=-site.weights_at(at, _PUSHED_WIDTH)))
            for at in _PUSHED
        )

    def otherwise(self, site: Site) -> tuple[Change, ...]:
        """Return forces on the body: what it lies on may be an edge, and hold it sideways."""
        weights = [site.weights_at(at, _OTHERWISE_WIDTH) for at in _HELD]
        return tuple(
            Change(conditions=Conditions(forces=own[:, None] * axis))
            for own in weights
            for axis in np.eye(3)
        )

    def expected(self, site: Site) -> dict[str, float]:
        """Return about the height of the body."""
        return {'height': float(upwards(site.stated_gravity) @ site.pivot)}

    def starts(self, seen: FitsSeen, screened: float | None) -> list[dict[str, float]]:
        """Propose a plane, or a bar at a place, that a softer body would sink into."""
        heights = [view for view in seen.heights(screened) if len(view)] or seen.heights(None)
        lowest = min(float(np.quantile(view, _LOWEST_FRACTION)) for view in heights)
        name = self.amplitude_name('height')
        # Coordinates of a fit: of a modulus its logarithm.
        softer = {
            own: value - _SOFTER
            for own, value in seen.end.items()
            if own.partition('.')[0] == _MODULUS
        }
        return [{**softer, name: lowest} if softer else {name: lowest + _RISE}]

    def frame(self, own: Numbers, site: Site) -> dict[str, FloatArray]:
        """Its `normal` is given in the world."""
        return {'normal': _normal(own, site.stated_gravity)}


def _rises(own: Numbers, parts: Sequence[Component], site: Site) -> FloatArray | None:
    """Return by how much what each node may lie on is above the plane [m], shape (N,), or None."""
    amounts, bar = [own.get(part.name, 0.0) for part in parts], own.get('at', 0.0)
    if not any(amounts) and bar == 0.0:
        return None
    shares = site.axes.fraction(site.rest_nodes)
    rises = np.interp(shares, _RAISED, amounts)
    # What is round falls off from its top to either side.
    return rises - 0.5 * ((shares - bar) * site.axes.length) ** 2 / _RADIUS if bar else rises


def _normal(own: Numbers, gravity: FloatArray) -> FloatArray:
    """Return the normal of a plane that is tilted against the horizontal, shape (3,)."""
    tilt = pair_of(own)
    if not tilt.any():
        return upwards(gravity)
    return rotation_matrix(tilt @ np.stack(tilt_axes(gravity))) @ upwards(gravity)


@dataclass(frozen=True)
class Plane(Potential):
    """The half-space.

    Attributes:
        normal: unit vector out of it in the world frame, shape (3,).
        height: of its surface along the normal [m].
        rises: by how much more what each node may lie on is higher [m], shape (N,); None: nothing.
    """

    normal: FloatArray
    height: float
    rises: FloatArray | None = None
    kind = 'plane'

    def seen_from(self, origin: FloatArray) -> 'Plane':
        """Return the same where positions are counted from a point in the world [m], (3,)."""
        return replace(self, height=self.height - float(origin @ self.normal))

    def term(
        self, discretisation: Discretisation, pattern: SparsePattern, device: str
    ) -> 'ContactTerm':
        """Prepare the term."""
        return ContactTerm(discretisation, pattern)


class ContactTerm(AddedTerm):
    """Pushes back what of the surface is in a plane."""

    def __init__(self, discretisation: Discretisation, pattern: SparsePattern) -> None:
        self._plane = Plane(np.zeros(3), -np.inf)  # Touched nowhere.
        self._weights = _OBSTACLE * surface_areas(discretisation)
        self._pattern = pattern

    def take(self, potential: Any, shear_moduli: FloatArray) -> None:
        """Take the plane."""
        self._plane = potential

    def energy(self, positions: FloatArray) -> float:
        """Return the energy [J]."""
        depth = self._depth(positions)
        return 0.5 * float(self._weights @ depth**2)

    def forces(self, positions: FloatArray) -> FloatArray:
        """Return its gradient [N], shape (N, 3)."""
        return -np.outer(self._weights * self._depth(positions), self._plane.normal)

    def force_tangent(self, positions: FloatArray, direction: FloatArray) -> FloatArray:
        """Return its Hessian times a direction [N], shape (N, 3)."""
        rates = self._rates(positions) * (direction @ self._plane.normal)
        return np.outer(rates, self._plane.normal)

    def force_along(
        self, positions: FloatArray, direction: Any, shear_moduli: FloatArray
    ) -> FloatArray:
        """Return how the forces follow height and normal [N], shape (N, 3)."""
        change = direction.normal
        deeper = direction.height - positions @ change
        if direction.rises is not None:
            deeper = deeper + direction.rises
        turned = np.outer(self._weights * self._depth(positions), change)
        return -np.outer(self._rates(positions) * deeper, self._plane.normal) - turned

    def stiffness(self, positions: FloatArray, *, is_guarded: bool) -> FloatArray:
        """Return its Hessian's entries in the pattern, shape (nnz,)."""
        pattern, normal = self._pattern, self._plane.normal
        values = np.zeros(pattern.entry_count)
        rates = self._rates(positions)[pattern.free_nodes]
        for column in range(3):
            starts = pattern.column_starts[column:-1:3]
            for row in range(column, 3):
                values[starts + row - column] += rates * normal[row] * normal[column]
        return values

    def _depth(self, positions: FloatArray) -> FloatArray:
        depth = self._plane.height - positions @ self._plane.normal
        if self._plane.rises is not None:
            depth = depth + self._plane.rises
        return np.maximum(depth, 0.0)

    def _rates(self, positions: FloatArray) -> FloatArray:
        return self._weights * (self._depth(positions) > 0.0)
