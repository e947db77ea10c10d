# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Numbers from which rigs for bodies of other kinds are drawn."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from benchmarks.blind.other_bodies import Family, OTHER_FAMILIES


@dataclass(frozen=True)
class Ranges:
    """What the rigs of a set are drawn from; as they stand, those of the thirty-fourth.

    Attributes:
        families: kinds of bodies.
        images: least and largest focal length over the width, by width and height [px].
        filled: least and largest share of the image's height that bodies reach over.
        distances: least and largest of a camera [m].
        smooth: least and largest smooth error [m].
        misstated: factors by which a scene that states that is off, each as often as another.
        moduli: least and largest [Pa].
        frames: least and largest number in a pose.
    """

    families: Mapping[str, Family] = field(default_factory=lambda: OTHER_FAMILIES)
    images: Mapping[tuple[int, int], tuple[float, float]] = field(
        default_factory=lambda: {
            (424, 240): (0.82, 0.95),
            (640, 480): (0.85, 1.0),
            (848, 480): (0.7, 0.85),
        }
    )
    filled: tuple[float, float] = (0.5, 0.9)
    distances: tuple[float, float] = (0.12, 1.2)
    smooth: tuple[float, float] = (0.00015, 0.0012)
    misstated: tuple[float, ...] = (1.0,)
    moduli: tuple[float, float] = (15.0e3, 15.0e6)
    frames: tuple[int, int] = (3, 10)


RANGES_34 = Ranges()
