# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Cables in pictures and tables: drawn on the body, where the simulated body is."""

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.report import palette
from diffcal_ros.report.figures.depth_figure import depth_figure, depth_range
from diffcal_ros.report.figures.observed_view import observed_views
from diffcal_ros.report.naming import short_values, title
from diffcal_ros.report.scene_picture.scene_drawing import draw_scene
from diffcal_ros.report.tables.scene_table import format_rows, scene_rows
import numpy as np
import pytest
from support.fingers import cable, filmed, finger_scene, via_points


@pytest.mark.slow
def test_cables_are_drawn_on_the_simulated_body() -> None:
    seen = filmed(cable('tendon', 0.02, via_points()))
    scene = finger_scene(cable('tendon', 0.005, via_points()))
    calibration = Calibration(scene, [seen], CalibrationSettings(with_mesh_error=False))
    (view,) = observed_views(calibration, calibration.run())
    for picture in (view.start, view.fitted):
        (points,) = picture.cables
        columns, rows = np.round(points).astype(int).T
        # Every via point lies inside of the body, and so in front of or behind its picture.
        assert np.isfinite(picture.depth[rows, columns]).all()
    moved = np.linalg.norm(view.start.cables[0] - view.fitted.cables[0], axis=1)
    assert moved[-1] > 20.0 > 5.0 > moved[0]
    figure = depth_figure(view, depth_range([view]))
    lines = [line for axes in figure.axes for line in axes.lines]
    assert sum(line.get_color() == palette.CABLE for line in lines) == 2


def test_cables_are_in_the_scene_s_drawing_and_table(tmp_path) -> None:
    scene = finger_scene(
        cable('tendon', 0.018, via_points()), cable('loose', -0.002, via_points(0.007))
    )
    draw_scene(scene, tmp_path / 'scene.png')
    assert (tmp_path / 'scene.png').stat().st_size > 10000
    table = format_rows(scene_rows(scene))
    assert 'cable tendon: route 135 mm, shortened by 18 mm' in table
    assert 'cable loose: route 135 mm, 2 mm slack' in table


def test_names_for_people() -> None:
    assert title('rest_length.tendon') == 'rest length, tendon'
    assert short_values({'rest_length': 0.1234}) == 'rest length 123.4 mm'
