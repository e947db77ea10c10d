# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The page of `diffcal view`: a fitted body over what the camera measured."""

from collections.abc import Sequence
from typing import Any

from diffcal_ros.report.palette import FITTED
from diffcal_ros.report.scene_picture.scene_legend import HELD_COLOR
from diffcal_ros.web.fitted_view import SeenBody
from diffcal_ros.web.stage import (
    draw_camera,
    draw_held_box,
    draw_points,
    draw_surface,
    set_the_stage,
)
import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.int32]

CAMERA, DISTANCE = "the camera's image", 'distance to the simulated surface'
_OPACITY = 0.8
# Of the distance between points on the body: it shows between them.
_POINT = 0.45


class ViewPage:
    """Draws one observation at a time.

    Attributes:
        shown: the observation that is drawn.
    """

    def __init__(self, server: Any, bodies: Sequence[SeenBody], words: str) -> None:
        """Draw the first observation, and what chooses among them.

        Args:
            server: of viser.
            bodies: at least one.
            words: figures of the fit, Markdown.
        """
        self._server, self._bodies = server, bodies
        self.shown = bodies[0]
        self._nodes: list[Any] = []
        first = bodies[0]
        set_the_stage(server, first.gravity, first.world_from_depth, first.vertices.mean(axis=0))
        gui = server.gui
        gui.set_panel_label('diffcal view')
        gui.add_markdown(words)
        names = _distinct([body.name for body in bodies])
        self._names = dict(zip(names, bodies, strict=True))
        if len(bodies) > 1:
            choice = gui.add_dropdown('observation', names)
            choice.on_update(lambda event: self.choose(event.target.value))
        colored = [CAMERA] if any(body.by_camera is not None for body in bodies) else []
        self._colors = gui.add_dropdown('colour of points', [*colored, DISTANCE])
        self._scale = gui.add_markdown('')
        self._body = gui.add_checkbox('body', True)
        self._opacity = gui.add_slider('opacity of the body', 0.1, 1.0, 0.05, _OPACITY)
        self._held = gui.add_checkbox('what is held', True)
        self._points = gui.add_checkbox('measured points', True)
        self._size = gui.add_slider('size of points', 0.1, 1.5, 0.05, _POINT)
        for own in (
            self._colors,
            self._body,
            self._opacity,
            self._held,
            self._points,
            self._size,
        ):
            own.on_update(lambda event: self.draw())
        self.draw()

    def choose_colors(self, colors: str) -> None:
        """Colour the points by `CAMERA` or `DISTANCE`."""
        self._colors.value = colors

    def choose(self, name: str) -> None:
        """Draw another observation, by its name."""
        self.shown = self._names[name]
        self.draw()

    def draw(self) -> None:
        """Draw what is chosen, in place of what was drawn."""
        shown, scene = self.shown, self._server.scene
        by_camera = shown.by_camera if self._colors.value == CAMERA else None
        self._scale.content = _scale_words(shown) if by_camera is None else ''
        with self._server.atomic():
            for node in self._nodes:
                node.remove()
            self._nodes = [draw_camera(scene, shown.camera, shown.world_from_depth)]
            if self._points.value:
                size = self._size.value * shown.spacing
                colors = shown.by_distance if by_camera is None else by_camera
                self._nodes.append(draw_points(scene, shown.points, colors, size))
            if self._body.value:
                self._nodes.append(self._surface('/body', shown.triangles, FITTED))
            if self._held.value and len(shown.held_triangles):
                self._nodes.append(self._surface('/held', shown.held_triangles, HELD_COLOR))
                for number, (world_from_object, box) in enumerate(shown.held):
                    self._nodes.append(
                        draw_held_box(scene, f'/clamp/{number}', box, world_from_object)
                    )

    def _surface(self, name: str, triangles: IntArray, color: str) -> Any:
        opacity = None if self._opacity.value >= 1.0 else self._opacity.value
        return draw_surface(
            self._server.scene, name, self.shown.vertices, triangles, color, opacity
        )


def _scale_words(shown: SeenBody) -> str:
    reach = f'{1e3 * shown.scale:.2g} mm'
    return (
        f'Blue: measured {reach} or more before the simulated surface; orange: behind it; '
        'grey: beside the body.'
    )


def _distinct(names: Sequence[str]) -> list[str]:
    """Number names that occur more than once."""
    return [
        name if names.count(name) == 1 else f'{name} ({place})'
        for place, name in enumerate(names, start=1)
    ]
