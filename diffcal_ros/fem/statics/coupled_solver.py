# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A solver of equilibria for a body with cables, which join nodes that no element joins."""

from collections.abc import Sequence

from diffcal_ros.fem.elements.elastic_body import ElasticBody
from diffcal_ros.fem.statics.equilibrium import EquilibriumSolver
from diffcal_ros.fem.terms.cable import CableTerm
import numpy as np
from numpy.typing import NDArray


def coupled_solver(
    elastic: ElasticBody, held_nodes: NDArray[np.int32], cables: Sequence[CableTerm], name: str
) -> EquilibriumSolver:
    """Make the solver of a body, in whose pattern the nodes of each cable are joined.

    Args:
        elastic: the body.
        held_nodes: clamped nodes, shape (H,).
        cables: that run through it; they are given the pattern.
        name: of the sparse solver.
    """
    coupled = [cable.nodes for cable in cables]
    made = EquilibriumSolver(elastic, held_nodes, solver=name, coupled_nodes=coupled)
    for cable in cables:
        cable.use_pattern(made.stiffness.pattern)
    return made
