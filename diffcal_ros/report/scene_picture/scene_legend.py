# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Colours and the legend of a scene's drawing."""

from typing import Any

from diffcal_ros.marker import Marker
from diffcal_ros.report import palette
from diffcal_ros.report.figure_text import as_text
from diffcal_ros.report.scene_picture.scene_layout import world_triad
from diffcal_ros.rigid_transform import apply
from diffcal_ros.scene.model import ObservationSetup, Scene
from diffcal_ros.scene.posing import world_positions
from diffcal_ros.scene.sections.cables import start_cables
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

CABLE_COLOR = palette.CABLE
HELD_COLOR = '#1c1c1c'
TURNED_COLOR = '#d62728'
GRAVITY_COLOR = '#00796b'
CAMERA_COLOR = '#7b1fa2'
_REGION_COLORS = ('#5b8fc9', '#e2a04a', '#6fb07f', '#b57fb3', '#c9736b', '#8c8f5a')
_COLUMNS = 3


def region_color(number: int) -> str:
    """Return the colour of a region; colours repeat after the sixth."""
    return _REGION_COLORS[number % len(_REGION_COLORS)]


def add_legend(
    figure: Any, scene: Scene, setup: ObservationSetup, depth_from_world: FloatArray | None
) -> None:
    """Put title and legend on a figure.

    Args:
        figure: of matplotlib.
        scene: what is drawn.
        setup: the observation that is drawn.
        depth_from_world: pose of the camera that is drawn, shape (4, 4), or None.
    """
    count = len(scene.observations)
    which = f', observation {setup.name} (first of {count})' if count > 1 else ''
    figure.suptitle(
        f'{as_text(scene.name + which)}: {size_text(scene)}, {scene.mesh.vertex_count} vertices, '
        f'{scene.mesh.tet_count} tetrahedra ({scene.element.value})',
        fontsize=13,
    )
    handles = [
        *_region_handles(scene),
        *_held_handles(setup),
        *_cable_handles(scene, setup),
        *_rig_handles(scene, setup, depth_from_world),
    ]
    figure.legend(handles=handles, loc='lower center', ncol=_COLUMNS, fontsize=9.5, frameon=False)


def size_text(scene: Scene) -> str:
    """Write the size of the body's bounding box in its own frame."""
    sides = 1e3 * (scene.mesh.extent[1] - scene.mesh.extent[0])
    return ' x '.join(f'{side:.1f}' for side in sides) + ' mm'


def _region_handles(scene: Scene) -> list[Any]:
    from matplotlib.patches import Patch

    return [
        Patch(
            facecolor=region_color(number),
            label=f'{region.name}: {len(region.tets)} tetrahedra, '
            f'E starts at {region.youngs_modulus.start / 1e3:.4g} kPa',
        )
        for number, region in enumerate(scene.regions)
    ]


def _held_handles(setup: ObservationSetup) -> list[Any]:
    from matplotlib.lines import Line2D

    handles = []
    for part in setup.held:
        text = f'{as_text(part.name)}: {len(part.vertices)} vertices held'
        color = HELD_COLOR
        if part.turn is not None:
            text += f', turned by {np.rad2deg(part.turn.angle):.4g}°'
            color = TURNED_COLOR
        handles.append(Line2D([], [], color=color, marker='.', linestyle='', label=text))
    return handles


def _cable_handles(scene: Scene, setup: ObservationSetup) -> list[Any]:
    from matplotlib.lines import Line2D

    return [
        Line2D([], [], color=CABLE_COLOR, marker='.', label=f'cable {cable.name}: {text}')
        for cable, text in zip(scene.cables, cable_texts(scene, setup), strict=True)
    ]


def cable_texts(scene: Scene, setup: ObservationSetup) -> list[str]:
    """Say how far each cable is shortened in one posture."""
    texts = []
    for cable, state in zip(scene.cables, start_cables(scene, setup), strict=True):
        pull = 1e3 * (cable.length - state.rest_length)
        how = f'shortened by {pull:.4g} mm' if pull > 0.0 else f'{-pull + 0.0:.4g} mm slack'
        texts.append(f'route {1e3 * cable.length:.4g} mm, {how}')
    return texts


def _marker_text(marker: Marker) -> str:
    if marker.board is None:
        return f'marker {marker.id}, side {1e3 * marker.side:.4g} mm'
    board = marker.board
    return f'board of {board.columns}x{board.rows} squares, {1e3 * board.square:.4g} mm each'


def _rig_handles(
    scene: Scene, setup: ObservationSetup, depth_from_world: FloatArray | None
) -> list[Any]:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    rest = world_positions(scene.mesh, setup)
    origin, ends = world_triad(rest)
    where = '' if not origin.any() else ', moved to the body'
    length = 1e3 * float(np.linalg.norm(ends[0] - origin))
    handles: list[Any] = [
        Line2D([], [], color='#2f5fd0', label=f'world axes x y z, {length:.4g} mm long{where}')
    ]
    if scene.marker is not None:
        handles.append(Patch(facecolor='#303030', label=_marker_text(scene.marker)))
    if depth_from_world is None:
        text = 'camera: pose from the marker, not known yet'
        handles.append(Line2D([], [], linestyle='', label=text))
    else:
        depth = 1e3 * float(apply(depth_from_world, rest)[:, 2].mean())
        text = f'camera, the body at a depth of {depth:.0f} mm'
        handles.append(Line2D([], [], color=CAMERA_COLOR, label=text))
    return handles
