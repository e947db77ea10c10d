# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What may stand in a scene file, put together from the sections that the readers declare."""

from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.laws import law_names
from diffcal_ros.material import LameConvention
from diffcal_ros.scene.reading.shapes import Choice, Constant, Keys, ListOf, Number, POSITIVE, Text
from diffcal_ros.scene.sections.cables import CABLES_SHAPE
from diffcal_ros.scene.sections.fixture import FIXTURE_SHAPE
from diffcal_ros.scene.sections.held_parts import HELD_SHAPE
from diffcal_ros.scene.sections.marker_section import MARKER_SHAPE
from diffcal_ros.scene.sections.mesh_files import UNITS_PER_METRE
from diffcal_ros.scene.sections.modulus_field import KEY as MODULUS_FIELD
from diffcal_ros.scene.sections.modulus_field import MODULUS_FIELD_SHAPE
from diffcal_ros.scene.sections.observations import OBSERVATIONS_SHAPE, POSTURE_SHAPES
from diffcal_ros.scene.sections.regions import REGIONS_SHAPE
from diffcal_ros.scene.sections.rig_sections import (
    CAMERA_SHAPE,
    EFFECTS_SHAPE,
    MASKS_SHAPE,
    RIGID_OFFSET_SHAPE,
)
from diffcal_ros.scene.sections.sensor_section import SENSOR_SHAPE

FORMAT = 1

_MESH_SHAPE = Keys(
    {
        'file': Text('.tet .msh .vtk .vtu, or a watertight .stl .obj .ply, beside this file'),
        'unit': Choice(tuple(UNITS_PER_METRE), "of the file's coordinates"),
        'element': Choice(
            tuple(element.value for element in Element),
            'default quadratic; linear is far too stiff in bending near poissons_ratio 0.5',
        ),
        'edge_length': Number('of the tetrahedra that a surface is cut into, in m', POSITIVE),
    },
    ('file', 'unit'),
    'the body at rest',
)
_LAW_SHAPE = Keys(
    {
        'name': Choice(law_names(), 'default stable_neo_hookean'),
        'lame_convention': Choice(
            tuple(convention.value for convention in LameConvention),
            'consistent (default): youngs_modulus is what a small pull measures; paper: the '
            "authors' numbers, 25 % softer in shear",
        ),
    },
    about='the energy law',
)
SCENE_SHAPE = Keys(
    {
        'format': Constant(FORMAT, 'of this file'),
        'name': Text("for titles; default: this file's name"),
        'mesh': _MESH_SHAPE,
        'held': HELD_SHAPE,
        'regions': REGIONS_SHAPE,
        'cables': CABLES_SHAPE,
        'observations': OBSERVATIONS_SHAPE,
        **POSTURE_SHAPES,
        'camera': CAMERA_SHAPE,
        'color_camera': CAMERA_SHAPE,
        'law': _LAW_SHAPE,
        'fit': ListOf(Text(), 'names of parameters; default youngs_modulus and rigid_offset'),
        'marker': MARKER_SHAPE,
        'masks': MASKS_SHAPE,
        'sensor': SENSOR_SHAPE,
        'rigid_offset': RIGID_OFFSET_SHAPE,
        'fixture': FIXTURE_SHAPE,
        'effects': EFFECTS_SHAPE,
        MODULUS_FIELD: MODULUS_FIELD_SHAPE,
    },
    ('format', 'mesh', 'held', 'regions'),
    'a set-up that diffcal calibrates: body, clamp, material, rig, camera, and what to fit',
)
