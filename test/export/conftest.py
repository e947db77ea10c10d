# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A body with all that an asset must keep: two regions, damping, a clamp, gravity aslant."""

from diffcal_ros.export.exported_body import exported_body
from diffcal_ros.scene.load import load_scene
import pytest
from support.recorded_beam import write_beam_scene

# Regions differ in every number, gravity along no axis, the mesh in no symmetric place.
TWO_REGIONS = {
    'regions': {
        'tip': {
            'box': {'x': [0.0, 0.045]},
            'youngs_modulus': 60e3,
            'poissons_ratio': 0.4,
            'density': 900,
            'damping': 40.0,
        },
        'root': {
            'rest': True,
            'youngs_modulus': 150e3,
            'poissons_ratio': 0.45,
            'density': 1200,
            'damping': 90.0,
        },
    },
    'fit': ['youngs_modulus'],
    'gravity': [1.5, -9.4, 2.1],
    'mesh.element': 'linear',
}
# Agreement that the files must keep: mass, volume and moduli as text and in single precision.
SAME = 1e-3


@pytest.fixture
def scene_file(tmp_path):
    """Scene file of the beam of two regions."""
    return write_beam_scene(tmp_path / 'scene', TWO_REGIONS)


@pytest.fixture
def body(scene_file):
    """The beam of two regions."""
    scene = load_scene(scene_file)
    return exported_body(scene, scene.observations[0])
