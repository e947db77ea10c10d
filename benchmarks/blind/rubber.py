# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rubbers that the scene's law does not describe, but nearly.

They are worlds, not effects: nobody states them, and nobody is to name them. What `youngs_modulus`
of a label means then: the modulus of small strains, of the fibres' one without its fibres.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.blind.faults import Vector
from benchmarks.blind.fibres import Fibres
from benchmarks.blind.material import Constants, constants, stiffened
from benchmarks.blind.shapes import FloatArray

LAWS = ('stable', 'plain', 'compressible', 'fibres', 'mooney')
_MODULUS = {
    'stable': 'of small strains, as the scene has it',
    'plain': 'of small strains, the same in all directions',
    'compressible': 'of small strains, at the true Poisson ratio',
    'fibres': 'of small strains without the fibres; along them it is (1 + share) times that',
    'mooney': 'of small strains, both terms together',
}


@dataclass(frozen=True)
class Rubber:
    """What a body is made of.

    Attributes:
        law: one of `LAWS`: `stable` neo-Hookean, `plain` neo-Hookean with logarithms, the stable
            one `compressible` by more than is stated, with `fibres`, or with a share of `mooney`.
        poissons_less: true Poisson's ratio less the stated one, negative or 0.
        share: by which fibres stiffen along themselves, or of the shear modulus that comes from
            the second invariant.
        direction: of the fibres, object frame, of length 1.
    """

    law: str = 'stable'
    poissons_less: float = 0.0
    share: float = 0.0
    direction: Vector = (1.0, 0.0, 0.0)

    def numbers(
        self, modulus: FloatArray, poissons_ratio: float, yeoh_ratio: float = 0.0
    ) -> Constants:
        """Return the numbers of the energy.

        Args:
            modulus: E at the Gauss points [Pa].
            poissons_ratio: as the scene states it.
            yeoh_ratio: C2 / C1 of a stiffening beside the law [-].
        """
        plain = constants(modulus, poissons_ratio + self.poissons_less, yeoh_ratio)
        if self.law == 'plain':
            return replace(plain, is_plain=True)
        if self.law == 'mooney':
            return stiffened(plain, 'mooney_rivlin', self.share)
        if self.law == 'fibres':
            fibres = Fibres(self.share * modulus / 8.0, np.array(self.direction))
            return replace(plain, fibres=fibres)
        return plain

    def label(self) -> dict[str, Any]:
        """Return what a label says of it."""
        return {
            'law': self.law,
            'poissons_less': self.poissons_less,
            'share': self.share,
            'direction': list(self.direction),
            'youngs_modulus_is': _MODULUS[self.law],
        }


def draw_rubber(law: str, random: np.random.Generator) -> Rubber:
    """Draw a rubber of a law."""
    if law == 'compressible':
        return Rubber(law, poissons_less=-round(float(random.uniform(0.015, 0.04)), 4))
    if law == 'mooney':
        return Rubber(law, share=round(float(random.uniform(0.1, 0.3)), 4))
    if law == 'fibres':
        # Oblique: neither along the body nor across it.
        slant = np.deg2rad(random.uniform(20.0, 70.0))
        around = random.uniform(0.0, 2.0 * np.pi)
        across = np.sin(slant) * np.array([np.cos(around), np.sin(around)])
        direction = (float(np.cos(slant)), float(across[0]), float(across[1]))
        return Rubber(law, share=round(float(random.uniform(0.1, 0.25)), 4), direction=direction)
    if law in LAWS:
        return Rubber(law)
    raise ValueError(f'law is {law!r}: {", ".join(LAWS)}')
