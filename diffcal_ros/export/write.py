# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Export a fit: the asset, a script that plays it, and a list of what it holds."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from diffcal_ros.atomic_file import write_json_atomically, write_text_atomically
from diffcal_ros.errors import InputError
from diffcal_ros.export import players
from diffcal_ros.export.effective_numbers import read_effective, with_effective
from diffcal_ros.export.exported_body import exported_body, ExportedBody
from diffcal_ros.export.targets import find_target
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.observation_choice import observation_index

_SCENES = ('fitted_scene.yaml', 'scene.yaml')
_LIST = 'export.json'
_RESULT = 'result.json'


@dataclass(frozen=True)
class Export:
    """What was written.

    Attributes:
        body: that the files hold.
        moduli: whose they are: the material's, or effective ones.
        files: the asset's main file first, then its player and the list.
    """

    body: ExportedBody
    moduli: str
    files: tuple[Path, ...]


def export_fit(
    fit: Path,
    target: str,
    out: Path,
    *,
    observation: str | None = None,
    takes_effective: bool = True,
) -> Export:
    """Write a fitted body as an asset.

    Args:
        fit: folder of `diffcal calibrate`, or a scene file, whose start values are taken.
        target: name of one, see `export.targets`.
        out: folder to write to.
        observation: whose clamp and gravity the asset has; None: the first one's.
        takes_effective: take what `diffcal calibrate --for` found for the target's simulator,
            where the fit's folder has it.

    Raises:
        InputError: when the fit cannot be read, a package is missing, or `out` not be written.
    """
    scene_file = find_scene(fit)
    scene = load_scene(scene_file)
    setup = scene.observations[observation_index(scene, observation or '')]
    body = exported_body(scene, setup)
    writer = find_target(target)
    moduli = 'material'
    if takes_effective and writer.SIMULATOR and fit.is_dir():
        numbers = read_effective(fit / _RESULT, writer.SIMULATOR)
        if numbers is not None:
            body, moduli = with_effective(body, numbers), f'effective for {writer.SIMULATOR}'
    files = writer.write(body, out)
    player = Path(players.__file__).with_name(f'play_{target}.py')
    write_text_atomically(out / player.name, player.read_text(encoding='utf-8'))
    document = {
        'source': str(scene_file),
        'target': target,
        'moduli': moduli,
        **describe(body),
    }
    write_json_atomically(out / _LIST, document)
    return Export(body, moduli, (*files, out / player.name, out / _LIST))


def find_scene(fit: Path) -> Path:
    """Return the scene file that a fit's folder holds, or the file itself.

    Raises:
        InputError: when there is none.
    """
    if fit.is_file():
        return fit
    for name in _SCENES:
        if (fit / name).is_file():
            return fit / name
    raise InputError(
        f'{fit} holds no {_SCENES[0]}: give the folder of a `diffcal calibrate` that ended with a '
        'fit, or a scene file'
    )


def describe(body: ExportedBody) -> dict[str, Any]:
    """Return what an asset holds, for its list, in SI units."""
    weights = body.mesh.volumes
    regions = {}
    for number, name in enumerate(body.region_names):
        own = body.region == number
        fraction = weights[own] / weights[own].sum()
        regions[name] = {
            'tetrahedra': int(own.sum()),
            'youngs_modulus': float(fraction @ body.youngs_modulus[own]),
            'poissons_ratio': float(fraction @ body.poissons_ratio[own]),
            'density': float(fraction @ body.density[own]),
            'strain_rate_damping': float(fraction @ body.damping[own]),
            'stiffness_damping': float(fraction @ body.stiffness_damping[own]),
        }
    return {
        'name': body.name,
        'vertices': body.mesh.vertex_count,
        'tetrahedra': body.mesh.tet_count,
        'held_vertices': len(body.held),
        'volume': body.volume,
        'mass': body.mass,
        'gravity': body.gravity.tolist(),
        'regions': regions,
        'notes': list(body.notes),
    }
