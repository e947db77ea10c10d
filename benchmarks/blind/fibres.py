# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rubber that is stiffer along one direction.

    psi = K (a . C a - 1)^2,   C = F^T F,   |a| = 1

The standard reinforcing model (Qiu and Pence 1997, J. Elasticity 49). Nothing is stressed at rest,
and a small pull along `a` meets E + 8 K in place of E, whatever Poisson's ratio: with
A = a a a a in addition to the stiffness, a . S a of the compliance goes from 1/E to 1/(E + 8 K).

Fibres in waves have g^3 / (g + w) in place of the square of g = a . C a - 1: next to nothing
before they are drawn straight, and the square far beyond w. Steep ones have (exp(q g^2) - 1) / q
(Holzapfel, Gasser and Ogden 2000, J. Elasticity 61). Loops of a knit have g^3: they bear nothing
at first, and the more the straighter they are; rows of beads have that of |g| where they are
pressed together. Loose threads have the square of what g is beyond where they come taut, and
coils of a spring that of what -g is beyond where they touch. A cord that goes no further than m
has -m^2 log(1 - g^2 / m^2) (Warner 1972, Ind. Eng. Chem. Fundam. 11): the square at first.
Filaments that come taut one after another, evenly over s, have (g^3 - (g - s)^3) / (3 s), where
the second is there beyond s alone: the mean of as many loose threads.
"""

from dataclasses import dataclass

import numpy as np

from benchmarks.blind.shapes import FloatArray

_MOST = 50.0  # Exponent that a line search may try; no body comes near it.
_FOLLOWED = 0.98  # Of its limit up to which a cord is followed; then it is as stiff as there.


@dataclass(frozen=True)
class Fibres:
    """A family of fibres.

    Attributes:
        stiffness: K [Pa], shape of the Gauss points.
        direction: a, in the frame of the body without stress, shape (3,).
        slack: whether they resist a pull alone, as a fabric does.
        waves: w [-]; 0 of fibres that are straight at rest.
        steep: q [-]; 0 of those that go with the square.
        pressed: whether they resist a push alone, as the sides of a crack do.
        knit: whether their energy goes with the cube, as that of loops or beads does.
        loose: growth of their square at which slack ones come taut, or loss at which pressed
            ones touch [-].
        limit: m [-]; 0 of those that may grow by whatever they do.
        spread: s [-]; 0 of those that all come taut at once.
    """

    stiffness: FloatArray
    direction: FloatArray
    slack: bool = False
    waves: float = 0.0
    steep: float = 0.0
    pressed: bool = False
    knit: bool = False
    loose: float = 0.0
    limit: float = 0.0
    spread: float = 0.0

    def energy(self, F: FloatArray) -> FloatArray:
        """Return the energy density [J/m^3] at deformation gradients (..., 3, 3)."""
        _, growth = self._drawn(F)
        return np.asarray(self.stiffness * self._resisted(growth)[0])

    def stress(self, F: FloatArray) -> FloatArray:
        """Return its derivative by F [Pa], shape (..., 3, 3)."""
        drawn, growth = self._drawn(F)
        pull = 2.0 * self.stiffness * self._resisted(growth)[1]
        return np.asarray(pull[..., None, None] * drawn[..., :, None] * self.direction)

    def blocks(self, F: FloatArray, gradients: FloatArray, volumes: FloatArray) -> FloatArray:
        """Return what the fibres add to the stiffness of elements [N/m].

        Args:
            F: at the Gauss points, shape (C, 8, 3, 3).
            gradients: of the shape functions [1/m], shape (C, 8, 20, 3).
            volumes: [m^3], shape (C, 8).

        Returns:
            By node and axis twice, shape (C, 20, 3, 20, 3).
        """
        count, points, nodes = gradients.shape[:3]
        drawn, growth = self._drawn(F)
        along = gradients @ self.direction
        weights = self.stiffness * volumes
        _, slope, curve = self._resisted(growth)
        steep = np.sqrt(4.0 * weights * curve)
        outer = along[..., None] * drawn[:, :, None] * steep[..., None, None]
        outer = outer.reshape(count, points, 3 * nodes)
        whole = (np.swapaxes(outer, 1, 2) @ outer).reshape(count, nodes, 3, nodes, 3)
        scaled = along * (2.0 * weights * slope)[..., None]
        alike = np.swapaxes(scaled, 1, 2) @ along
        for axis in range(3):
            whole[:, :, axis, :, axis] += alike
        return whole

    def _resisted(self, growth: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return energy over K, and its two derivatives by how much a fibre's square grew."""
        g, w = growth, self.waves
        if self.knit:
            size = np.abs(g)
            return size**3, 3.0 * (g * size), 6.0 * size
        if self.steep:
            grown = np.exp(np.minimum(self.steep * g**2, _MOST))
            curve = (2.0 + 4.0 * self.steep * g**2) * grown
            return (grown - 1.0) / self.steep, 2.0 * g * grown, curve * (g != 0.0)
        if self.limit:
            part = np.minimum(g / self.limit, _FOLLOWED)
            beyond, left = g - self.limit * part, 1.0 - part**2
            pull, curve = 2.0 * self.limit * part / left, 2.0 * (1.0 + part**2) / left**2
            energy = -(self.limit**2) * np.log(left) + (pull + 0.5 * curve * beyond) * beyond
            return energy, pull + curve * beyond, curve * (g != 0.0)
        if self.spread:
            taut, s = np.maximum(g - self.spread, 0.0), self.spread
            energy, pull = (g**3 - taut**3) / (3.0 * s), (g**2 - taut**2) / s
            return energy, pull, 2.0 * (g - taut) / s
        if not w:
            # What is not resisted has grown by 0.
            is_part = self.slack or self.pressed
            return g**2, 2.0 * g, 2.0 * (g != 0.0) if is_part else np.full(g.shape, 2.0)
        longer = g + w
        slope = g**2 * (2.0 * g + 3.0 * w) / longer**2
        return g**3 / longer, slope, 2.0 * g * (g**2 + 3.0 * g * w + 3.0 * w**2) / longer**3

    def _drawn(self, F: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return where a fibre goes, and by how much its square grew that is resisted."""
        drawn = F @ self.direction
        growth = np.einsum('...i,...i->...', drawn, drawn) - 1.0
        if self.pressed:
            return drawn, np.minimum(growth + self.loose, 0.0)
        return drawn, np.maximum(growth - self.loose, 0.0) if self.slack else growth
