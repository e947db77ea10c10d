# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Run docs/tutorial.md and make its pictures: `python docs/make_tutorial_pictures.py`.

Every block of the page that is marked as `sh` is run as it stands there, in an empty folder. It
needs mujoco for the last picture.
"""

import base64
import json
from pathlib import Path
import re
import runpy
import shlex
import subprocess
import sys
import tempfile
from typing import Any

from diffcal_ros.atomic_file import write_bytes_atomically
from diffcal_ros.report.figures.figure_png import new_figure, png_bytes
import meshio
import numpy as np

_ROOT = Path(__file__).resolve().parents[1]
_PAGE = _ROOT / 'docs' / 'tutorial.md'
_PICTURES = _ROOT / 'docs' / 'images'
_SECONDS = 2.0  # Of MuJoCo's time, until the body hangs still.
_COLORS = {'at rest': '#9ca3af', 'calibrated': '#2563eb', 'MuJoCo': '#ea580c'}


def commands(repository: Path) -> list[list[str]]:
    """Return the page's commands, one list of words each."""
    blocks = re.findall(r'^```sh\n(.*?)^```$', _PAGE.read_text(), re.MULTILINE | re.DOTALL)
    lines = ''.join(blocks).replace('REPOSITORY', str(repository)).splitlines()
    return [shlex.split(line) for line in lines]


def main() -> None:
    """Run the commands and write three pictures."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for words in commands(_ROOT):
            print(shlex.join(words))
            subprocess.run([program(words[0]), *words[1:]], cwd=folder, check=True)
        scene = str(folder / 'fit' / 'fitted_scene.yaml')
        words = [program('diffcal'), 'predict', scene, '--out', str(folder / 'shape')]
        subprocess.run(words, check=True)
        _write('tutorial_proposal', _first_picture(folder / 'scene' / 'proposal.html'))
        _write('tutorial_fit', _first_picture(folder / 'fit' / 'report.html'))
        _write('tutorial_mujoco', png_bytes(_side_view(folder)))


def program(name: str) -> str:
    """Return the path of this environment's own program, where it has one of that name."""
    own = Path(sys.executable).parent / name
    return str(own) if own.exists() else name


def _first_picture(page: Path) -> bytes:
    found = re.search(r'data:image/png;base64,([^"]+)', page.read_text())
    assert found is not None, f'{page} has no picture'
    return base64.b64decode(found[1])


def _write(name: str, png: bytes) -> None:
    path = _PICTURES / f'{name}.png'
    write_bytes_atomically(path, png)
    print(f'{path.relative_to(_ROOT)}: {len(png) / 1e3:.0f} kB')


def _side_view(folder: Path) -> Any:
    """Draw vertices from the side: along the body's length, and along gravity."""
    shapes = _shapes(folder)
    down = np.array(json.loads((folder / 'asset' / 'export.json').read_text())['gravity'])
    down /= np.linalg.norm(down)
    rest = shapes['at rest'] - shapes['at rest'].mean(axis=0)
    rest -= np.outer(rest @ down, down)
    along = np.linalg.svd(rest, full_matrices=False)[2][0]
    figure = new_figure(9.0, 4.2)
    panel = figure.subplots(1, 1)
    for name, points in shapes.items():
        away, drop = 1e3 * (points @ along), -1e3 * (points @ down)
        panel.plot(away, drop, '.', color=_COLORS[name], markersize=3.5, label=name)
    panel.set_aspect('equal')
    panel.set_xlabel('along the body [mm]')
    panel.set_ylabel('height [mm]')
    panel.legend(frameon=False, markerscale=3)
    panel.spines[['top', 'right']].set_visible(False)
    return figure


def _shapes(folder: Path) -> dict[str, np.ndarray]:
    """Return vertices [m] of the same mesh, shape (V, 3) each."""
    asset = folder / 'asset'
    sunk = runpy.run_path(str(asset / 'play_mjcf.py'))['play'](asset / 'body.xml', _SECONDS)
    body = meshio.read(folder / 'shape' / 'mesh' / '0000.vtu')
    # The mesh's own vertices stand before the nodes in the middle of its edges.
    moved, sag = (each[: len(sunk)] for each in (body.points, body.point_data['displacement']))
    return {'at rest': moved - sag, 'calibrated': moved, 'MuJoCo': moved - sag + sunk}


if __name__ == '__main__':
    main()
