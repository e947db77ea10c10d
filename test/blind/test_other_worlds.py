# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A recording in another world: bodies, pictures and names are held against the first."""

from copy import deepcopy
from pathlib import Path
from typing import Any

from diffcal_ros.calibration.calibrate import Calibration, CalibrationSettings
from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest

from benchmarks.blind.cases import list_cases
from benchmarks.blind.generator import write_case as draw_and_write
from benchmarks.other_worlds.case_files import Case, read_case, write_case
from benchmarks.other_worlds.comparison import answer_of, compared
from benchmarks.other_worlds.worlds import NotOfThisWorldError, WORLDS

_ON_ITS_SIDE = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
_MODULUS = 3.1e5  # Not where the scene begins [Pa].


@pytest.fixture(scope='module')
def drawn(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp('drawn')
    case = next(case for case in list_cases('development') if case.poses > 2)
    draw_and_write(case, out)
    return out / 'cases' / case.id


@pytest.fixture(scope='module')
def case(drawn: Path) -> Case:
    return read_case(drawn)


def bodies_of(case: Case, folder: Path, modulus: float) -> list[np.ndarray]:
    """Return where each camera is predicted to see the nodes [m], at a modulus [Pa]."""
    write_case(case, folder)
    scene = load_scene(folder / 'scene.yaml')
    inputs = open_inputs(scene, [], pose_source='stored')
    settings = CalibrationSettings(fit=('youngs_modulus',))
    model = Calibration(inputs.scene, inputs.observations, settings).model
    coordinates = model.parameters.start()
    name = model.parameters.names.index('youngs_modulus')
    coordinates[name] = np.log(modulus)
    return [view.points for view in model.views(coordinates)]


@pytest.fixture(scope='module')
def bodies(case: Case, tmp_path_factory: pytest.TempPathFactory) -> list[np.ndarray]:
    return bodies_of(deepcopy(case), tmp_path_factory.mktemp('here') / 'case', _MODULUS)


@pytest.mark.parametrize('name', [name for name, world in WORLDS.items() if world.is_same])
@pytest.mark.slow_but_first
def test_a_body_is_the_same_one_there(
    name: str, case: Case, bodies: list[np.ndarray], tmp_path: Path
) -> None:
    world, changed = WORLDS[name], deepcopy(case)
    world.change(changed)
    found = bodies_of(changed, tmp_path / 'case', world.modulus * _MODULUS)
    expected = bodies[::-1] if name == 'in_reverse' else bodies
    # A body of the same density is as much stiffer as it is larger.
    size = {'larger': 2.5, 'smaller': 0.4}.get(name, 1.0)
    turn = _ON_ITS_SIDE if name == 'camera_on_its_side' else np.eye(3)
    for there, here in zip(found, expected, strict=True):
        np.testing.assert_allclose(there, size * here @ turn.T, atol=2e-6 * size)


@pytest.mark.parametrize('name', ['moved', 'larger', 'camera_on_its_side', 'fewer_pixels'])
def test_pictures_are_taken_by_the_camera_there(name: str, case: Case) -> None:
    changed = deepcopy(case)
    WORLDS[name].change(changed)
    size = 2.5 if name == 'larger' else 1.0
    for bag, before in ((changed.bags[key], case.bags[key]) for key in case.bags):
        assert bag.frames[0].depth.shape == (bag.camera.height, bag.camera.width)
        rows, columns = np.nonzero(np.isfinite(bag.frames[0].depth))
        assert len(rows) > 500
        depth = bag.frames[0].depth[rows, columns].astype(np.float64)
        rays = [
            (columns - bag.camera.cx) / bag.camera.fx,
            (rows - bag.camera.cy) / bag.camera.fy,
            np.ones(len(rows)),
        ]
        points = np.transpose(rays) * depth[:, None] / size
        if name == 'camera_on_its_side':
            points = points @ _ON_ITS_SIDE
        old = before.camera
        seen = points[:, :2] / points[:, 2:] * [old.fx, old.fy] + [old.cx, old.cy]
        pixels = np.rint(seen).astype(int)
        np.testing.assert_allclose(seen, pixels, atol=1e-3)
        np.testing.assert_allclose(
            points[:, 2], before.frames[0].depth[pixels[:, 1], pixels[:, 0]], rtol=1e-6
        )


def test_less_is_there_where_less_is_said(case: Case) -> None:
    def of(name: str) -> Case:
        changed = deepcopy(case)
        WORLDS[name].change(changed)
        return changed

    poses = [seen['name'] for seen in case.scene['observations']]
    assert [seen['name'] for seen in of('half_of_the_poses').scene['observations']] == poses[:2]
    assert {len(bag.frames) for bag in of('first_frame').bags.values()} == {1}
    coarse = of('whole_millimetres')
    key = next(iter(case.bags))
    before, after = (one.bags[key].frames[0].depth for one in (case, coarse))
    held = np.isfinite(before)
    assert np.abs(after - before)[held].max() < 0.51e-3
    assert len(np.unique(after[held])) < 0.5 * len(np.unique(before[held]))


def test_an_error_of_a_sensor_is_smooth_and_stands_in_part(case: Case) -> None:
    changed = deepcopy(case)
    WORLDS['worse_sensor'].change(changed)
    keys = list(case.bags)
    errors = [changed.bags[key].frames[0].depth - case.bags[key].frames[0].depth for key in keys]
    again = changed.bags[keys[0]].frames[1].depth - case.bags[keys[0]].frames[1].depth
    held = [np.isfinite(error) for error in errors]
    twice = held[0] & np.isfinite(again)
    np.testing.assert_allclose(errors[0][twice], again[twice], atol=1e-6)
    spread = np.sqrt(np.mean([np.mean(e[h] ** 2) for e, h in zip(errors, held, strict=True)]))
    assert 0.4e-3 < spread < 1.8e-3
    steps = np.diff(errors[0], axis=1)
    assert np.nanmax(np.abs(steps)) < 0.1 * spread
    both = held[0] & held[1]
    assert np.mean(np.abs(errors[0] - errors[1])[both]) > 0.0


def test_a_case_at_rest_is_of_no_world_of_motions(case: Case) -> None:
    with pytest.raises(NotOfThisWorldError, match='motions'):
        WORLDS['every_second_frame'].change(deepcopy(case))


def verdict(names: list[str], modulus: float, std_error: float) -> dict[str, Any]:
    return {
        'verdict': 'disagree' if names else 'agree',
        'effects': [{'identifier': name} for name in names],
        'unknown_classes': [],
        'gap_mm': {'nominal': 1.0, 'added': 0.2},
        'parameters': {
            'before': {'youngs_modulus': {'value': modulus, 'std_error': std_error}},
            'after': {},
        },
    }


@pytest.mark.parametrize(
    ('here', 'there', 'expected'),
    [
        (['a'], ['a'], (True, False, False)),
        (['a'], [], (False, False, True)),
        ([], ['a'], (False, True, False)),
        (['a'], ['b'], (False, True, True)),
        (['a'], ['a', 'b'], (False, True, False)),
    ],
)
def test_names_are_held_against_each_other(
    here: list[str], there: list[str], expected: tuple[bool, bool, bool]
) -> None:
    one, other = (answer_of(verdict(names, 1e5, 1e3)) for names in (here, there))
    found = compared(one, other, 1.0)
    assert (found['is_same'], found['contradicts'], found['lost_name']) == expected


def test_moduli_are_held_against_each_other_by_the_size_of_the_body() -> None:
    here = answer_of(verdict([], 1e5, 1e3))
    assert compared(here, answer_of(verdict([], 2.5e5, 2e3)), 2.5)['same_modulus']
    off = compared(here, answer_of(verdict([], 2.6e5, 2e3)), 2.5)
    assert off['modulus_off'] == pytest.approx(4.0)
    assert not off['same_modulus']
