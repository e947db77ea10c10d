# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a faulty camera sees of a body at rest."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from benchmarks.blind.biases import bias_share
from benchmarks.blind.bleeding import bleeding_share
from benchmarks.blind.blocks import in_blocks
from benchmarks.blind.combing import combed
from benchmarks.blind.crosstalk import crosstalk_error
from benchmarks.blind.fattening import fattened
from benchmarks.blind.faults import Faults
from benchmarks.blind.ghost import ghosted
from benchmarks.blind.hexahedra import HexMesh
from benchmarks.blind.jittering import jittered
from benchmarks.blind.lapsing import lapsed
from benchmarks.blind.mirrored import mirrored
from benchmarks.blind.moire import moire_error
from benchmarks.blind.paint import FIXTURE, Paint, tip_part
from benchmarks.blind.pane import through_pane
from benchmarks.blind.renderer import Camera, render, Rendering
from benchmarks.blind.rings import ring_error
from benchmarks.blind.rotations import applied, rigid, rotation
from benchmarks.blind.sensor import expose, scan, Sensor, smooth_field
from benchmarks.blind.setups import Observation, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.simulation import settle, Specimen
from benchmarks.blind.spiral import spiral_error
from benchmarks.blind.spokes import spoke_error
from benchmarks.blind.strips import chirp_error, sawtooth_error
from benchmarks.blind.surface import body_triangles, box_triangles, joined, moved
from benchmarks.blind.trailing import trailing_share

_SAGS = 0.8  # What a mount has yet to sag falls by so much of its logarithm from pose to pose.


def true_rendering(
    specimen: Specimen,
    setup: Setup,
    observation: Observation,
    faults: Faults,
    positions: FloatArray,
) -> Rendering:
    """Render body and fixture without noise, sensor faults included."""
    rendering = _seen(specimen, setup, observation, faults, positions)
    number = setup.pose_number(observation)
    if not faults.ghost or not number:
        return rendering
    earlier, fresh = setup.observations[number - 1], replace(faults, ghost=0.0)
    rested = settle(specimen, setup, earlier, fresh)
    return ghosted(rendering, _seen(specimen, setup, earlier, fresh, rested), faults.ghost)


def _seen(
    specimen: Specimen,
    setup: Setup,
    observation: Observation,
    faults: Faults,
    positions: FloatArray,
) -> Rendering:
    """Render what a sensor sees that has seen nothing before."""
    mesh = specimen.mesh
    across = mesh.lattice[:, 1] / (0.5 * setup.shape.section[0])
    along = specimen.shares - faults.region_slant * np.clip(across, -1.0, 1.0)
    surface = joined(
        body_triangles(
            mesh,
            positions,
            along,
            _paint(_border(setup, observation, faults), faults),
            _covered(mesh, setup, faults),
        ),
        *(box_triangles(*block, FIXTURE) for block in setup.fixtures),
    )
    world_from_object = observation.world_from_object
    moved_by = _camera_share(setup, observation, faults)
    camera_from_world = true_camera(specimen, setup, jostled(setup, observation, faults), moved_by)
    camera = _true_intrinsics(setup.camera, faults, _focused(setup, observation, faults))
    camera = _cropped(camera, setup, observation, faults)
    surface = through_pane(moved(surface, camera_from_world @ world_from_object), faults)
    rendering = fattened(render(surface, camera), camera, faults.fattened)
    rendering = combed(rendering, camera, faults.combed)
    rendering = lapsed(rendering, camera, faults.lapsed, faults.lapsed_row)
    rendering = jittered(rendering, camera, faults.jittered, faults.jittered_seed)
    bias = 1e-3 * faults.depth_bias * bias_share(rendering, setup, observation, faults)
    scale = faults.depth_scale
    if faults.depth_form == 'temperature':
        scale *= setup.pose_number(observation) / max(len(setup.observations) - 1, 1)
    depth = rendering.depth * (1.0 + 0.01 * scale) + bias + _wiggle(rendering, faults)
    depth = depth + _stripes(rendering, faults) + _tiles(rendering, setup.camera, faults)
    depth = depth + _jump(rendering, faults) + _bleeding(rendering, faults)
    depth = depth + _trailing(rendering, faults)
    depth = depth + _flicker(rendering, setup, observation, faults)
    depth = depth + ring_error(rendering, setup, faults) + moire_error(rendering, setup, faults)
    depth = depth + spoke_error(rendering, setup, faults) + crosstalk_error(rendering, faults)
    depth = depth + spiral_error(rendering, setup, faults) + sawtooth_error(rendering, faults)
    depth = depth + chirp_error(rendering, setup, faults)
    tip = _painted(tip_part(rendering.labels), faults) * rendering.facing**faults.region_gloss
    glows = _glowing(setup, observation, faults)
    depth = depth + 1e-3 * faults.region_bias * glows * tip
    depth = np.maximum(depth, _least_depth(faults))
    seen = replace(rendering, depth=_miscounted(_in_steps(depth, faults), faults))
    seen = in_blocks(seen, faults.blocky)
    return mirrored(seen, setup.camera, faults.mirrored, faults.mirrored_at)


