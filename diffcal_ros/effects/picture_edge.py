# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""An edge in a camera's picture, straight or round, beyond which it reads otherwise.

Halves of an imager that two circuits read out, a film on a part of the window, a pane before a
part of the view, what a wiper cleaned, a drop, breath. `edge_turn` says which way lies beyond,
from the picture's x to its y, `edge_at` where along that way the edge is, and `edge_width` over
how much of it one becomes the other. In a pose of its own place `edge_at_1` and so on say where,
by the number of the observation. `edge_curve` is one over how far ahead the middle of a round edge
is, negative where that is behind: what is beyond is inside then, or outside.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# No picture reaches so far, x / z and y / z: there is no edge.
NOWHERE = 10.0
_MOST_POSES = 16
PATTERN = 'edge_at_[0-9]+'
OF_POSES = tuple(f'edge_at_{number}' for number in range(1, _MOST_POSES + 1))
SETTINGS = {
    'edge_turn': 0.0,
    'edge_at': NOWHERE,
    'edge_width': 0.0,
    'edge_curve': 0.0,
    **dict.fromkeys(OF_POSES, NOWHERE),
}
# Of a round edge: its middle is no nearer to that of the picture.
MOST_CURVED = 50.0
_LIMITS = {
    'edge_turn': (-np.pi, np.pi),
    'edge_width': (0.0, 1.0),
    'edge_curve': (-MOST_CURVED, MOST_CURVED),
}


def setting_limits(name: str) -> tuple[float, float]:
    """Return what a setting may be."""
    return _LIMITS.get(name, (-NOWHERE, NOWHERE))


@dataclass(frozen=True)
class PictureEdge:
    """An edge in one pose.

    Attributes:
        turn: which way lies beyond, from the picture's x to its y [rad].
        place: of the edge along that way, as `SeenPixels.directions`.
        width: over which what is not beyond becomes what is, likewise.
        curve: one over how far ahead its middle is, 0 of a straight one.
    """

    turn: float
    place: float
    width: float = 0.0
    curve: float = 0.0

    @property
    def way(self) -> FloatArray:
        """Unit vector of what lies beyond, shape (2,)."""
        return np.array([np.cos(self.turn), np.sin(self.turn)])

    def along(self, directions: FloatArray) -> FloatArray:
        """Return how far along its way pixels are, by circles about its middle, shape (...,).

        Args:
            directions: in which they are seen, x / z and y / z, shape (..., 2).
        """
        ahead = np.asarray(directions @ self.way)
        if self.curve == 0.0:
            return ahead
        # How far the middle is, less how far a pixel is from there, in a form that goes over into
        # that of a straight edge.
        squares = np.square(directions).sum(axis=-1)
        twice = 2.0 * ahead - self.curve * squares
        return np.asarray(twice / (1.0 + np.sqrt(np.maximum(1.0 - self.curve * twice, 0.0))))

    def beyond(self, directions: FloatArray) -> FloatArray:
        """Return by how much pixels are beyond it, 0 to 1, shape (...,); see `along`."""
        ahead = self.along(directions) - self.place
        if self.width == 0.0:
            return (ahead > 0.0).astype(np.float64)
        return np.asarray(np.clip(0.5 + ahead / self.width, 0.0, 1.0))


def edge_in(settings: Mapping[str, float], number: int) -> PictureEdge | None:
    """Return the edge that settings state in an observation; None where they state none.

    Args:
        settings: see `SETTINGS`.
        number: of the observation, from 0.
    """
    stated = {**SETTINGS, **settings}
    place = stated.get(f'edge_at_{number + 1}', NOWHERE)
    place = stated['edge_at'] if place >= NOWHERE else place
    if place >= NOWHERE:
        return None
    return PictureEdge(stated['edge_turn'], place, stated['edge_width'], stated['edge_curve'])


def has_edge(settings: Mapping[str, float]) -> bool:
    """Tell whether settings state an edge."""
    return any(settings.get(name, NOWHERE) < NOWHERE for name in ('edge_at', *OF_POSES))


def without_unused(numbers: Mapping[str, float]) -> dict[str, float]:
    """Return an effect's numbers without settings that leave all as it is."""
    return {k: v for k, v in numbers.items() if k not in SETTINGS or v != SETTINGS[k]}


def in_words(settings: Mapping[str, float]) -> str:
    """Say where it is: `past an edge at 0.12 in the picture, 90 degrees from x to y`."""
    stated = {**SETTINGS, **settings}
    places = [stated[name] for name in ('edge_at', *OF_POSES) if stated[name] < NOWHERE]
    where = f'{min(places):.3g}'
    if len(set(places)) > 1:
        where = f'{where} to {max(places):.3g} (another place in each pose)'
    turn, curve = np.rad2deg(stated['edge_turn']), stated['edge_curve']
    words = f'past an edge at {where} in the picture, {turn:.0f} degrees from x to y'
    if curve == 0.0:
        return words
    x, y = PictureEdge(stated['edge_turn'], 0.0).way / curve
    return f'{words}, round x / z = {x:.2f}, y / z = {y:.2f}'
