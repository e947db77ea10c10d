# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How far errors spread of which a few are gross, by their median."""

import numpy as np
from numpy.typing import ArrayLike

# Standard deviation of a normal distribution over the median of its sizes.
SPREAD_OVER_MEDIAN = 1.4826


def median_spread(errors: ArrayLike) -> float:
    """Return the standard deviation around zero of normal errors, up to half of which are gross.

    Args:
        errors: of any unit and shape, at least one.
    """
    return SPREAD_OVER_MEDIAN * float(np.median(np.abs(errors)))
