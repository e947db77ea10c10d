# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The page of a fit, as its server has it; a browser is opened in `test_in_browser.py`."""

from dataclasses import replace

from diffcal_ros.cli.main import EXIT_BAD_INPUT, main
from diffcal_ros.web.fit_folder import read_fit
from diffcal_ros.web.fitted_view import seen_fit
from diffcal_ros.web.view_page import DISTANCE, ViewPage
import numpy as np
import pytest


@pytest.fixture(scope='module')
def bodies(fitted_beam):
    fit = read_fit(fitted_beam.folder)
    (first,) = seen_fit(fit, fit.open())
    second = replace(first, name='another', vertices=first.vertices + 0.1, by_camera=None)
    return [first, second]


def drawn(page):
    return {node.name for node in page._nodes}


def test_body_points_clamp_and_camera_are_drawn(server, bodies):
    page = ViewPage(server, bodies, 'words')
    assert drawn(page) == {'/camera', '/points', '/body', '/held', '/clamp/0'}
    (points,) = [node for node in page._nodes if node.name == '/points']
    assert np.array_equal(points.colors, bodies[0].by_camera)


def test_what_is_chosen_is_drawn(server, bodies):
    page = ViewPage(server, bodies, 'words')
    page.choose_colors(DISTANCE)
    page._held.value = False
    page.choose('another')
    assert drawn(page) == {'/camera', '/points', '/body'}
    (points,) = [node for node in page._nodes if node.name == '/points']
    assert np.array_equal(points.colors, bodies[1].by_distance)
    assert 'orange: behind it' in page._scale.content


def test_a_missing_viser_and_a_missing_rerun_are_told(fitted_beam, monkeypatch, capsys, tmp_path):
    for package, arguments in (('viser', ()), ('rerun', ('--rrd', str(tmp_path / 'fit.rrd')))):
        monkeypatch.setitem(__import__('sys').modules, package, None)
        assert main(['view', str(fitted_beam.folder), *arguments]) == EXIT_BAD_INPUT
        assert 'python -m pip install' in capsys.readouterr().err
    assert not (tmp_path / 'fit.rrd').exists()
