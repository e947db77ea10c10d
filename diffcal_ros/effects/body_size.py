# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How heavy and how long a body is: what sizes of effects go by.

A clamp that turns by a degree under a finger of 3 g has a thousand times the compliance, in
radians per newton metre, of one that does under an arm of a kilogram. What is usual of one is
absurd of the other, in priors and in bounds.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class BodySize:
    """A body's size.

    Attributes:
        mass: [kg].
        length: its largest extent [m].
    """

    mass: float
    length: float


# That for which the library states its usual sizes: a cantilever of silicone, 13 cm long.
USUAL_BODY = BodySize(mass=0.05, length=0.13)
