# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A scene in a few lines of text, for `diffcal check` and the head of a report."""

import os

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.report.scene_picture.scene_legend import cable_texts, size_text
from diffcal_ros.report.scene_picture.view import View
from diffcal_ros.scene.model import Fixture, MotionSetup, ObservationSetup, Quantity, Scene
from diffcal_ros.scene.posing import world_positions
from diffcal_ros.scene.reading.quantities import QUANTITY_RULES, QuantityRule, RELEASE_TIME
from diffcal_ros.scene.size_of_body import size_of_body
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

Row = tuple[str, str]


def scene_rows(scene: Scene) -> list[Row]:
    """Return label and text of each line; a label is empty where the line above goes on."""
    parts = [part.vertices for setup in scene.observations for part in setup.held]
    held_count = len(np.unique(np.concatenate(parts)))
    rows = [
        ('scene', f'{scene.name}' + (f' ({scene.path})' if scene.path else '')),
        ('body', f'{size_text(scene)}, {_mass_text(scene)}'),
        (
            'mesh',
            f'{scene.mesh.vertex_count} vertices, {scene.mesh.tet_count} tetrahedra, '
            f'{scene.element.value} element, {held_count} vertices held',
        ),
    ]
    for number, region in enumerate(scene.regions):
        label = 'region' if len(scene.regions) == 1 else f'region {number + 1}'
        rows.append((label, f'{region.name}: {len(region.tets)} tetrahedra'))
        rows += [
            ('', _quantity_text(rule, getattr(region, name)))
            for name, rule in QUANTITY_RULES.items()
            if getattr(region, name) is not None
        ]
    if scene.relative_modulus is not None:
        rows.append(('field', _field_text(scene.relative_modulus)))
    rows += [('fit', ', '.join(scene.fit)), ('marker', _marker_text(scene))]
    rows += [
        ('depth camera', _camera_text(scene.depth_camera)),
        ('color camera', _camera_text(scene.color_camera)),
    ]
    if scene.fixture is not None:
        rows.append(('fixture', _fixture_text(scene.fixture)))
    for setup in scene.observations:
        rows += _observation_rows(scene, setup)
    return rows + [('note', note) for note in scene.notes]


def format_rows(rows: list[Row]) -> str:
    """Put rows into two columns."""
    width = max(len(label) for label, _ in rows)
    return '\n'.join(f'{label:<{width}}  {text}'.rstrip() for label, text in rows)


def _mass_text(scene: Scene) -> str:
    volume, mass = scene.mesh.volumes.sum(), size_of_body(scene).mass
    return f'{1e6 * volume:.4g} cm^3, {1e3 * mass:.4g} g'


def _fixture_text(fixture: Fixture) -> str:
    size = ' x '.join(f'{side:.4g}' for side in 1e3 * np.ptp(fixture.positions, axis=0))
    return f'{size} mm, {len(fixture.triangles)} triangles, rigid'


def _quantity_text(rule: QuantityRule, quantity: Quantity) -> str:
    scale, unit = (1e-3, 'kPa') if rule.unit == 'Pa' else (1.0, rule.unit)
    text = (
        f'{rule.title} {scale * quantity.start:.4g} {unit}'.rstrip()
        + f', bounds {scale * quantity.lower:.4g} to {scale * quantity.upper:.4g}'
    )
    if quantity.prior_mean is not None and quantity.prior_std is not None:
        text += f', prior {scale * quantity.prior_mean:.4g} +- {scale * quantity.prior_std:.4g}'
    return text


def _field_text(relative_modulus: FloatArray) -> str:
    low, middle, high = np.percentile(relative_modulus, [5.0, 50.0, 95.0])
    return (
        f'the modulus of a tetrahedron is {low:.3g} (5 %), {middle:.3g} (median), {high:.3g} '
        "(95 %) times its region's"
    )


def _marker_text(scene: Scene) -> str:
    if scene.marker is None:
        return 'none: the camera pose must be stored'
    marker = scene.marker
    side = f'{1e3 * marker.side:.4g} mm'
    if marker.board is None:
        return f'{marker.dictionary}, id {marker.id}, side {side}'
    board = marker.board
    last = marker.id + board.marker_count - 1
    pattern = ', legacy pattern' if board.is_legacy else ''
    return (
        f'ChArUco board of {board.columns}x{board.rows} squares of {1e3 * board.square:.4g} mm, '
        f'{marker.dictionary} {marker.id} to {last}, side {side}{pattern}'
    )


def _camera_text(camera: PinholeCamera | None) -> str:
    if camera is None:
        return 'from camera_info'
    text = f'{camera.width}x{camera.height} px, fx {camera.fx:.2f}, fy {camera.fy:.2f}'
    return f'{text}, cx {camera.cx:.2f}, cy {camera.cy:.2f}'


def _observation_rows(scene: Scene, setup: ObservationSetup) -> list[Row]:
    gravity = ', '.join(f'{part:g}' for part in setup.gravity)
    rows = [('observation', f'{setup.name}: gravity ({gravity}) m/s^2')]
    for part in setup.held:
        text = f'{part.name} holds {len(part.vertices)} vertices'
        if part.turn is not None:
            axis = ', '.join(f'{value:.3g}' for value in part.turn.axis)
            text += f', turned by {np.rad2deg(part.turn.angle):.4g} deg about ({axis})'
        rows.append(('', text))
    for cable, text in zip(scene.cables, cable_texts(scene, setup), strict=True):
        rows.append(('', f'cable {cable.name}: {text}'))
    if setup.motion is not None:
        rows += _motion_rows(setup.motion)
    if setup.bag is not None:
        is_there = '' if setup.bag.exists() else ' (not there yet)'
        rows.append(('', f'recording {os.path.normpath(setup.bag)}{is_there}'))
    if setup.stored_depth_from_world is not None:
        rows.append(('', _pose_text(scene, setup, setup.stored_depth_from_world)))
    return rows


def _motion_rows(motion: MotionSetup) -> list[Row]:
    used = 'all of the recording' if motion.duration is None else f'{motion.duration:g} s'
    kept = f'one in {motion.hold_out} kept for the check' if motion.hold_out else 'all fitted'
    step = '' if motion.time_step is None else f' of at most {motion.time_step:g} s'
    if motion.tolerance is not None:
        step += f', each off by at most {1e3 * motion.tolerance:g} mm'
    names = ' and '.join(motion.released)
    return [
        ('', f'moves: {names} let go; {_quantity_text(RELEASE_TIME, motion.release_time)}'),
        ('', f'{motion.integrator} steps{step}'),
        ('', f'{used}, {motion.most_frames} frames at most, {kept}'),
    ]


def _pose_text(scene: Scene, setup: ObservationSetup, depth_from_world: FloatArray) -> str:
    page, depth = View(depth_from_world, scene.depth_camera).project(
        world_positions(scene.mesh, setup)
    )
    text = f'stored camera pose: the body at depths of {1e3 * depth.min():.0f} to '
    text += f'{1e3 * depth.max():.0f} mm'
    if scene.depth_camera is None:
        return text
    size = [scene.depth_camera.width, scene.depth_camera.height]
    inside = float(np.all((page >= -0.5) & (page < np.array(size) - 0.5), axis=1).mean())
    return f'{text}, {inside:.0%} of its vertices in view'
