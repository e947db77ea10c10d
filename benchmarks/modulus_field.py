# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fields of moduli: what a gradient costs, a synthetic twin, and the real captures.

    python benchmarks/modulus_field.py [gradient] [twin] [real]

needs `DIFFCAL_DATA`, the root of the public DiffCal data set. The twisted capture is turned by
-180 degrees, which fits the scan where +180 does not.
"""

from collections.abc import Iterable
from dataclasses import replace
import json
import os
from pathlib import Path
import sys
import tempfile
from typing import Any

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.field.fit import fit_field
from diffcal_ros.calibration.field.layout import FieldKind, tets_from_unknowns
from diffcal_ros.calibration.field.linear_system import FieldSystem
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.residuals.gap import measure_gap
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.fem.statics.force_changes import Change
from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.recording.dataset.import_case import import_case
from diffcal_ros.report.figures.along_body import along_body
from diffcal_ros.report.figures.observed_view import observed_views
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import Scene
from diffcal_ros.synthetic.filming import Timing
from diffcal_ros.synthetic.recorder import record, RecorderSettings
from measuring import machine, RESULTS, timed
import numpy as np
import yaml

QUICK = CalibrationSettings(with_mesh_error=False)
OFFSET, STEP = ('rigid_offset',), ('rigid_offset', 'depth_bias_by_region')
MODULUS = 'youngs_modulus'
# What the two halves of the twin are made of [Pa].
STIFF, SOFT = 380e3, 120e3
# The size of h_e_c's Ecoflex: a body that is clamped at both ends shows ratios, not sizes.
SIZE_PRIOR = {'mean': 132000.0, 'std': 25000.0}


def imported(folder: Path) -> dict[str, Path]:
    """Import both captures as the paper took them for its fields, on one mesh of 3,414.

    Returns:
        Scene files of two regions.
    """
    root = Path(os.environ['DIFFCAL_DATA'])
    scenes = {}
    for case in ('h_em_c', 't_em_c'):
        import_case(root, case, folder / case)
        import_case(root, f'{case}_tetwise', folder / f'{case}_tetwise')
        regions = yaml.safe_load((folder / case / 'scene.yaml').read_text())['regions']
        tetwise = folder / f'{case}_tetwise' / 'scene.yaml'
        scenes[case] = changed(tetwise, 'two', regions=regions)
    scenes['coarse'] = folder / 'h_em_c' / 'scene.yaml'
    return scenes


def changed(path: Path, stem: str, /, **changes: Any) -> Path:
    """Write a copy of a scene beside it, with keys replaced."""
    document = {**yaml.safe_load(path.read_text()), **changes}
    fresh = path.with_name(f'{stem}.yaml')
    kept = {key: value for key, value in document.items() if value is not None}
    fresh.write_text(yaml.safe_dump(kept, sort_keys=False))
    return fresh


def twisted_back(path: Path) -> Path:
    """Turn the far block the other way, and give the soft half a size."""
    document = yaml.safe_load(path.read_text())
    document['held']['far_block']['turn']['angle_deg'] = -180
    document['regions']['ecoflex_50']['youngs_modulus']['prior'] = SIZE_PRIOR
    return changed(path, 'turned', **document)


def as_one(path: Path) -> Path:
    """Forget that there are two materials."""
    regions = yaml.safe_load(path.read_text())['regions']
    body = dict(regions['ecoflex_50'])
    body.pop('rest')
    return changed(path, f'{path.stem}_one', regions={'body': body})


def together(hanging: Path, twisted: Path) -> Path:
    """Write one scene of both captures, on the mesh of the twisted one."""
    first, second = (yaml.safe_load(path.read_text()) for path in (hanging, twisted))
    turn = second['held']['far_block'].pop('turn')
    own = ('placement', 'stored_depth_from_world')
    observations = [
        {
            'name': 'hanging',
            'bag': str(hanging.parent / 'bag'),
            'held_parts': ['clamp'],
            **{key: first[key] for key in own},
        },
        {
            'name': 'twisted',
            'bag': str(twisted.parent / 'bag'),
            'held_parts': ['clamp', 'far_block'],
            'held_turns': {'far_block': turn},
            **{key: second[key] for key in own},
        },
    ]
    return changed(
        twisted,
        'both',
        **dict.fromkeys((*own, 'bag')),
        held=second['held'],
        observations=observations,
        # The body was placed by hand before each.
        rigid_offset={**second['rigid_offset'], 'each_recording': True},
    )


def opened(path: Path) -> tuple[Scene, list[Observation]]:
    """Read a scene with its recordings."""
    scene = load_scene(path)
    return scene, list(open_inputs(scene, []).observations)


def is_stiff(scene: Scene) -> np.ndarray:
    """Tell which tetrahedra are of the stiff silicone."""
    return scene.mesh.centroids[:, 0] < 0.0


def area_under_curve(values: np.ndarray, is_high: np.ndarray) -> float:
    """Return how often a value of one class is above one of the other."""
    return float((values[is_high][:, None] > values[~is_high]).mean())


def gaps(calibration: Calibration) -> dict[str, Any]:
    """Return the gap of each observation."""
    objective = calibration.objective
    compared = objective.comparisons(calibration.coordinates)
    return {
        seen.name: measure_gap([c.difference], [c.counted], objective.truncation).as_dict()
        for seen, c in zip(calibration.model.observations, compared, strict=True)
    }


def where(calibration: Calibration, result: Any) -> dict[str, Any]:
    """Return the size of the gap along the body and in each region [mm]."""
    found = {}
    for view in observed_views(calibration, result):
        along = along_body(calibration, view)
        found[view.observation.name] = {
            kind: {share.label: round(1e3 * share.size, 3) for share in shares}
            for kind, shares in (('along', along.fitted), ('regions', along.regions))
        }
    return found


def fitted(path: Path, fit: Iterable[str], *, with_field: bool) -> dict[str, Any]:
    """Fit a scene, without or with a field."""
    scene, observations = opened(path)
    calibration = Calibration(scene, observations, replace(QUICK, fit=tuple(fit)))
    result = calibration.run()
    entry: dict[str, Any] = {'tets': scene.mesh.tet_count}
    if with_field:
        field = fit_field(calibration, result, FieldKind())
        result, stiff = field.result, is_stiff(scene)
        entry['auc_of_the_halves'] = area_under_curve(field.youngs_modulus, stiff)
        for name, half in (('moldstar_15', stiff), ('ecoflex_50', ~stiff)):
            entry[f'median_of_{name}'] = float(np.median(field.youngs_modulus[half]))
        entry['field'] = field.as_dict()
    return {
        **entry,
        'outcome': result.outcome.value,
        'parameters': {p.name: [p.value, p.std_error] for p in result.parameters},
        'gap': gaps(calibration),
        'where': where(calibration, result),
        'seconds': result.seconds,
    }


def gradient(scenes: dict[str, Path]) -> dict[str, Any]:
    """Time one gradient by the modulus of the body, and one by those of all tetrahedra."""
    scene, observations = opened(as_one(twisted_back(scenes['t_em_c'])))
    calibration = Calibration(scene, observations, replace(QUICK, fit=(MODULUS,)))
    model, objective = calibration.model, calibration.objective
    calibration.run()
    coordinates = calibration.coordinates
    (view,), (comparison,) = model.views(coordinates), objective.comparisons(coordinates)
    depth, edge = comparison.depth, comparison.edge
    trace = view.trace

    def scalar() -> None:
        model.body(model.observations[0]).factor()
        change = Change(youngs_modulus=model.material(coordinates).youngs_modulus)
        (tangent,) = model.tangents_of(lambda *_: [change], coordinates)
        by_depth = trace.push_depth(depth.indices, tangent)
        by_edge = trace.push_outline(edge.indices, tangent)
        depth.values @ by_depth + edge.values @ by_edge

    def by_tets() -> None:
        model.body(model.observations[0]).factor()
        by_points = trace.pull_depth(depth.indices, depth.values)
        by_points += trace.pull_outline(edge.indices, edge.values)
        model.pull_back_to_tets([by_points], coordinates)

    def at(step: float) -> None:
        # Elsewhere and back: an equilibrium and a factorisation, as in every evaluation of a fit.
        model.views(coordinates + step)
        model.views(coordinates)

    figures: dict[str, Any] = {'tets': scene.mesh.tet_count, 'pixels': len(depth.values)}
    for name, work in (('scalar', scalar), ('by_tets', by_tets)):
        figures[f'{name}_alone'] = timed(work)
        figures[f'{name}_with_equilibrium'] = timed(lambda work=work: (at(0.01), work()))
    for kind in ('alone', 'with_equilibrium'):
        ratio = figures[f'by_tets_{kind}']['fastest_s'] / figures[f'scalar_{kind}']['fastest_s']
        figures[f'ratio_{kind}'] = ratio
    spread = tets_from_unknowns(scene.mesh, FieldKind())
    system = FieldSystem(objective, coordinates, spread)
    ones = np.ones(scene.mesh.tet_count)
    figures['curvature_times_a_field'] = timed(lambda: system.known(ones))
    return figures


def twin(scenes: dict[str, Path], folder: Path) -> dict[str, Any]:
    """Film h_em_c's beam of two halves on one mesh, and fit a field on the other."""
    figures = {}
    files = {
        '1750': next(scenes['coarse'].parent.glob('*.tet')),
        '3414': next(scenes['h_em_c'].parent.glob('*.tet')),
    }
    for name, other in (('1750', '3414'), ('3414', '1750')):
        hanging = yaml.safe_load(scenes['h_em_c'].read_text())
        regions = hanging['regions']
        for region, modulus in (('moldstar_15', STIFF), ('ecoflex_50', SOFT)):
            regions[region]['youngs_modulus'] = modulus
        true = changed(
            scenes['h_em_c'],
            f'true_{name}',
            regions=regions,
            mesh={**hanging['mesh'], 'file': str(files[other])},
        )
        camera = open_inputs(load_scene(scenes['h_em_c']), []).observations[0].camera
        settings = RecorderSettings(
            timing=Timing(frames=3), color_frames=3, depth_camera=camera, seed=3
        )
        made = record(load_scene(true), folder / f'twin_{name}', settings, overwrite=True)
        fit = changed(
            as_one(scenes['h_em_c']),
            f'fit_{name}',
            bag=str(made.bags['observation']),
            mesh={**hanging['mesh'], 'file': str(files[name])},
        )
        figures[name] = fitted(fit, (MODULUS, *OFFSET), with_field=True)
    return figures