def _wiggle(rendering: Rendering, faults: Faults) -> FloatArray | float:
    """Return an error that swings with the depth [m], as that of sampled phases does."""
    if not faults.wiggle:
        return 0.0
    seen = np.where(np.isfinite(rendering.depth), rendering.depth, 0.0)
    angle = 2.0 * np.pi * seen / (1e-3 * faults.wiggle_period) + faults.wiggle_phase
    return np.asarray(1e-3 * faults.wiggle * np.sin(angle))


def _stripes(rendering: Rendering, faults: Faults) -> FloatArray | float:
    """Return an error that swings over the image's columns [m]."""
    if not faults.stripes:
        return 0.0
    columns = rendering.column + np.arange(rendering.depth.shape[1])
    angle = 2.0 * np.pi * columns / faults.stripes_period + faults.stripes_phase
    return np.asarray(1e-3 * faults.stripes * np.sin(angle))[None, :, None]


def _flicker(
    rendering: Rendering, setup: Setup, observation: Observation, faults: Faults
) -> FloatArray | float:
    """Return an error that swings over the image's rows, by a phase of each pose [m]."""
    if not faults.flicker:
        return 0.0
    rows = rendering.row + np.arange(rendering.depth.shape[0])
    phase = faults.flicker_phases[setup.pose_number(observation)]
    angle = 2.0 * np.pi * rows / faults.flicker_period + phase
    return np.asarray(1e-3 * faults.flicker * np.sin(angle))[:, None, None]


