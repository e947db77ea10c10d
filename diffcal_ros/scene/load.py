# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Read a scene file; everything that is wrong with it is told at once."""

from dataclasses import replace
import os
from pathlib import Path

from diffcal_ros.errors import InputError
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.laws import USUAL_LAW
from diffcal_ros.material import LameConvention
from diffcal_ros.scene.fit_names import damping_problems, DEFAULT_FIT, fit_problems
from diffcal_ros.scene.model import Cable, ObservationSetup, Region, Scene
from diffcal_ros.scene.model_file import (
    effects_in_force,
    fit_names_in_force,
    model_path,
    read_versions,
)
from diffcal_ros.scene.reading.problems import Problems
from diffcal_ros.scene.reading.section import Section
from diffcal_ros.scene.reading.yaml_document import read_yaml
from diffcal_ros.scene.scene_shape import FORMAT, SCENE_SHAPE
from diffcal_ros.scene.sections.cables import read_cables
from diffcal_ros.scene.sections.fixture import read_fixture
from diffcal_ros.scene.sections.held_parts import read_held
from diffcal_ros.scene.sections.marker_section import read_marker
from diffcal_ros.scene.sections.mesh_files import MeshFile, read_mesh
from diffcal_ros.scene.sections.modulus_field import read_modulus_field
from diffcal_ros.scene.sections.observations import read_observations
from diffcal_ros.scene.sections.regions import read_regions
from diffcal_ros.scene.sections.rig_sections import (
    read_camera,
    read_effects,
    read_masks,
    read_rigid_offset,
)
from diffcal_ros.scene.sections.sensor_section import read_sensor
from diffcal_ros.tet_mesh import mesh_problems, TetMesh
import numpy as np

_NO_MESH = TetMesh(np.zeros((0, 3)), np.zeros((0, 4), np.int32))


def load_scene(path: str | os.PathLike[str]) -> Scene:
    """Read and check a scene file, format 1.

    Args:
        path: the YAML file; paths in it are relative to its folder.

    Raises:
        SceneError: naming the file and, line by line, each key that is wrong, the value given
            and what is allowed.
    """
    file = Path(path)
    document = read_yaml(file)
    root = Section(document.content, '', Problems(str(file), document.lines), SCENE_SHAPE)
    _check_format(root)
    name = root.text('name', default=file.stem)
    scene = _read_scene(root, file.parent)
    root.refuse_unknown()
    root.problems.raise_if_any()
    return _with_model(replace(scene, name=name, path=file, document=document.content))


def _with_model(scene: Scene) -> Scene:
    """Add the effects that were accepted for this scene; those that it states itself go before."""
    assert scene.path is not None
    versions = read_versions(scene.path)
    added = {
        name: amplitudes
        for name, amplitudes in effects_in_force(versions).items()
        if name not in scene.effects
    }
    if not added:
        return scene
    more = [name for name in fit_names_in_force(versions) if name not in scene.fit]
    return replace(
        scene,
        effects={**scene.effects, **added},
        fit=(*scene.fit, *more),
        notes=(*scene.notes, f'{model_path(scene.path).name} adds {", ".join(added)}'),
    )


def _read_scene(root: Section, folder: Path) -> Scene:
    """Read every section; where a mistake was noted, a stand-in takes its place."""
    mesh_file, element = _read_mesh(root, folder)
    mesh = None if mesh_file is None else mesh_file.mesh
    held = read_held(root, mesh)
    regions = read_regions(root, mesh)
    # A part that is wrong is missing here; an observation that names it is not to blame.
    blameless = () if root.problems.touch('held') else held
    cables, cable_notes = read_cables(root, mesh)
    observations = read_observations(root, blameless, cables, folder, mesh)
    _check_motions(root, cables, observations)
    depth_camera = read_camera(root, 'camera', may_be_distorted=False)
    law, convention = _read_law(root)
    return Scene(
        name='',
        mesh=_NO_MESH if mesh is None else mesh,
        element=element,
        regions=regions,
        convention=convention,
        law=law,
        observations=observations,
        fit=_read_fit(root, regions, cables, observations),
        marker=read_marker(root),
        depth_camera=depth_camera,
        color_camera=read_camera(root, 'color_camera', may_be_distorted=True),
        masks=read_masks(root, depth_camera),
        sensor=read_sensor(root),
        rigid_offset=read_rigid_offset(root),
        fixture=read_fixture(root, folder),
        effects=read_effects(root),
        cables=cables,
        relative_modulus=read_modulus_field(root, folder, mesh),
        notes=(*(() if mesh_file is None else mesh_file.notes), *cable_notes),
    )


