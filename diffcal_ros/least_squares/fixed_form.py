# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Costs that stay as they are while they are minimised."""

import numpy as np
from numpy.typing import NDArray


class FixedForm:
    """A cost of one form: an optimiser that would anneal it finds it annealed.

    Attributes:
        is_annealed: always.
    """

    is_annealed = True

    def anneal(self, coordinates: NDArray[np.float64]) -> None:
        """Keep the form."""

    def refine(self, coordinates: NDArray[np.float64]) -> bool:
        """Keep the form, and say so."""
        return False
