# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The likelihood profile of one parameter, as a result."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Profile:
    """The profile of one parameter.

    Attributes:
        name: of the parameter.
        unit: SI.
        values: tried, ascending, shape (n,).
        rises: of the cost above its least, over the threshold of 95 %, shape (n,).
        low: end of the 95 % interval; -inf where the data or the bound give none.
        high: likewise; inf.
        laplace: the interval that curvature at the best value gives.
    """

    name: str
    unit: str
    values: FloatArray
    rises: FloatArray
    low: float
    high: float
    laplace: tuple[float, float]

    def as_dict(self) -> dict[str, Any]:
        """Return what `result.json` holds; open ends are null."""
        return {
            'unit': self.unit,
            'interval_95': [self.low, self.high],
            'laplace_95': list(self.laplace),
            'values': self.values.tolist(),
            'rises': self.rises.tolist(),
        }
