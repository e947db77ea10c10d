# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""How much stiffer a truth is than the same body in nature, because it has elements, too.

A truth of finitely many elements sags as a continuum of a somewhat larger modulus would, and that
is the modulus which a calibration should find. Told by the work of gravity on a body of small
displacements: with the truth's elements, and with twice as many along every edge.
"""

import json
from pathlib import Path

from diffcal_ros.atomic_file import write_text_atomically
import numpy as np

from benchmarks.zoo.meshes import true_mesh
from benchmarks.zoo.solids import FloatArray, Solid
from benchmarks.zoo.truth import GRAVITY, small_moves, Truth

_FINER = 2.0
# Errors of the work fall as h^p near re-entrant edges, p about 1.4: what is left beyond that.
_BEYOND = 1.0 / (_FINER**1.4 - 1.0)
_POISSONS_RATIO = 0.47


def continuum_modulus(truth: Truth, folder: Path) -> float:
    """Return Young's modulus of the continuum that sags as a truth does [Pa].

    Args:
        truth: its shape's work is the same at any size.
        folder: keeps what was computed for a shape.
    """
    file = folder / f'work_of_{truth.solid.name}.json'
    if not file.is_file():
        folder.mkdir(parents=True, exist_ok=True)
        works = [work(truth.solid, fineness).tolist() for fineness in (1.0, _FINER)]
        write_text_atomically(file, json.dumps(works) + '\n')
    own, fine = (np.array(one) for one in json.loads(file.read_text()))
    down = truth.world_from_object[:3, :3].T @ GRAVITY
    ratio = (down @ fine @ down) / (down @ own @ down)
    return truth.youngs_modulus * (1.0 + (1.0 + _BEYOND) * (ratio - 1.0))


def work(solid: Solid, fineness: float) -> FloatArray:
    """Return the work of unit accelerations on small displacements, 1 Pa, shape (3, 3)."""
    loads, moves = small_moves(true_mesh(solid, fineness), _POISSONS_RATIO, np.eye(3))
    return np.einsum('ani,bni->ab', loads, moves) / solid.free_length**5
