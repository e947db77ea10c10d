# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Half a turn of the far block from rest, over moduli and Poisson's ratios: does it converge?

The cantilever of 3,414 tetrahedra, clamped at both ends as in the data set's t_em_c, under its
own weight, in both directions and with each element. Gradients are those of the last equilibrium
alone; a difference quotient over whole new twists checks one in each grid.
"""

import argparse
from itertools import product
import time
from typing import Any

from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.statics.equilibrium import EquilibriumError
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.fem.statics.static_body import StaticBody
from diffcal_ros.material import Material
from diffcal_ros.rigid_transform import rotation_matrix
from measuring import cantilevers, write
import numpy as np

MODULI = (10e3, 20e3, 50e3, 100e3, 200e3, 500e3)
RATIOS = (0.30, 0.45, 0.49, 0.495)
GRAVITY = np.array([0.0, 9.8, 0.0])  # The mesh lies upside down in the data set's world.
_CLAMP, _FAR_BLOCK = 0.07, -0.07
_STEP = 1e-3  # Of the modulus' logarithm.


class Twist:
    """The body and how its far block turns."""

    def __init__(self, mesh: Any, element: Element, degrees: float) -> None:
        x = mesh.rest_positions[:, 0]
        self.mesh, self.element = mesh, element
        self.held = np.flatnonzero((x >= _CLAMP - 1e-9) | (x <= _FAR_BLOCK + 1e-9))
        self._angle = np.deg2rad(degrees)
        self._rest = mesh.rest_positions[self.held]
        self._is_far = self._rest[:, 0] < 0.0
        far = self._rest[self._is_far]
        self._center = 0.5 * (far.min(axis=0) + far.max(axis=0))

    def path(self, fraction: float) -> np.ndarray:
        """Return where the held vertices are [m], shape (h, 3)."""
        rotation = rotation_matrix(np.array([fraction * self._angle, 0.0, 0.0]))
        targets = self._rest.copy()
        arms = self._rest[self._is_far] - self._center
        targets[self._is_far] = self._center + arms @ rotation.T
        return targets

    def body(self) -> StaticBody:
        """Return a body that knows nothing yet."""
        return StaticBody(self.mesh, self.element, self.held.astype(np.int32))

    def material(self, modulus: float, ratio: float, contrast: float = 1.0) -> Material:
        """Return the material; the far half is stiffer by the contrast."""
        ones = np.ones(self.mesh.tet_count)
        stiff = np.where(self.mesh.centroids[:, 0] < 0.0, contrast, 1.0)
        return Material(modulus * stiff, ratio * ones, 1080.0 * ones)


def run(twist: Twist, material: Material) -> dict[str, Any]:
    """Twist from rest."""
    body, begun = twist.body(), time.process_time()
    try:
        state = body.solve_equilibrium(material, GRAVITY, held_path=twist.path)
    except EquilibriumError as error:
        return {'converged': False, 'cpu_s': time.process_time() - begun, 'error': str(error)}
    return {
        'converged': True,
        'cpu_s': time.process_time() - begun,
        'last_newton_steps': state.newton_steps,
    }


def gradient_error(twist: Twist, modulus: float, ratio: float) -> float:
    """Return how far the tangent is from a difference of two cold twists, relative."""
    body = twist.body()
    material = twist.material(modulus, ratio)
    body.solve_equilibrium(material, GRAVITY, held_path=twist.path)
    (tangent,) = body.tangents([Change(youngs_modulus=material.youngs_modulus)])
    ends = []
    for sign in (1.0, -1.0):
        moved = twist.material(modulus * np.exp(sign * _STEP), ratio)
        fresh = twist.body()
        ends.append(fresh.solve_equilibrium(moved, GRAVITY, held_path=twist.path).positions)
    difference = (ends[0] - ends[1]) / (2.0 * _STEP)
    return float(np.linalg.norm(difference - tangent) / np.linalg.norm(tangent))


def main() -> None:
    """Run the grid."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--elements', nargs='+', default=['linear', 'quadratic'])
    parser.add_argument('--degrees', nargs='+', type=float, default=[180.0, -180.0])
    parser.add_argument('--moduli', nargs='+', type=float, default=MODULI)
    parser.add_argument('--ratios', nargs='+', type=float, default=RATIOS)
    parser.add_argument('--contrasts', nargs='+', type=float, default=[0.3, 1.0, 4.0])
    parser.add_argument('--out', default='twist')
    arguments = parser.parse_args()
    mesh, rows = cantilevers()['middle'], []
    for element, degrees in product(map(Element, arguments.elements), arguments.degrees):
        twist = Twist(mesh, element, degrees)
        grid = product(arguments.moduli, arguments.ratios, arguments.contrasts)
        for modulus, ratio, contrast in grid:
            row = {
                'element': element.value,
                'degrees': degrees,
                'youngs_modulus_pa': modulus,
                'poissons_ratio': ratio,
                'contrast': contrast,
                **run(twist, twist.material(modulus, ratio, contrast)),
            }
            rows.append(row)
            print(row, flush=True)
    checked = {
        element: gradient_error(Twist(mesh, Element(element), -180.0), 60e3, 0.49)
        for element in arguments.elements
    }
    done = [row for row in rows if row['converged']]
    seconds = {
        element: [row['cpu_s'] for row in done if row['element'] == element]
        for element in arguments.elements
    }
    write(
        arguments.out,
        {
            'tets': mesh.tet_count,
            'converged': f'{len(done)} of {len(rows)}',
            'cpu_s': {
                element: {'median': float(np.median(own)), 'slowest': max(own)}
                for element, own in seconds.items()
            },
            'grid': {key: value for key, value in vars(arguments).items() if key != 'out'},
            'gradient_error': checked,
            'failed': [row for row in rows if not row['converged']],
        },
    )


if __name__ == '__main__':
    main()
