# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Figures of the report: one scale in millimetres, and what they draw is what was measured."""

from dataclasses import replace
import warnings

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.report.figures.along_body import along_body, BIN_COUNT, distance_from_clamp
from diffcal_ros.report.figures.along_body_figure import along_body_figure
from diffcal_ros.report.figures.convergence_figure import convergence_figure
from diffcal_ros.report.figures.depth_figure import depth_figure, depth_range, RESIDUAL_LIMIT
from diffcal_ros.report.figures.figure_png import png_bytes
from diffcal_ros.report.figures.observed_view import observed_views
from diffcal_ros.report.figures.picture import picture_figure, save_picture
from diffcal_ros.report.palette import correlation_color
import numpy as np
import pytest


def images(figure):
    """Images by the title of their panel, without shades drawn over them."""
    return {
        panel.get_title(): panel.get_images()[0] for panel in figure.axes if panel.get_images()
    }


def test_depth_images_share_one_scale_and_residuals_another(view):
    limits = depth_range([view])
    shown = images(depth_figure(view, limits))
    depths = ('measured depth', 'simulated, start values', 'simulated, fitted values')
    assert {shown[name].get_clim() for name in depths} == {limits}
    residuals = [f'measured − simulated, {word} values' for word in ('start', 'fitted')]
    assert {shown[name].get_clim() for name in residuals} == {(-RESIDUAL_LIMIT, RESIDUAL_LIMIT)}


def test_images_hold_millimetres_of_their_window(view):
    shown = images(depth_figure(view, depth_range([view])))
    window = (view.rows, view.columns)
    measured = np.ma.filled(shown['measured depth'].get_array(), np.nan)
    np.testing.assert_allclose(measured, 1e3 * view.observation.depth[window], rtol=1e-6)
    left = np.ma.filled(shown['measured − simulated, fitted values'].get_array(), np.nan)
    counted = view.fitted.counted[window]
    expected = 1e3 * (view.observation.depth - view.fitted.depth)[window]
    np.testing.assert_allclose(left[counted], expected[counted], atol=1e-4)
    assert np.isnan(left[~counted]).all()


def test_simulated_depth_is_what_the_sensor_would_read(fitted, view):
    calibration, result = fitted
    bias = 0.004
    scene = replace(calibration.scene, effects={'depth_affine': {'scale': 0.0, 'bias': bias}})
    far = Calibration(scene, calibration.model.observations, calibration.settings)
    (read,) = observed_views(far, result)
    seen = np.isfinite(view.fitted.depth)
    np.testing.assert_allclose((read.fitted.depth - view.fitted.depth)[seen], bias, atol=1e-9)
    both = np.isfinite(view.fitted.residual)
    np.testing.assert_allclose(
        (read.fitted.residual - view.fitted.residual)[both], -bias, atol=1e-9
    )


def test_the_window_holds_the_body_and_the_scale_its_depths(view):
    low, high = depth_range([view])
    for picture in (view.start, view.fitted):
        seen = np.isfinite(picture.depth)
        assert seen[view.rows, view.columns].sum() == seen.sum()
        inside = (1e3 * picture.depth[seen] > low) & (1e3 * picture.depth[seen] < high)
        assert inside.mean() > 0.99


def test_a_scale_of_several_views_holds_them_all(view):
    farther = replace(view, fitted=replace(view.fitted, depth=view.fitted.depth + 0.1))
    assert depth_range([view, farther])[1] > depth_range([view])[1] + 90.0


def test_the_fit_brings_outline_and_depth_together(view):
    start, fitted = view.start, view.fitted
    assert np.median(np.abs(fitted.edge_residuals)) < 0.5 * np.median(np.abs(start.edge_residuals))
    # Points of the measured outline lie on the simulated one within two pixels.
    distances = np.linalg.norm(fitted.edge_points[:, None] - fitted.outline[None], axis=2)
    assert np.median(distances.min(axis=1)) < 2.0


def test_bins_along_the_body_hold_every_counted_pixel(fitted, view):
    along = along_body(fitted[0], view)
    assert len(along.fitted) == BIN_COUNT == len(along.borders) - 1
    assert sum(share.pixels for share in along.fitted) == view.fitted.counted.sum()
    (region,) = along.regions
    assert (region.label, region.pixels) == ('body', view.fitted.counted.sum())
    limit = fitted[0].scene.masks.truncation
    residual = view.fitted.residual[view.fitted.counted]
    kept = residual[np.abs(residual) < limit]
    assert region.median == pytest.approx(np.median(kept))
    assert region.size == pytest.approx(np.median(np.abs(kept)))


def test_distances_start_at_the_clamp_whichever_way_the_body_points(random):
    rest = random.uniform((0.0, 0.0, 0.0), (0.2, 0.02, 0.02), (400, 3))
    for held, tip in ((rest[rest[:, 0] > 0.15], 0.0), (rest[rest[:, 0] < 0.05], 0.2)):
        distance = distance_from_clamp(rest, held)
        farthest = rest[np.argmax(distance), 0]
        assert farthest == pytest.approx(tip, abs=0.01)
        assert distance.max() == pytest.approx(0.15, abs=0.01)


def test_bins_without_a_pixel_leave_a_figure(fitted, view):
    nothing = np.zeros_like(view.fitted.counted)
    empty = replace(view, fitted=replace(view.fitted, counted=nothing))
    with warnings.catch_warnings():
        warnings.simplefilter('error')
        along = along_body(fitted[0], empty)
        figure = along_body_figure(along)
    assert all(np.isnan(share.median) for share in along.fitted)
    low, high = figure.axes[0].get_ylim()
    assert -low == high > 0.0


def test_convergence_shows_every_step(fitted):
    _, result = fitted
    figure = convergence_figure(result)
    panels = {panel.get_title(): panel for panel in figure.axes}
    losses = panels['loss (half a chi-square)'].get_lines()[0].get_ydata()
    np.testing.assert_array_equal(losses, [record.loss for record in result.history])
    gap = {line.get_label(): line.get_ydata() for line in panels['gap on the body'].get_lines()}
    assert gap['median'][-1] == pytest.approx(1e3 * result.gap_end.median)
    assert gap['rms'][0] == pytest.approx(1e3 * result.gap_start.rms)
    labels = [line.get_label() for panel in figure.axes for line in panel.get_lines()]
    assert "Young's modulus" in labels
    assert 'rigid offset, turn about z' in labels


def test_the_picture_shows_three_images_in_one_scale(fitted, tmp_path):
    figure = picture_figure(*fitted)
    shown = images(figure)
    assert list(shown) == ['measured', 'simulated, before', 'simulated, fitted']
    assert len({image.get_clim() for image in shown.values()}) == 1
    words = [panel.get_xlabel() for panel in figure.axes]
    assert 'beam' in words[0]
    assert "Young's modulus 126 kPa" in words[1]
    assert '±' in words[2]
    save_picture(tmp_path / 'picture.png', *fitted)
    # The same picture gives the same bytes, so that it changes only when it must.
    assert (tmp_path / 'picture.png').read_bytes() == png_bytes(picture_figure(*fitted))
    assert (tmp_path / 'picture.png').stat().st_size < 200_000


def test_correlation_colours_can_be_read():
    for value in np.linspace(-1.0, 1.0, 21):
        background, ink = (brightness(color) for color in correlation_color(value))
        assert abs(background - ink) > 90.0, value
    assert correlation_color(1.0)[0] != correlation_color(-1.0)[0]


def brightness(color):
    red, green, blue = (int(color[k : k + 2], 16) for k in (1, 3, 5))
    return 0.299 * red + 0.587 * green + 0.114 * blue
