# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Film a body of the zoo into a bag: marker, clamp and wall in view, truth of hexahedra."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.recording.bag_writer import BagWriter
from diffcal_ros.recording.topics.color_frame import ColorFrame
from diffcal_ros.recording.topics.names import COLOR_FRAME, DEPTH_FRAME
from diffcal_ros.rigid_transform import rotation_matrix, transform
from diffcal_ros.scene.load import load_scene
from diffcal_ros.synthetic.color_picture import expose
from diffcal_ros.synthetic.lidar import LidarModel
from diffcal_ros.synthetic.posed_body import PosedBody
from diffcal_ros.synthetic.rig import make_rig, Rig
from diffcal_ros.synthetic.viewpoint import DEPTH_FROM_COLOR
import numpy as np
import yaml

from benchmarks.zoo.bodies import BODIES
from benchmarks.zoo.meshes import fit_mesh
from benchmarks.zoo.solids import FloatArray, Solid
from benchmarks.zoo.truth import bend, DENSITY, GRAVITY, Truth

_POISSONS_RATIO = 0.49
_START_FACTOR = 1.4
_FRAMES, _COLOR_FRAMES, _PERIOD_NS = 8, 3, 100_000_000
_FIRST_NS, _COLOR_DELAY_NS = 1_700_000_000_000_000_000, 4_000_000
# The middle of the clamp, seen from the marker that sticks in front of it [m].
_CLAMP = np.array([0.0, -0.045, -0.040])


@dataclass(frozen=True)
class Filmed:
    """A body of the zoo as it is filmed.

    Attributes:
        body: its name in the zoo.
        youngs_modulus: true one [Pa].
        turns: of the body out of x to the right, y up, z to the camera, one after the other:
            axis times angle [degrees], shape (n, 3).
    """

    body: str
    youngs_modulus: float
    turns: tuple[tuple[float, float, float], ...] = ()

    def truth(self) -> Truth:
        """Let the body come to rest."""
        solid = BODIES[self.body]()
        rotation = np.eye(3)
        for turn in self.turns:
            rotation = rotation_matrix(np.deg2rad(turn)) @ rotation
        middle = rotation @ np.array([0.5 * solid.clamp, 0.0, 0.0])
        placement = transform(rotation, _CLAMP - middle)
        return bend(solid, placement, self.youngs_modulus, _POISSONS_RATIO)


def film(filmed: Filmed, out: Path, seed: int = 0) -> Path:
    """Write OUT/body.tet [mm], OUT/bag and OUT/scene.yaml as a careful person makes it.

    Args:
        filmed: the body.
        out: folder.
        seed: of the noise.

    Returns:
        The scene file; its placement and its clamp are the true ones, its modulus is not.
    """
    truth = filmed.truth()
    out.mkdir(parents=True, exist_ok=True)
    _write_mesh(truth.solid, out / 'body.tet')
    path = out / 'scene.yaml'
    path.write_text(yaml.safe_dump(_document(truth), sort_keys=False, default_flow_style=None))
    scene = load_scene(path)
    (setup,) = scene.observations
    rest = np.array([truth.held_middle])
    body = PosedBody(
        np.vstack([truth.points, rest]),
        np.vstack([truth.points, rest]),
        truth.triangles,
        np.array([len(truth.points)], dtype=np.int32),
    )
    _write_bag(make_rig(scene, setup, body, None), out / 'bag', seed)
    return path


def _document(truth: Truth) -> dict[str, Any]:
    placement: FloatArray = truth.world_from_object
    return {
        'format': 1,
        'name': truth.solid.name,
        'mesh': {'file': 'body.tet', 'unit': 'mm'},
        'bag': 'bag',
        'placement': {
            'translation': placement[:3, 3].round(9).tolist(),
            'rotation_matrix': placement[:3, :3].round(9).tolist(),
        },
        'held': {'clamp': {'box': {'x': [-float('inf'), truth.solid.clamp]}}},
        'regions': {
            'body': {
                'youngs_modulus': {
                    'start': _START_FACTOR * truth.youngs_modulus,
                    'min': 5.0e3,
                    'max': 1.0e7,
                },
                'poissons_ratio': _POISSONS_RATIO,
                'density': DENSITY,
            }
        },
        'gravity': GRAVITY.tolist(),
        'marker': {'dictionary': 'DICT_6X6_250', 'id': 0, 'side': 0.025},
        'fit': ['youngs_modulus', 'rigid_offset'],
    }


def _write_mesh(solid: Solid, path: Path) -> None:
    """Write the mesh that is fitted, of tetrahedra larger than the truth's hexahedra."""
    mesh = fit_mesh(solid)
    lines = [f'v {x:.6f} {y:.6f} {z:.6f}' for x, y, z in (1e3 * mesh.rest_positions).tolist()]
    lines += [f't {a} {b} {c} {d}' for a, b, c, d in mesh.tets.tolist()]
    path.write_text('\n'.join(lines) + '\n')


def _write_bag(rig: Rig, path: Path, seed: int) -> None:
    lidar = LidarModel()
    random = np.random.default_rng([seed, 5])
    bias = lidar.bias_field(rig.depth_scan.depth.shape, random)
    with BagWriter(path, overwrite=True) as bag:
        bag.write_depth_from_color(
            DEPTH_FROM_COLOR, depth_frame=DEPTH_FRAME, color_frame=COLOR_FRAME, stamp_ns=_FIRST_NS
        )
        for number in range(_FRAMES):
            stamp = _FIRST_NS + number * _PERIOD_NS
            depth = lidar.measure(rig.depth_scan, bias, random)
            bag.write_depth_camera(rig.depth_camera, stamp_ns=stamp, frame_id=DEPTH_FRAME)
            bag.write_depth(DepthFrame(depth, stamp, DEPTH_FRAME))
            if number < _COLOR_FRAMES:
                later = stamp + _COLOR_DELAY_NS
                bag.write_color_camera(rig.color_camera, stamp_ns=later, frame_id=COLOR_FRAME)
                bag.write_color(ColorFrame(expose(rig.color_image, random), later, COLOR_FRAME))
