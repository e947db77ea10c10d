# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Make the pictures of docs/web.md with Chromium: `python docs/make_web_pictures.py [NAME]`.

Both pages show the bundled sample. It needs viser, playwright and Debian's chromium.
"""

from collections.abc import Callable
from pathlib import Path
import shutil
import sys
import tempfile
from typing import Any

from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.offline.calibrate_recordings import open_inputs, run_calibration
from diffcal_ros.proposal.draft import Draft
from diffcal_ros.proposal.hold import Hold
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.save import save_fitted_scene
from diffcal_ros.web.fit_folder import read_fit
from diffcal_ros.web.fit_words import fit_words
from diffcal_ros.web.fitted_view import seen_fit
from diffcal_ros.web.proposed_setup import open_setup_page
from diffcal_ros.web.server import page_server
from diffcal_ros.web.view_page import DISTANCE, ViewPage
import numpy as np
from playwright.sync_api import sync_playwright

_ROOT = Path(__file__).resolve().parents[1]
_SCENE = _ROOT / 'bags' / 'sample' / 'scene.yaml'
_PICTURES = _ROOT / 'docs' / 'images'
_SIZE = {'width': 1280, 'height': 720}
_FLAGS = ('--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader')
_LONG = 240_000  # Without a GPU [ms].
# The sample's clamp begins at this row of vertices [m]; the page shows it lower and too soft.
_PLANE, _SHIFT, _MODULUS = 0.122, (0.0, -0.004, 0.0), 190e3


def main() -> None:
    """Serve both pages and take their pictures."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as driver:
        path = shutil.which('chromium')
        if path is None:
            raise SystemExit('Chromium is not installed: apt-get install chromium')
        browser = driver.chromium.launch(executable_path=path, args=list(_FLAGS))
        for name in sys.argv[1:] or _PAGES:
            _take(browser, name, Path(folder))
        browser.close()


def _take(browser: Any, name: str, folder: Path) -> None:
    """Take the picture of a page."""
    picture = _PICTURES / f'{name}.png'
    with page_server('127.0.0.1', 0) as server:
        end = _PAGES[name](server, folder)
        tab = browser.new_page(viewport=_SIZE)
        tab.set_default_timeout(_LONG)
        _open(server, tab)
        tab.wait_for_timeout(8000)
        tab.screenshot(path=str(picture), timeout=_LONG)
        tab.close()
        end()
    print(f'{picture.relative_to(_ROOT)}: {picture.stat().st_size / 1e3:.0f} kB')


def _open(server: Any, tab: Any) -> None:
    """Open the page, and close viser's word about WebGL in software."""
    tab.goto(f'http://127.0.0.1:{server.get_port()}')
    tab.wait_for_selector('canvas')
    notice = tab.get_by_text('WebGL is running in software mode').locator('xpath=../..')
    notice.get_by_role('button').click()


def _view(server: Any, folder: Path) -> Callable[[], None]:
    inputs = open_inputs(load_scene(_SCENE), [])
    _, result = run_calibration(inputs, CalibrationSettings(), folder)
    save_fitted_scene(inputs.scene, folder / 'fitted_scene.yaml', result.values())
    fit = read_fit(folder)
    page = ViewPage(server, seen_fit(fit, inputs), fit_words(fit.scene.name, fit.document))
    page.choose_colors(DISTANCE)
    return lambda: None


def _init(server: Any, folder: Path) -> Callable[[], None]:
    scene = load_scene(_SCENE)
    inputs = open_inputs(scene, [])
    setup = scene.observations[0]
    place = setup.world_from_object.copy()
    place[:3, 3] += _SHIFT
    hold = Hold(np.array([1.0, 0.0, 0.0]), _PLANE)
    draft = Draft(
        name=scene.name,
        mesh_file=_SCENE.parent / 'finger.vtk',
        unit='mm',
        bags=(_SCENE.parent / 'bag',),
        gravity=setup.gravity,
        world_from_object=place,
        hold=hold,
        held=hold.vertices(scene.mesh),
        youngs_modulus=_MODULUS,
        density=1080.0,
        poissons_ratio=0.49,
        marker=scene.marker,
    )
    page = open_setup_page(server, inputs, draft, folder / 'scene.yaml')
    page.ask_fit()
    page.worker.wait(_LONG / 1e3)
    return page.close


_PAGES = {'web_view': _view, 'web_init': _init}


if __name__ == '__main__':
    main()
