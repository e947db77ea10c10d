# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The scene file of a case, and what a scene file cannot say."""

from typing import Any

import yaml

from benchmarks.blind.other_rigs import OtherSetup, stated_fixtures
from benchmarks.blind.setups import Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.timing import LEDGE, Timing

_HELD_ROUNDING = 1e-6  # By which boxes are larger than what they hold [m].
_HELD_MARGIN = 0.006  # The fixture's jaws may hide this much of the body beside it [m].


def scene_text(setup: Setup, timing: Timing | None = None) -> str:
    """Write the scene; start values are off, nothing in it is a fault's.

    Args:
        setup: the rig.
        timing: of a body that is let go; None: it is at rest.
    """
    sensor = setup.sensor
    document: dict[str, Any] = {
        'format': 1,
        'mesh': {'file': 'mesh.vtk', 'unit': 'mm', 'element': 'quadratic'},
        'held': _held(setup),
        'regions': {
            'body': {
                'youngs_modulus': {'start': setup.start_modulus, **_bounds(setup)},
                'poissons_ratio': setup.poissons_ratio,
                'density': setup.density,
            }
        },
        'law': {'name': 'stable_neo_hookean', 'lame_convention': 'consistent'},
        'gravity': [0.0, -9.81, 0.0],
        'camera': 'from_camera_info',
        'stored_depth_from_world': _placement(setup.depth_from_world),
        'pose': {
            'position_std': setup.pose_errors[0],
            'rotation_std_deg': setup.pose_errors[1],
        },
        'masks': {'held': True, 'held_margin': _held_margin(setup)},
        'sensor': {
            'noise': sensor.noise,
            'quantization': sensor.step,
            'quantization_mode': 'round',
            **_smooth_error(setup),
        },
        'fit': ['youngs_modulus'],
        **(_timed(setup, timing) if timing is not None else {}),
        'observations': [
            {
                'name': observation.name,
                'bag': f'bag_{observation.name}',
                'placement': _placement(
                    observation.world_from_object
                    if observation.stated is None
                    else observation.stated
                ),
                **(_motion(timing) if timing is not None else {}),
            }
            for observation in setup.observations
        ],
    }
    return _dump(document)


def _held(setup: Setup) -> dict[str, Any]:
    """Return the parts that are held, as boxes; a body of another kind may have two."""
    if not isinstance(setup, OtherSetup):
        return {'clamp': {'box': {'x': [float('-inf'), round(setup.shape.clamp, 9)]}}}
    boxes = setup.body.held
    names = ['clamp'] if len(boxes) == 1 else ['clamp_one', 'clamp_two']
    return {
        name: {
            'box': {
                axis: [
                    round(float(low) - _HELD_ROUNDING, 9),
                    round(float(high) + _HELD_ROUNDING, 9),
                ]
                for axis, (low, high) in zip('xyz', box, strict=True)
            }
        }
        for name, box in zip(names, boxes, strict=True)
    }


def _bounds(setup: Setup) -> dict[str, float]:
    wide = isinstance(setup, OtherSetup)
    return {'min': 1.0e3, 'max': 2.0e8} if wide else {'min': 5.0e3, 'max': 2.0e7}


def _held_margin(setup: Setup) -> float:
    return round(1.5 * setup.rim, 6) if isinstance(setup, OtherSetup) else _HELD_MARGIN


def _smooth_error(setup: Setup) -> dict[str, float]:
    """Return what the scene says of a smooth error, if anything."""
    if not isinstance(setup, OtherSetup) or setup.smooth_stated is None:
        return {}
    return {'smooth_error': setup.smooth_stated}


