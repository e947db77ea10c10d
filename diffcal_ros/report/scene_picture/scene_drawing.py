# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Draw a scene: body, clamp, loads, marker and camera, so that a slip is seen at a glance."""

from pathlib import Path
from typing import Any

from diffcal_ros.atomic_file import replacing
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.report.scene_picture.scene_layout import (
    camera_lines,
    gravity_arrow,
    marker_squares,
    overview,
    points_around,
    side_axes,
    side_view,
    surface_regions,
    turn_arc,
    world_triad,
)
from diffcal_ros.report.scene_picture.scene_legend import (
    add_legend,
    CABLE_COLOR,
    CAMERA_COLOR,
    GRAVITY_COLOR,
    HELD_COLOR,
    region_color,
    TURNED_COLOR,
)
from diffcal_ros.report.scene_picture.view import paint, View, visible_vertices
from diffcal_ros.rigid_transform import apply, inverse
from diffcal_ros.scene.model import ObservationSetup, Scene
from diffcal_ros.scene.posing import held_targets, world_positions
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]

_AXIS_COLORS = ('#d03030', '#2e9e3e', '#2f5fd0')


def draw_scene(
    scene: Scene,
    path: Path,
    *,
    depth_from_world: FloatArray | None = None,
    depth_camera: PinholeCamera | None = None,
) -> None:
    """Draw the first observation of a scene, undeformed, to one PNG.

    Args:
        scene: what to draw.
        path: the PNG; it is written completely or not at all.
        depth_from_world: camera pose, shape (4, 4); by default the stored one, if there is any.
        depth_camera: by default the scene's, if it gives one.

    Raises:
        InputError: when the file cannot be written.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    setup = scene.observations[0]
    pose = setup.stored_depth_from_world if depth_from_world is None else depth_from_world
    camera = scene.depth_camera if depth_camera is None else depth_camera
    figure = Figure(figsize=(14.0, 7.0), dpi=110)
    FigureCanvasAgg(figure)
    grid = figure.add_gridspec(1, 2, left=0.02, right=0.985, top=0.88, bottom=0.2, wspace=0.12)
    _draw_overview(figure.add_subplot(grid[0]), scene, setup, pose, camera)
    second = figure.add_subplot(grid[1])
    if pose is not None and camera is not None:
        _draw_camera_view(second, scene, setup, pose, camera)
    else:
        _draw_side_view(second, scene, setup)
    add_legend(figure, scene, setup, pose)
    with replacing(path) as fresh:
        figure.savefig(fresh, format='png')


def _draw_overview(
    axes: Any,
    scene: Scene,
    setup: ObservationSetup,
    depth_from_world: FloatArray | None,
    camera: PinholeCamera | None,
) -> None:
    rest = world_positions(scene.mesh, setup)
    world_from_depth = None if depth_from_world is None else inverse(depth_from_world)
    points = points_around(scene.marker, rest, setup.gravity, world_from_depth)
    view = overview(points, rest, setup.gravity, world_from_depth)
    if world_from_depth is not None:
        *frustum, axis = camera_lines(world_from_depth, camera, rest)
        for line in frustum:
            _line(axes, view, line, color=CAMERA_COLOR, linewidth=1.0)
        _line(axes, view, axis, color=CAMERA_COLOR, linewidth=0.8, linestyle='--')
        _label(axes, view, world_from_depth[:3, 3], 'camera', CAMERA_COLOR, above=True)
    _draw_marker(axes, view, scene, rest)
    _draw_body(axes, view, scene, setup, rest)
    _draw_triad(axes, view, rest)
    _draw_gravity(axes, view, rest, setup.gravity)
    axes.set_title('overview (perspective)', fontsize=11)
    axes.set_aspect('equal', adjustable='datalim')
    axes.margins(0.06)
    axes.invert_yaxis()
    axes.axis('off')


def _draw_side_view(axes: Any, scene: Scene, setup: ObservationSetup) -> None:
    rest = world_positions(scene.mesh, setup)
    view = side_view(rest, setup.gravity)
    _draw_marker(axes, view, scene, rest)
    _draw_body(axes, view, scene, setup, rest)
    _draw_gravity(axes, view, rest, setup.gravity)
    across, up = side_axes(view)
    axes.set_xlabel(f'{across} [mm]')
    axes.set_ylabel(f'{up} [mm]')
    axes.set_title('from the side (parallel), undeformed', fontsize=11)
    axes.set_aspect('equal')
    axes.margins(0.1)
    axes.invert_yaxis()
    # The page's y points down; the label tells of the direction that points up.
    axes.yaxis.set_major_formatter(_turned_number)
    axes.grid(color='#dddddd', linewidth=0.6)
    axes.set_axisbelow(True)


def _turned_number(value: float, _: int) -> str:
    # Taken from zero, so that zero itself gets no sign.
    return f'{0.0 - value:g}'.replace('-', '\N{MINUS SIGN}')


def _draw_camera_view(
    axes: Any,
    scene: Scene,
    setup: ObservationSetup,
    depth_from_world: FloatArray,
    camera: PinholeCamera,
) -> None:
    from matplotlib.patches import Rectangle

    rest = world_positions(scene.mesh, setup)
    view = View(depth_from_world, camera)
    _draw_marker(axes, view, scene, rest)
    _draw_body(axes, view, scene, setup, rest)
    _draw_gravity(axes, view, rest, setup.gravity)
    for u0, v0, u1, v1 in scene.masks.boxes:
        axes.add_patch(
            Rectangle(
                (u0 - 0.5, v0 - 0.5),
                u1 - u0 + 1,
                v1 - v0 + 1,
                fill=False,
                hatch='///',
                edgecolor='#888888',
                linewidth=0.8,
            )
        )
    axes.set_xlim(-0.5, camera.width - 0.5)
    axes.set_ylim(camera.height - 0.5, -0.5)
    axes.set_aspect('equal')
    axes.set_xlabel('column [px]')
    axes.set_ylabel('row [px]')
    page, _ = view.project(rest)
    inside = np.all((page >= -0.5) & (page < [camera.width - 0.5, camera.height - 0.5]), axis=1)
    seen = 'the body is out of view' if not inside.any() else f'{inside.mean():.0%} of it in view'
    axes.set_title(f"the depth camera's view, undeformed: {seen}", fontsize=11)


def _draw_body(
    axes: Any, view: View, scene: Scene, setup: ObservationSetup, rest: FloatArray
) -> None:
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import to_rgb

    triangles = scene.mesh.surface_triangles
    painted = paint(view, rest, triangles)
    targets = held_targets(setup, rest)
    is_held = np.zeros(len(rest), dtype=bool)
    is_held[targets.vertices] = True
    owner = surface_regions(scene)
    base = np.array([to_rgb(region_color(number)) for number in range(len(scene.regions))])
    colors = base[owner[painted.faces]]
    colors[is_held[triangles[painted.faces]].all(axis=1)] *= 0.62
    colors *= painted.brightness[:, None]
    axes.add_collection(
        PolyCollection(
            list(painted.corners),
            facecolors=colors,
            edgecolors=0.75 * colors,
            linewidths=0.25,
            zorder=2,
        )
    )
    axes.update_datalim(painted.corners.reshape(-1, 2))
    for cable in scene.cables:
        points = apply(setup.world_from_object, cable.via_points)
        _line(axes, view, points, color=CABLE_COLOR, linewidth=1.4, marker='.', zorder=3.2)
    for part in setup.held:
        color = HELD_COLOR if part.turn is None else TURNED_COLOR
        shown = visible_vertices(view, rest, triangles, part.vertices)
        page, _ = view.project(rest[shown])
        axes.plot(page[:, 0], page[:, 1], '.', color=color, markersize=2.4, zorder=3)
        if part.turn is not None:
            arc = turn_arc(part.turn, rest[part.vertices])
            _line(axes, view, arc, color=TURNED_COLOR, linewidth=1.6, zorder=4)
            _arrow(axes, view, arc[-2], arc[-1], TURNED_COLOR)


def _draw_marker(axes: Any, view: View, scene: Scene, rest: FloatArray) -> None:
    if scene.marker is None:
        return
    paper, black = marker_squares(scene.marker)
    _, depths = view.project(np.stack([paper.mean(axis=0), rest.mean(axis=0)]))
    order = 3.5 if depths[0] < depths[1] else 1.5  # The body is at 2, its held vertices at 3.
    for square, color in ((paper, '#ffffff'), *((one, '#303030') for one in black)):
        page, _ = view.project(square)
        if np.isfinite(page).all():
            axes.fill(
                page[:, 0],
                page[:, 1],
                facecolor=color,
                edgecolor='#303030',
                linewidth=0.8,
                zorder=order,
            )


def _draw_triad(axes: Any, view: View, rest: FloatArray) -> None:
    origin, ends = world_triad(rest)
    for name, end, color in zip('xyz', ends, _AXIS_COLORS, strict=True):
        _arrow(axes, view, origin, end, color)
        _label(axes, view, origin + 1.18 * (end - origin), name, color)


def _draw_gravity(axes: Any, view: View, rest: FloatArray, gravity: FloatArray) -> None:
    strength = float(np.linalg.norm(gravity))
    if strength == 0.0:
        return
    start, end = gravity_arrow(rest, gravity)
    _arrow(axes, view, start, end, GRAVITY_COLOR, width=2.4)
    _label(axes, view, start, f'gravity {strength:.3g} m/s²', GRAVITY_COLOR, above=True)


def _line(axes: Any, view: View, points_world: FloatArray, **style: Any) -> None:
    page, _ = view.project(points_world)
    axes.plot(page[:, 0], page[:, 1], **style)


def _arrow(
    axes: Any, view: View, start: FloatArray, end: FloatArray, color: str, width: float = 1.6
) -> None:
    page, _ = view.project(np.stack([start, end]))
    if not np.isfinite(page).all():
        return
    axes.update_datalim(page)
    axes.annotate(
        '',
        xy=page[1],
        xytext=page[0],
        zorder=5,
        annotation_clip=True,
        arrowprops={'arrowstyle': '-|>', 'color': color, 'lw': width, 'shrinkA': 0, 'shrinkB': 0},
    )


def _label(
    axes: Any, view: View, point: FloatArray, text: str, color: str, *, above: bool = False
) -> None:
    page, _ = view.project(point[None])
    if np.isfinite(page).all():
        axes.text(
            page[0, 0],
            page[0, 1],
            text,
            color=color,
            fontsize=9,
            ha='center',
            zorder=6,
            va='bottom' if above else 'center',
            clip_on=True,
            bbox={'facecolor': 'white', 'alpha': 0.7, 'edgecolor': 'none', 'pad': 1.0},
        )
