# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Both pages in a real browser: Chromium without a window, with WebGL in software."""

from collections.abc import Iterator
import shutil
from typing import Any

from diffcal_ros.rigid_transform import apply, inverse, rotation_from_quaternion, transform
from diffcal_ros.scene.load import load_scene
from diffcal_ros.web.fit_folder import read_fit
from diffcal_ros.web.fit_words import fit_words
from diffcal_ros.web.fitted_view import seen_fit
from diffcal_ros.web.setup_handles import PLACE
from diffcal_ros.web.setup_page import FIT, SAVE, TAKE
from diffcal_ros.web.view_page import ViewPage
import numpy as np
import pytest
from support.recorded_beam import MODULUS

pytestmark = pytest.mark.slow
playwright = pytest.importorskip(
    'playwright.sync_api', reason='playwright is not installed: pip install playwright'
)

LONG = 240_000  # On a busy machine without a GPU [ms].
SIZE = {'width': 1280, 'height': 800}
FLAGS = (
    *('--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-sync'),
    *('--disable-background-networking', '--disable-component-update'),
    *('--use-angle=swiftshader', '--enable-unsafe-swiftshader'),
)


@pytest.fixture(scope='module')
def browser() -> Iterator[Any]:
    path = shutil.which('chromium') or shutil.which('chromium-browser')
    if path is None:
        pytest.skip('Chromium is not installed: apt-get install chromium')
    with playwright.sync_playwright() as driver:
        own = driver.chromium.launch(executable_path=path, args=list(FLAGS))
        yield own
        own.close()


@pytest.fixture
def tab(browser, server) -> Iterator[Any]:
    own = browser.new_page(viewport=SIZE)
    own.set_default_timeout(LONG)
    own.goto(f'http://127.0.0.1:{server.get_port()}')
    own.wait_for_selector('canvas')
    yield own
    own.close()


def until(tab, is_so, seconds=LONG / 1e3):
    """Let the browser go on until something is so."""
    for _ in range(int(10 * seconds)):
        if is_so():
            return
        tab.wait_for_timeout(100)
    raise AssertionError(f'it was not so within {seconds:g} s')


def is_settled(server):
    """Tell whether the browser looks from where the page says, beside the docked panel."""
    cameras = [client.camera for client in server.get_clients().values()]
    there = np.array(server.initial_camera.position)
    return any(
        np.abs(np.array(camera.position) - there).max() < 1e-3
        and camera.image_width < SIZE['width']
        for camera in cameras
    )


def pixel(server, point):
    """Return where a point of the world is on the page, from the camera that the browser told."""
    (client,) = server.get_clients().values()
    camera = client.camera
    w, *vector = camera.wxyz
    world_from_view = transform(
        rotation_from_quaternion(np.array([*vector, w])), np.array(camera.position)
    )
    x, y, z = apply(inverse(world_from_view), np.asarray(point))
    focal = 0.5 * camera.image_height / np.tan(0.5 * camera.fov)
    middle = 0.5 * np.array([camera.image_width, camera.image_height])
    return middle + focal * np.array([x, y]) / z


def saved_scene(page, tab, path):
    tab.get_by_role('button', name=SAVE, exact=True).click()
    tab.get_by_text('saved as').wait_for()
    return load_scene(path)


def test_a_number_is_typed_fitted_taken_and_saved(page, tab, tmp_path):
    tab.get_by_label('in kPa').fill('120')
    until(tab, lambda: page.arrangement.youngs_modulus == 120e3)
    scene = saved_scene(page, tab, tmp_path / 'scene.yaml')
    assert scene.regions[0].youngs_modulus.start == 120e3
    tab.get_by_role('button', name=FIT, exact=True).click()
    take = tab.get_by_role('button', name=TAKE, exact=True)
    until(tab, take.is_enabled)
    take.click()
    until(tab, lambda: page.arrangement is page.fitted.arrangement)
    tab.get_by_text('saved as').wait_for(state='detached')
    scene = saved_scene(page, tab, tmp_path / 'scene.yaml')
    assert scene.regions[0].youngs_modulus.start == pytest.approx(MODULUS, rel=0.1)
    place = scene.observations[0].world_from_object
    assert place == pytest.approx(page.fitted.arrangement.world_from_object, abs=1e-5)


def test_an_arrow_is_dragged_and_the_place_is_saved(page, tab, server, tmp_path):
    until(tab, lambda: is_settled(server))
    before = page.arrangement.world_from_object
    handle = server.scene.get_handle_by_name(PLACE)
    # On the arrow up the world's y axis.
    up = np.array([0.0, 1.0, 0.0])
    start = np.array(handle.position) + 0.8 * handle.scale * up
    first, last = pixel(server, start), pixel(server, start + 0.03 * up)
    tab.mouse.move(*first)
    tab.wait_for_timeout(2000)
    tab.mouse.down()
    tab.mouse.move(*last, steps=6)
    tab.mouse.up()
    until(tab, lambda: page.arrangement.world_from_object[1, 3] > before[1, 3] + 0.02)
    tab.wait_for_timeout(2000)
    moved = page.arrangement.world_from_object
    # The arrow moves along itself alone, about as far as the mouse.
    assert moved[:3, 3] - before[:3, 3] == pytest.approx([0.0, 0.03, 0.0], abs=0.006)
    scene = saved_scene(page, tab, tmp_path / 'scene.yaml')
    assert scene.observations[0].world_from_object == pytest.approx(moved, abs=1e-5)


def test_a_fit_is_looked_at(server, fitted_beam, tab):
    fit = read_fit(fitted_beam.folder)
    page = ViewPage(server, seen_fit(fit, fit.open()), fit_words(fit.scene.name, fit.document))
    tab.get_by_text('converged: The fit is done.').wait_for()
    before = tab.screenshot(timeout=LONG)
    tab.get_by_label('measured points').click()
    until(tab, lambda: '/points' not in {node.name for node in page._nodes})
    until(tab, lambda: tab.screenshot(timeout=LONG) != before)
