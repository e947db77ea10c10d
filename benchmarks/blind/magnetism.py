# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rubber filled with magnetized particles in a steady field.

    psi = - B . F M

with M the magnetization of the body without stress and B the field (Zhao et al. 2019, J. Mech.
Phys. Solids 124): it turns every part towards the field, and is linear in F, so that forces of
nodes do not change as the body bends.
"""

import numpy as np

from benchmarks.blind.body import Body
from benchmarks.blind.shapes import FloatArray


def magnetic_forces(body: Body, field: FloatArray) -> FloatArray:
    """Return forces of the nodes of a body that is magnetized along its x [N], shape (N, 3).

    Args:
        body: the elastic body.
        field: times the size of the magnetization, object frame [J/m^3], shape (3,).
    """
    along = body.quadrature.gradients[..., 0]
    weights = (body.quadrature.volumes[..., None] * along).sum(axis=1)
    sizes = np.bincount(body.cells.ravel(), weights.ravel(), body.node_count)
    return np.asarray(sizes[:, None] * field)
