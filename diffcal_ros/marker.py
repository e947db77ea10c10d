# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The fiducial marker on the rig: what is printed, and where it sits."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Marker:
    """A square fiducial marker on the rig.

    Attributes:
        dictionary: OpenCV's name, for example DICT_6X6_250.
        id: number in the dictionary.
        side: edge of the black square [m].
        world_from_marker: its pose on the rig, shape (4, 4).
    """

    dictionary: str
    id: int
    side: float
    world_from_marker: FloatArray = field(default_factory=lambda: np.eye(4))