def real(scenes: dict[str, Path]) -> dict[str, Any]:
    """Fit both captures, alone and together, with two moduli and with a field."""
    turned = twisted_back(scenes['t_em_c'])
    paths = {
        'h_em_c': scenes['h_em_c'],
        't_em_c': turned,
        'both': together(scenes['h_em_c'], turned),
    }
    figures: dict[str, Any] = {}
    for name, path in paths.items():
        one = as_one(path)
        figures[name] = {
            'two_regions': fitted(path, (MODULUS, *OFFSET), with_field=False),
            'field': fitted(one, (MODULUS, *OFFSET), with_field=True),
            'two_regions_and_step': fitted(path, (MODULUS, *STEP), with_field=False),
            'field_on_two_regions_and_step': fitted(path, (MODULUS, *STEP), with_field=True),
        }
        print(json.dumps({name: {k: v['gap'] for k, v in figures[name].items()}}, indent=1))
    return figures


def main() -> None:
    """Run the studies that are named, or all, and keep those of earlier runs."""
    asked = sys.argv[1:] or ['gradient', 'twin', 'real']
    path = RESULTS / 'modulus_field.json'
    known = json.loads(path.read_text())['figures'] if path.exists() else {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        scenes = imported(folder)
        for study in asked:
            if study == 'gradient':
                known[study] = gradient(scenes)
            elif study == 'twin':
                known[study] = twin(scenes, folder)
            elif study == 'real':
                known[study] = real(scenes)
            else:
                raise SystemExit(f'{study!r} is no study: gradient, twin or real')
            path.write_text(json.dumps({'machine': machine(), 'figures': known}, indent=2) + '\n')


if __name__ == '__main__':
    main()
