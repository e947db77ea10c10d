# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Tetrahedra in groups of one material, for simulators that know no field."""

from dataclasses import dataclass

from diffcal_ros.export.exported_body import ExportedBody
import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.int32]

# Of the modulus, from one group to the next: less than a fit of a field knows it by.
_STEP = 0.05


@dataclass(frozen=True)
class MaterialGroup:
    """Tetrahedra of one region whose moduli are nearly the same.

    Attributes:
        name: of the region, with a number where it falls into several groups.
        tets: shape (t,), ascending.
        youngs_modulus: geometric mean, weighted by volume [Pa].
        poissons_ratio: of the region.
        density: [kg/m^3].
        stiffness_damping: Rayleigh's factor on the stiffness [s], mean weighted by volume.
    """

    name: str
    tets: IntArray
    youngs_modulus: float
    poissons_ratio: float
    density: float
    stiffness_damping: float


def material_groups(body: ExportedBody) -> tuple[MaterialGroup, ...]:
    """Put tetrahedra into as few groups as hold every modulus within 2.5 %."""
    groups = []
    for number, name in enumerate(body.region_names):
        tets = np.flatnonzero(body.region == number).astype(np.int32)
        logs = np.log(body.youngs_modulus[tets])
        steps = np.floor((logs - logs.min()) / np.log1p(_STEP) + 1e-9).astype(int)
        used = np.unique(steps)
        for index, step in enumerate(used):
            own = name if len(used) == 1 else f'{name}_{index}'
            groups.append(_group(body, own, tets[steps == step]))
    return tuple(groups)


def _group(body: ExportedBody, name: str, tets: IntArray) -> MaterialGroup:
    weights = body.mesh.volumes[tets] / body.mesh.volumes[tets].sum()
    return MaterialGroup(
        name=name,
        tets=tets,
        youngs_modulus=float(np.exp(weights @ np.log(body.youngs_modulus[tets]))),
        poissons_ratio=float(weights @ body.poissons_ratio[tets]),
        density=float(weights @ body.density[tets]),
        stiffness_damping=float(weights @ body.stiffness_damping[tets]),
    )