def _tiles(rendering: Rendering, camera: Camera, faults: Faults) -> FloatArray | float:
    """Return an error that each square of the image has of its own [m]."""
    if not faults.tiles:
        return 0.0
    height, width = rendering.depth.shape[:2]
    rows = (rendering.row + np.arange(height)) // faults.tiles_edge
    columns = (rendering.column + np.arange(width)) // faults.tiles_edge
    count = (camera.height // faults.tiles_edge + 1, camera.width // faults.tiles_edge + 1)
    errors = np.random.default_rng(faults.tiles_seed).standard_normal(count)
    return np.asarray(1e-3 * faults.tiles * errors[rows[:, None], columns[None]])[..., None]


def _jump(rendering: Rendering, faults: Faults) -> FloatArray | float:
    """Return an error that is there beyond a depth alone [m]."""
    if not faults.jump:
        return 0.0
    return np.asarray(1e-3 * faults.jump * (rendering.depth > faults.jump_from))


def _bleeding(rendering: Rendering, faults: Faults) -> FloatArray | float:
    """Return an error that falls from a body's outline inwards [m]."""
    if not faults.bleeding:
        return 0.0
    return 1e-3 * faults.bleeding * bleeding_share(rendering, faults.bleeding_width)


def _trailing(rendering: Rendering, faults: Faults) -> FloatArray | float:
    """Return an error that falls from where a beam comes to a body, down the columns [m]."""
    if not faults.trailing:
        return 0.0
    return 1e-3 * faults.trailing * trailing_share(rendering, faults.trailing_width)


def _painted(tip: FloatArray, faults: Faults) -> FloatArray:
    """Return how much of a region's error is there, where a second paint is what is halfway."""
    if not faults.region_second:
        return tip
    return np.where((tip > 0.0) & (tip < 1.0), -faults.region_back, tip)


def _paint(border: float, faults: Faults) -> Paint:
    """Return what is the tip's of a surface, from a share of the free length on."""
    return Paint(
        tip_from=border,
        ramp=faults.region_ramp,
        tip_until=faults.region_until,
        bands=faults.region_bands,
        is_wound=faults.region_wound,
        speckle=(faults.region_dot, faults.region_cover, faults.region_seed),
        decay=faults.region_decay,
        sun=faults.region_sun,
        second=faults.region_second,
        strokes=faults.region_strokes,
        dips=faults.region_dips,
        board=faults.region_board,
        stickers=faults.region_stickers,
        net=faults.region_net,
        bell=faults.region_bell,
        tongue=faults.region_tongue,
        edges=faults.region_edges,
        flakes=(faults.region_flakes, faults.region_seed),
        bars=faults.region_bars,
    )


def _covered(mesh: HexMesh, setup: Setup, faults: Faults) -> FloatArray | None:
    """Return what is above 0 where a region is on a section, at the nodes, shape (N,).

    Strips lie along the middle of each side: where one of both places across, 1 and -1 at the
    sides, is less than their width; the other is 1 or -1 on the surface. None: it is all around.
    """
    if faults.region_strip:
        across = mesh.lattice[:, 1:] / (0.5 * np.array(setup.shape.section))
        return np.asarray(1.0 + faults.region_strip**2 - (across**2).sum(axis=1))
    return mesh.lattice[:, 2] if faults.region_above else None


def _least_depth(faults: Faults) -> float:
    """Return the least depth that a sensor tells, which it tells of all that is nearer [m]."""
    return faults.clipped_near + 1e-3 * faults.clipped if faults.clipped else 0.0


def _in_steps(depth: FloatArray, faults: Faults) -> FloatArray:
    """Return the nearest of the depths that a sensor tells [m]."""
    if not faults.coarse:
        return depth
    step = 1e-3 * faults.coarse
    return np.asarray(step * np.round(depth / step))


def _miscounted(depth: FloatArray, faults: Faults) -> FloatArray:
    """Return depths in which one bit is the same whatever it should be [m]."""
    if not faults.stuck:
        return depth
    worth, is_set = 1e-3 * abs(faults.stuck), faults.stuck > 0.0
    counted = np.where(np.isfinite(depth), depth, 0.0) / worth
    is_wrong = (np.floor(counted) % 2.0 == 1.0) != is_set
    return np.asarray(depth + 1e-3 * faults.stuck * is_wrong)


def _camera_share(setup: Setup, observation: Observation, faults: Faults) -> float:
    """Return how much of the camera's error is there in a pose."""
    if faults.camera_from:
        return float(setup.pose_number(observation) >= faults.camera_from)
    if faults.camera_sags:
        last = max(len(setup.observations) - 1, 1)
        number = setup.pose_number(observation)
        return float(np.expm1(-_SAGS * number) / np.expm1(-_SAGS * last))
    return setup.reached(observation) if faults.camera_drifts else 1.0


def jostled(setup: Setup, observation: Observation, faults: Faults) -> Faults:
    """Return faults whose camera is off as it is in one pose."""
    if not faults.camera_scatter:
        return faults
    more = np.array(faults.camera_scatter[setup.pose_number(observation)])
    shift, turn = faults.camera_shift + more[:3], faults.camera_turn + more[3:]
    return replace(faults, camera_shift=tuple(shift), camera_turn=tuple(turn))


def _border(setup: Setup, observation: Observation, faults: Faults) -> float:
    """Return the share of the free length from which on depths of a region err in a pose."""
    places = faults.region_places
    return places[setup.pose_number(observation)] if places else faults.region_from


def _glowing(setup: Setup, observation: Observation, faults: Faults) -> float:
    """Return how much of a region's error is there in a pose."""
    return faults.region_shares[setup.pose_number(observation)] if faults.region_shares else 1.0


def _focused(setup: Setup, observation: Observation, faults: Faults) -> float:
    """Return how much of the error of scale and middle is there in a pose."""
    return faults.focus_shares[setup.pose_number(observation)] if faults.focus_shares else 1.0


def _true_intrinsics(camera: Camera, faults: Faults, focused: float) -> Camera:
    scale = 1.0 + focused * faults.focal_scale
    return replace(
        camera,
        fx=camera.fx * (scale + faults.aspect),
        fy=camera.fy * (scale - faults.aspect),
        cx=camera.cx + focused * faults.center_shift[0],
        cy=camera.cy + focused * faults.center_shift[1],
        radial=faults.radial_distortion,
        tangential=faults.tangential,
        wobble=(faults.wobble, faults.wobble_period, faults.wobble_phase),
        skew=faults.skewed,
        tilt=faults.imager_tilt,
        drop=(*faults.droplet_at, faults.droplet, faults.droplet_width),
    )


def _cropped(camera: Camera, setup: Setup, observation: Observation, faults: Faults) -> Camera:
    """Return a camera whose image was cut out elsewhere in a pose than is known."""
    if not faults.center_scatter:
        return camera
    across, down = faults.center_scatter[setup.pose_number(observation)]
    return replace(camera, cx=camera.cx + across, cy=camera.cy + down)


def true_camera(
    specimen: Specimen, setup: Setup, faults: Faults, share: float = 1.0
) -> FloatArray:
    """Return depth_from_world of the camera as it stands, off by a share, shape (4, 4)."""
    foot = faults.camera_foot
    center = camera_center(specimen, setup) if foot is None else np.array(foot)
    turn = rotation(share * np.deg2rad(faults.camera_turn))
    shift = share * 1e-3 * np.array(faults.camera_shift)
    # What is fixed to the camera goes to turn (x - center) + center + shift: the inverse of
    # that takes the points that the stored camera would see to those that the true one sees.
    moved_back = rigid(turn.T, center - turn.T @ (center + shift))
    return moved_back @ setup.depth_from_world


def camera_center(specimen: Specimen, setup: Setup) -> FloatArray:
    """Return the point that a wrong camera turns about [m], in its stored frame, shape (3,)."""
    # One camera for all poses: it is off by the same motion in each.
    nodes = applied(setup.observations[0].world_from_object, specimen.mesh.nodes)
    middle = 0.5 * (nodes.min(axis=0) + nodes.max(axis=0))
    return applied(setup.depth_from_world, middle[None])[0]


def film(
    renderings: Sequence[Rendering],
    setup: Setup,
    pattern: FloatArray,
    random: np.random.Generator,
) -> list[NDArray[np.float32]]:
    """Take one noisy frame of each view [m], shape (H, W) each; smooth errors stay."""
    camera, sensor = setup.camera, setup.sensor
    own = smooth_field((camera.height, camera.width), sensor.bias_length, random)
    bias = sensor.bias * (
        np.sqrt(sensor.standing) * pattern + np.sqrt(1.0 - sensor.standing) * own
    )
    return [_frame(view, camera, sensor, bias, random) for view in renderings]


def _smooth_error(sensor: Sensor, pattern: FloatArray, own: FloatArray) -> FloatArray:
    """Return what stands in all poses with what is a pose's own [m], from fields of size 1."""
    standing = sensor.standing
    return sensor.bias * (np.sqrt(standing) * pattern + np.sqrt(1.0 - standing) * own)


def _frame(
    rendering: Rendering,
    camera: Camera,
    sensor: Sensor,
    bias: FloatArray,
    random: np.random.Generator,
) -> NDArray[np.float32]:
    view = scan(rendering, camera, sensor.wall)
    rows = slice(rendering.row, rendering.row + view.depth.shape[0])
    columns = slice(rendering.column, rendering.column + view.depth.shape[1])
    image = np.full((camera.height, camera.width), np.nan, dtype=np.float32)
    image[rows, columns] = expose(view, sensor, bias[rows, columns], random)
    return image


def record(
    rendering: Rendering,
    setup: Setup,
    pattern: FloatArray,
    random: np.random.Generator,
) -> list[NDArray[np.float32]]:
    """Take noisy frames [m], each of shape (H, W).

    Args:
        rendering: exact view.
        setup: its sensor and camera.
        pattern: smooth error of the sensor that all poses share [m], shape (H, W).
        random: source of the noise.
    """
    camera, sensor = setup.camera, setup.sensor
    shape = (camera.height, camera.width)
    # Temperature and surface change a part of it from pose to pose.
    own = smooth_field(shape, sensor.bias_length, random)
    bias = sensor.bias * (
        np.sqrt(sensor.standing) * pattern + np.sqrt(1.0 - sensor.standing) * own
    )
    view = scan(rendering, camera, sensor.wall)
    rows = slice(rendering.row, rendering.row + view.depth.shape[0])
    columns = slice(rendering.column, rendering.column + view.depth.shape[1])
    frames = []
    for _ in range(setup.frames):
        image = np.full(shape, np.nan, dtype=np.float32)
        image[rows, columns] = expose(view, sensor, bias[rows, columns], random)
        frames.append(image)
    return frames
