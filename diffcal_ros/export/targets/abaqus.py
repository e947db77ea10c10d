# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Abaqus and CalculiX: an input file of one static step under gravity.

A scene of quadratic elements becomes C3D10, the same element with the same mid-edge nodes, so that
the material's own modulus is right there. The law is kept: neo-Hookean and Mooney-Rivlin as
hyperelastic materials with the same moduli at rest, St. Venant-Kirchhoff and linear elasticity as
*ELASTIC, which CalculiX takes in Green's strain.
"""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.export.exported_body import ExportedBody
from diffcal_ros.export.material_groups import material_groups, MaterialGroup
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.material import lame_lambda, lame_mu
import numpy as np
from numpy.typing import NDArray

SIMULATOR = ''
_NUMBERS_A_LINE = 12
# Of C10, as `fem.laws.mooney_rivlin` has it.
_C01_FRACTION = 0.25


def write(body: ExportedBody, folder: Path) -> list[Path]:
    """Write `body.inp`."""
    path = folder / 'body.inp'
    write_text_atomically(path, '\n'.join(_lines(body)) + '\n')
    return [path]


def _lines(body: ExportedBody) -> Iterator[str]:
    nodes, elements, held = _discretised(body)
    name = 'C3D4' if body.element is Element.LINEAR else 'C3D10'
    yield from ('*HEADING', body.name.replace('\n', ' '), '** units: m, kg, s, Pa')
    yield '*NODE, NSET=ALL'
    yield from (f'{i}, {x:.9g}, {y:.9g}, {z:.9g}' for i, (x, y, z) in enumerate(nodes, 1))
    yield f'*ELEMENT, TYPE={name}, ELSET=BODY'
    yield from (f'{i}, {_row(corners + 1)}' for i, corners in enumerate(elements, 1))
    yield '*NSET, NSET=HELD'
    yield from _wrapped(held + 1)
    groups = material_groups(body)
    for number, group in enumerate(groups):
        yield from _section(body.law, f'G{number}', group)
    yield from _step(body, held)


def _discretised(body: ExportedBody) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Return nodes [m], elements and held nodes, 0-based; of quadratic ones mid-edges too."""
    mesh = body.mesh
    if body.element is Element.LINEAR:
        return mesh.rest_positions, mesh.tets, body.held
    edges, sides = mesh.edges
    nodes = np.vstack([mesh.rest_positions, mesh.rest_positions[edges].mean(axis=1)])
    elements = np.hstack([mesh.tets, sides + mesh.vertex_count])
    middle = np.flatnonzero(np.isin(edges, body.held).all(axis=1)) + mesh.vertex_count
    return nodes, elements, np.concatenate([body.held, middle])


def _section(law: str, name: str, group: MaterialGroup) -> Iterator[str]:
    yield f'** {group.name}'
    yield f'*ELSET, ELSET={name}'
    yield from _wrapped(group.tets + 1)
    yield f'*SOLID SECTION, ELSET={name}, MATERIAL=M{name}'
    yield f'*MATERIAL, NAME=M{name}'
    yield from ('*DENSITY', f'{group.density:.9g}')
    modulus, nu = np.array(group.youngs_modulus), np.array(group.poissons_ratio)
    mu, lam = float(lame_mu(modulus, nu)), float(lame_lambda(modulus, nu))
    # The bulk modulus is 2 / D1, the shear modulus 2 (C10 + C01).
    compressibility = 2.0 / (lam + 2.0 / 3.0 * mu)
    if law == 'mooney_rivlin':
        c10 = 0.5 * mu / (1.0 + _C01_FRACTION)
        yield '*HYPERELASTIC, MOONEY-RIVLIN'
        yield f'{c10:.9g}, {_C01_FRACTION * c10:.9g}, {compressibility:.9g}'
    elif law == 'stable_neo_hookean':
        yield from ('*HYPERELASTIC, NEO HOOKE', f'{0.5 * mu:.9g}, {compressibility:.9g}')
    else:
        yield from ('*ELASTIC', f'{group.youngs_modulus:.9g}, {group.poissons_ratio:.9g}')
    if group.stiffness_damping > 0.0:
        yield f'*DAMPING, BETA={group.stiffness_damping:.6g}'


def _step(body: ExportedBody, held: NDArray[Any]) -> Iterator[str]:
    size = float(np.linalg.norm(body.gravity))
    yield '*STEP, NLGEOM, INC=1000'
    yield from ('*STATIC', '0.1, 1., 1e-6, 0.2')
    yield '*BOUNDARY'
    yield 'HELD, 1, 3, 0.'
    if size > 0.0:
        yield from ('*DLOAD', f'BODY, GRAV, {size:.9g}, {_row(body.gravity / size)}')
    yield from ('*NODE FILE', 'U', '*NODE PRINT, NSET=ALL', 'U', '*END STEP')


def _row(values: Iterable[Any]) -> str:
    return ', '.join(f'{value:.9g}' for value in values)


def _wrapped(numbers: Sequence[int] | NDArray[Any]) -> Iterator[str]:
    for start in range(0, len(numbers), _NUMBERS_A_LINE):
        yield ', '.join(str(number) for number in numbers[start : start + _NUMBERS_A_LINE])