def _timed(setup: Setup, timing: Timing) -> dict[str, Any]:
    """Return what a scene of a released body says besides or instead."""
    shape = setup.shape
    body: dict[str, Any] = {
        'youngs_modulus': {'start': setup.start_modulus, 'min': 5.0e3, 'max': 2.0e7},
        'poissons_ratio': setup.poissons_ratio,
        'density': setup.density,
    }
    fit = ['youngs_modulus']
    if not timing.is_slow:
        mean = timing.stated_damping
        body['damping'] = {
            'start': mean,
            'min': 0.01,
            'max': 1.0e4,
            'prior': {'mean': mean, 'std': round(0.1 * mean, 6)},
        }
        fit.append('damping')
    return {
        'held': {
            'clamp': {'box': {'x': [float('-inf'), round(shape.clamp, 9)]}},
            'ledge': {'box': {'x': [round(shape.length - LEDGE, 9), float('inf')]}},
        },
        'regions': {'body': body},
        'fit': fit,
    }


def _motion(timing: Timing) -> dict[str, Any]:
    motion: dict[str, Any] = {'released': ['ledge'], 'at': timing.release}
    if timing.is_slow:
        motion['integrator'] = 'quasi_static'
    return {'motion': motion}


def extra_text(setup: Setup, without: str | None) -> str:
    """Write what the scene's format has no words for.

    Args:
        setup: the rig.
        without: effect that the workflow's library must lack in this case.
    """
    if isinstance(setup, OtherSetup):
        return _other_extra_text(setup, without)
    low, high = setup.stated_fixture
    shape = setup.shape
    return _dump(
        {
            'fixture': {
                'note': 'rigid block around the clamp, object frame [m]; it moves with the rig '
                'and not with the body',
                'box': _box(low, high),
            },
            'arc': {
                'note': 'arc position 0 is at the clamp, 1 at the tip; along the centre line, '
                'whose curvature about z is rest_arch [1/m]',
                'start': round(shape.clamp, 9),
                'length': round(shape.length - shape.clamp, 9),
                'rest_arch': round(shape.arch, 9),
            },
            'regions': 'cell data `region` of mesh.vtk: 0 at the clamp, 1 from half the free '
            'length on',
            'sensor_kind': setup.sensor.kind,
            'library_without': without,
        }
    )


def _other_extra_text(setup: OtherSetup, without: str | None) -> str:
    """Write the same of a body of another kind, which may have two clamps."""
    boxes = [_box(*block) for block in stated_fixtures(setup)]
    arcs = {
        'ahead': 'arc position 0 is at the clamp, 1 at the far end along x before any bend',
        'both': 'arc position 0 is at the clamp, 1 at the end of either arm; an arm is shorter',
        'between': 'arc position 0 is at either clamp, 1 amid the body',
        'feet': 'arc position 0 is at the clamp of either leg, 1 at the far end before any bend',
        'all': 'arc position 0 is at the clamp, 1 at the end of each arm; arms are not as long',
    }
    ends = setup.body.breaks[0]
    return _dump(
        {
            'fixture': {
                'note': 'rigid block around each clamp, object frame [m]; all move with the rig '
                'and not with the body',
                **({'box': boxes[0]} if len(boxes) == 1 else {'boxes': boxes}),
            },
            'arc': {
                'note': arcs[setup.body.arms],
                'start': round(setup.body.clamp, 9),
                'length': round(ends[-1] - setup.body.clamp, 9),
            },
            'regions': 'cell data `region` of mesh.vtk: 0 up to arc position 0.5, 1 from there on',
            'sensor_kind': setup.sensor.kind,
            'library_without': without,
        }
    )


def _box(low: FloatArray, high: FloatArray) -> dict[str, list[float]]:
    return {
        axis: [round(float(a), 9), round(float(b), 9)]
        for axis, a, b in zip('xyz', low, high, strict=True)
    }


def _placement(matrix: FloatArray) -> dict[str, Any]:
    rows = [[round(float(value), 12) + 0.0 for value in row] for row in matrix[:3]]
    return {
        'translation': [row[3] for row in rows],
        'rotation_matrix': [row[:3] for row in rows],
    }


def _dump(document: dict[str, Any]) -> str:
    text: str = yaml.safe_dump(document, sort_keys=False, default_flow_style=None, width=99)
    return text
