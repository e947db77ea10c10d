# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is drawn and written of blind cases, in few numbers that any change of it changes."""

import hashlib
import re
from typing import NamedTuple

import numpy as np

from benchmarks.blind.cases import list_form_cases
from benchmarks.blind.generator import draw_case
from benchmarks.blind.hexahedra import mesh_hexahedra
from benchmarks.blind.scene_file import extra_text, scene_text
from benchmarks.blind.tetrahedra import mesh_tetrahedra

_DECIMAL = re.compile(r'-?\d+(?:\.\d+(?:e[-+]\d+)?|e[-+]\d+)')


class Told(NamedTuple):
    """Words and whole numbers as a digest, and all other numbers as one sum.

    Processors round sines and sums of squares differently, and a noise is written with all its
    digits: a digest of those tells processors apart and not draws.
    """

    words: str
    numbers: float


def drawn_digest(set_name: str, count: int) -> Told:
    """Return what is told of a set's first cases: scenes, meshes, effects and faults.

    Those with a contact are left out: drawing them takes a simulation.
    """
    cases = [
        case
        for case in list_form_cases(set_name, 'salt')[-count:]
        if 'contact_plane' not in str(case.effects)
    ]
    words, numbers = hashlib.sha256(), [np.zeros(0)]
    for case in cases:
        setup, effects, _ = draw_case(case)
        text = [case.key, scene_text(setup), extra_text(setup, case.without), str(effects)]
        for line in text:
            words.update(_DECIMAL.sub('#', line).encode())
            numbers.append(np.array([float(each) for each in _DECIMAL.findall(line)]))
        tets, hexahedra = mesh_tetrahedra(setup.shape), mesh_hexahedra(setup.shape)
        numbers += [tets.points.ravel(), hexahedra.nodes.ravel()]
        for each in (tets.tets, tets.regions, hexahedra.cells, hexahedra.held):
            words.update(np.asarray(each, dtype=np.int64).tobytes())
    return Told(words.hexdigest(), _sum_of(np.concatenate(numbers)))


def _sum_of(numbers: np.ndarray) -> float:
    """Return a sum to which lengths of metres and moduli alike tell, each at its own place."""
    return float(np.cos(np.arange(numbers.size)) @ np.arcsinh(1e3 * numbers))
