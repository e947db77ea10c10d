# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Write everything a prediction shows: depth, meshes and a film, a folder an observation."""

from dataclasses import dataclass
from pathlib import Path

from diffcal_ros.errors import InputError
from diffcal_ros.prediction.depth_files import write_depth_bag, write_depth_files
from diffcal_ros.prediction.mesh_sequence import MESH_FORMATS, write_meshes
from diffcal_ros.prediction.predicted_view import PredictedView
from diffcal_ros.recording.mp4_file import check_mp4
from diffcal_ros.report.figures.film import FILM_FORMATS, write_film, write_still

_DEPTH, _MESH, _BAG, _FILM, _STILL = 'depth', 'mesh', 'bag', 'film', 'depth.png'


@dataclass(frozen=True)
class PredictionOutputs:
    """What is written.

    Attributes:
        mesh: one of `MESH_FORMATS`.
        with_bag: write a bag, too.
        slowdown: how many times slower than in truth the film plays.
        overwrite: replace a prediction that is there.
        film: one of `FILM_FORMATS`.
    """

    mesh: str = 'vtu'
    with_bag: bool = False
    slowdown: float = 4.0
    overwrite: bool = False
    film: str = 'gif'

    def __post_init__(self) -> None:
        if self.mesh not in MESH_FORMATS:
            raise InputError(f'mesh format is {self.mesh!r}: {", ".join(MESH_FORMATS)} are known')
        if self.film not in FILM_FORMATS:
            raise InputError(f'film format is {self.film!r}: {", ".join(FILM_FORMATS)} are known')
        if not 0.01 <= self.slowdown <= 1000.0:
            raise InputError(f'the slow motion is {self.slowdown:g}: give 0.01 to 1000')


def check_outputs(out: Path, outputs: PredictionOutputs) -> None:
    """Refuse what cannot be written, before anything slow begins.

    Raises:
        InputError: for a folder that holds something, or a film that cannot be encoded; it says
            what to do.
    """
    if outputs.film == 'mp4':
        check_mp4()
    if out.exists() and not out.is_dir():
        raise InputError(f'{out} is a file: name a folder')
    if out.is_dir() and any(out.iterdir()) and not outputs.overwrite:
        raise InputError(f'{out} is not empty: choose another folder, or add --overwrite')


def write_prediction(
    views: list[PredictedView], out: Path, outputs: PredictionOutputs
) -> list[tuple[str, Path]]:
    """Write the files; those of several observations go to folders of their names.

    Returns:
        What was written, as words and paths.

    Raises:
        InputError: when a body leaves the view, or the folder cannot be written.
    """
    rows = []
    for view in views:
        folder = out if len(views) == 1 else out / view.body.setup.name
        rows += _write(view, folder, outputs)
    return rows


def _write(
    view: PredictedView, folder: Path, outputs: PredictionOutputs
) -> list[tuple[str, Path]]:
    body = view.body
    # Depth first: it is what fails where the camera sees nothing.
    write_depth_files(view, folder / _DEPTH)
    rows = [('depth', folder / _DEPTH)]
    meshes = write_meshes(body, folder / _MESH, outputs.mesh)
    if meshes is not None:
        rows.append(('mesh', meshes))
    if outputs.with_bag:
        write_depth_bag(view, folder / _BAG, overwrite=outputs.overwrite)
        rows.append(('bag', folder / _BAG))
    title = f'{view.scene.name}: {body.setup.name}'
    if len(body.times) == 1:
        write_still(folder / _STILL, next(view.depths()), title=title)
        return [*rows, ('picture', folder / _STILL)]
    film = folder / f'{_FILM}.{outputs.film}'
    write_film(film, view.depths, body.times.tolist(), title=title, slowdown=outputs.slowdown)
    return [*rows, ('film', film)]