def _check_format(root: Section) -> None:
    """Note another format and stop: its other keys would only confuse."""
    if not root.has('format'):
        root.problems.add('format', f'is missing: write `format: {FORMAT}`')
    elif root.raw('format') != FORMAT or isinstance(root.raw('format'), bool):
        root.wrong('format', f'this version reads format {FORMAT}')
    root.problems.raise_if_any()


def _read_mesh(root: Section, folder: Path) -> tuple[MeshFile | None, Element]:
    """Read `mesh`; the mesh is None when a mistake was noted."""
    if not root.required('mesh', 'give {file: .., unit: ..}'):
        return None, Element.QUADRATIC
    section = root.child('mesh')
    if section is None:
        return None, Element.QUADRATIC
    file = section.path('file', folder, needed='name the mesh file')
    unit = section.choice('unit')
    element = Element(section.choice('element', default=Element.QUADRATIC.value))
    has_length = section.has('edge_length')
    edge_length = section.number('edge_length', default=0.0)
    section.refuse_unknown()
    if any(section.problems.touch(section.at(name)) for name in ('file', 'unit', 'edge_length')):
        return None, element
    try:
        read = read_mesh(
            file,
            unit=unit,
            edge_length=edge_length if has_length else None,
        )
    except InputError as error:
        section.wrong('file', str(error))
        return None, element
    faults = mesh_problems(read.mesh)
    for fault in faults:
        section.problems.add(section.at('file'), f'is {file.name!r}, unit {unit}: {fault}')
    return (None if faults else read), element


def _check_motions(
    root: Section, cables: tuple[Cable, ...], observations: tuple[ObservationSetup, ...]
) -> None:
    moving = [setup.name for setup in observations if setup.motion is not None]
    if cables and moving:
        root.problems.add(
            'cables',
            f'are given while the body moves in {moving[0]!r}: cables are modelled for a body at '
            'rest only, leave them or the motion out',
        )


def _read_law(root: Section) -> tuple[str, LameConvention]:
    usual = LameConvention.CONSISTENT
    section = root.child('law')
    if section is None:
        return USUAL_LAW, usual
    law = section.choice('name', default=USUAL_LAW)
    convention = section.choice('lame_convention', default=usual.value)
    section.refuse_unknown()
    if convention == LameConvention.PAPER.value and law != USUAL_LAW:
        section.wrong('lame_convention', f'it is known of {USUAL_LAW} only: leave it out')
    return law, LameConvention(convention)


def _read_fit(
    root: Section,
    regions: tuple[Region, ...],
    cables: tuple[Cable, ...],
    observations: tuple[ObservationSetup, ...],
) -> tuple[str, ...]:
    if not root.has('fit'):
        return DEFAULT_FIT
    value = root.raw('fit')
    if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
        root.wrong('fit', 'give a list of parameter names')
        return DEFAULT_FIT
    names = tuple(value)
    items = root.raw('observations')
    own = range(len(items)) if isinstance(items, list) else ()
    motions = ('motion', *(f'observations[{index}].motion' for index in own))
    if not observations or any(
        root.problems.touch(key) for key in ('regions', 'cables', *motions)
    ):
        return names  # Which names and loads there are is not known yet.
    region_names, cable_names = [r.name for r in regions], [c.name for c in cables]
    for problem in fit_problems(names, region_names, observations, cable_names):
        root.problems.add('fit', problem)
    for problem in damping_problems(names, regions):
        root.problems.add('fit', problem)
    return names
