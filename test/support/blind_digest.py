# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is drawn and written of blind cases, in one number that any change of it changes."""

import hashlib

import numpy as np

from benchmarks.blind.cases import list_form_cases
from benchmarks.blind.generator import draw_case
from benchmarks.blind.hexahedra import mesh_hexahedra
from benchmarks.blind.scene_file import extra_text, scene_text
from benchmarks.blind.tetrahedra import mesh_tetrahedra


def drawn_digest(set_name: str, count: int) -> str:
    """Return a digest of a set's first cases: scenes, meshes to a nanometre, effects and faults.

    Those with a contact are left out: drawing them takes a simulation.
    """
    cases = [
        case
        for case in list_form_cases(set_name, 'salt')[-count:]
        if 'contact_plane' not in str(case.effects)
    ]
    found = hashlib.sha256()
    for case in cases:
        setup, effects, _ = draw_case(case)
        told = [case.key, scene_text(setup), extra_text(setup, case.without), str(effects)]
        found.update('\n'.join(told).encode())
        tets, hexahedra = mesh_tetrahedra(setup.shape), mesh_hexahedra(setup.shape)
        for places in (tets.points, hexahedra.nodes):
            found.update(np.round(1e9 * places).astype(np.int64).tobytes())
        for numbers in (tets.tets, tets.regions, hexahedra.cells, hexahedra.held):
            found.update(np.asarray(numbers, dtype=np.int64).tobytes())
    return found.hexdigest()
