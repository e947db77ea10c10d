# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The text of a proposed scene: values, where they come from, and what to check."""

from collections.abc import Sequence
from dataclasses import dataclass, field
import math
import os
from pathlib import Path
from typing import Any

from diffcal_ros.marker import Marker
from diffcal_ros.proposal.hold import Hold
from diffcal_ros.rigid_transform import rotation_vector
import numpy as np
from numpy.typing import NDArray
import yaml

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

_HEADER = """\
# A scene proposed by `diffcal init`. Lines that begin with "# check:" are what it is not sure of;
# `diffcal check` draws the scene, and docs/scenes.md tells what every key means.
"""
_AXES = 'xyz'
# How far a body may sit from where the CAD of its clamp has it [m], [degrees].
_SEAT, _SEAT_TURN = 0.001, 0.5
# Bounds of a modulus [Pa]: from gels to hard rubber.
_SOFTEST, _STIFFEST = 5.0e3, 1.0e7


@dataclass(frozen=True)
class Draft:
    """What stands in a proposed scene.

    Attributes:
        name: for titles.
        mesh_file: of the body.
        unit: of its coordinates.
        bags: recordings of one posture.
        gravity: in the world frame [m/s^2], shape (3,).
        world_from_object: placement, shape (4, 4).
        hold: what is held.
        held: vertices of it, for an oblique hold, shape (h,).
        youngs_modulus: where a fit starts [Pa].
        density: [kg/m^3].
        poissons_ratio: dimensionless.
        marker: on the rig, or None.
        pose_frame: TF's name of the world, or empty. With neither marker nor frame the world is
            the depth camera's frame.
        sensor: name of a depth camera, or empty.
        fixture_file: surface of a rigid part in the mesh's coordinates, which gives the camera's
            pose, or None.
        remarks: sentences for comments above a section, by its key.
    """

    name: str
    mesh_file: Path
    unit: str
    bags: tuple[Path, ...]
    gravity: FloatArray
    world_from_object: FloatArray
    hold: Hold
    held: IntArray
    youngs_modulus: float
    density: float
    poissons_ratio: float
    marker: Marker | None = None
    pose_frame: str = ''
    sensor: str = ''
    fixture_file: Path | None = None
    remarks: dict[str, tuple[str, ...]] = field(default_factory=dict)

    def text(self, folder: Path) -> str:
        """Return the YAML; its paths start from a folder."""
        parts = [_HEADER]
        for key, value in self._document(folder).items():
            parts += [_comment(line) for line in self.remarks.get(key, ())]
            parts += [f'{line}\n' for line in _lines(key, value)]
        return ''.join(parts)

    def _document(self, folder: Path) -> dict[str, Any]:
        document: dict[str, Any] = {
            'format': 1,
            'name': self.name,
            'mesh': {'file': _relative(self.mesh_file, folder), 'unit': self.unit},
        }
        if len(self.bags) == 1:
            document['bag'] = _relative(self.bags[0], folder)
        document |= {
            'placement': _placement(self.world_from_object),
            'held': {'clamp': self._held()},
            'regions': {'body': self._material()},
            'gravity': _rounded(self.gravity, 4),
        }
        document |= self._pose(folder)
        if self.sensor:
            document['sensor'] = {'model': self.sensor}
        if len(self.bags) > 1:
            document['observations'] = [
                {'name': f'take_{number}', 'bag': _relative(bag, folder)}
                for number, bag in enumerate(self.bags, start=1)
            ]
        return document | {'fit': ['youngs_modulus', 'rigid_offset']}

    def _held(self) -> dict[str, Any]:
        axis = self.hold.axis
        if axis is None:
            return {'vertices': self.held.tolist()}
        # Vertices on the plane stay held.
        plane = math.floor(1e4 * self.hold.plane + 1e-3) / 1e4
        is_upper = self.hold.direction[axis] > 0.0
        limits = [plane, float('inf')] if is_upper else [-float('inf'), -plane]
        return {'box': {_AXES[axis]: limits}}

    def _material(self) -> dict[str, Any]:
        return {
            'youngs_modulus': {
                'start': float(f'{np.clip(self.youngs_modulus, _SOFTEST, _STIFFEST):.3g}'),
                'min': _SOFTEST,
                'max': _STIFFEST,
            },
            'poissons_ratio': self.poissons_ratio,
            'density': self.density,
        }

    def _pose(self, folder: Path) -> dict[str, Any]:
        if self.fixture_file is not None:
            return {
                'fixture': {'file': _relative(self.fixture_file, folder), 'unit': self.unit},
                'pose': {'source': 'fixture'},
                'rigid_offset': {
                    'translation_std': _SEAT,
                    'rotation_std_deg': _SEAT_TURN,
                },
            }
        if self.marker is not None:
            marker = self.marker
            return {
                'marker': {
                    'dictionary': marker.dictionary,
                    'id': marker.id,
                    'side': marker.side,
                }
            }
        if self.pose_frame:
            return {'pose': {'source': 'tf', 'world_frame': self.pose_frame}}
        return {
            'stored_depth_from_world': {'translation': [0.0, 0.0, 0.0]},
            'pose': {'source': 'stored', 'position_std': 0.0, 'rotation_std_deg': 0.0},
        }


def _lines(key: str, value: Any, indent: str = '') -> list[str]:
    """Return a key and its value as YAML: what holds sections in lines, the rest in one."""
    if isinstance(value, dict) and any(isinstance(own, dict) for own in value.values()):
        inner = [line for name, own in value.items() for line in _lines(name, own, f'{indent}  ')]
        return [f'{indent}{key}:', *inner]
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return [f'{indent}{key}:', *(f'{indent}  - {_flow(own)}' for own in value)]
    return [f'{indent}{key}: {_flow(value)}']


def _flow(value: Any) -> str:
    text = yaml.safe_dump(value, default_flow_style=True, sort_keys=False, width=10**9)
    # A document of one plain value ends in dots.
    return text.removesuffix('...\n').strip()


def _placement(world_from_object: FloatArray) -> dict[str, Any]:
    turn = np.rad2deg(rotation_vector(world_from_object[:3, :3]))
    return {
        'translation': _rounded(world_from_object[:3, 3], 5),
        'rotation_vector_deg': _rounded(turn, 4),
    }


def _rounded(values: Sequence[float] | FloatArray, digits: int) -> list[float]:
    # No -0.0 in a file.
    return [round(float(value), digits) + 0.0 for value in values]


def _relative(path: Path, folder: Path) -> str:
    return os.path.relpath(path.resolve(), folder.resolve())


def _comment(text: str) -> str:
    """Return a sentence as comment lines that are not too long."""
    lines, line = [], '#'
    for word in text.split():
        if len(line) + 1 + len(word) > 98:
            lines.append(line)
            line = '#  '
        line += f' {word}'
    return '\n'.join([*lines, line]) + '\n'
