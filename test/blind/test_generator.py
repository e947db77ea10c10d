# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A case as it is handed out, and the list of cases."""

from collections import Counter
import json
from pathlib import Path

from diffcal_ros.scene.load import load_scene
import numpy as np
import pytest
from rosbags.highlevel import AnyReader
import yaml

from benchmarks.blind.cases import CLEAN_COUNT, list_cases
from benchmarks.blind.generator import draw_case, write_case
from benchmarks.blind.labels import label_of
from benchmarks.blind.scene_file import extra_text, scene_text
from benchmarks.blind.seal import broken, seal
from benchmarks.blind.tetrahedra import mesh_tetrahedra


@pytest.fixture(scope='module')
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp('blind')
    write_case(list_cases('development')[0], out)
    return out


def test_sets_have_their_cases_and_share_no_shape() -> None:
    sets = {name: list_cases(name) for name in ('development', 'sealed')}
    expected = {'clean': CLEAN_COUNT, 'single': 99, 'pair': 20, 'outside': 20, 'denied': 11}
    for cases in sets.values():
        assert Counter(case.kind for case in cases) == expected
        assert len({case.id for case in cases}) == len(cases)
    families = [{case.family for case in cases} for cases in sets.values()]
    assert not families[0] & families[1]


def test_salt_changes_names_and_draws() -> None:
    plain, salted = list_cases('sealed'), list_cases('sealed', 'salt')
    assert [case.effects for case in plain] != [case.effects for case in salted]
    assert draw_case(plain[0])[0].youngs_modulus != draw_case(salted[0])[0].youngs_modulus


@pytest.mark.parametrize('set_name', ['development', 'sealed'])
def test_every_kind_and_family_can_be_written_down(set_name: str) -> None:
    cases = {(case.kind, case.family): case for case in list_cases(set_name)}
    for case in cases.values():
        if case.kind in ('single', 'pair', 'denied') and 'contact_plane' in str(case.effects):
            continue  # Drawing it takes a simulation.
        setup, effects, faults = draw_case(case)
        json.dumps(label_of(case, setup, effects, faults, np.zeros(3)))
        assert yaml.safe_load(scene_text(setup))['format'] == 1
        assert yaml.safe_load(extra_text(setup, case.without))['library_without'] == case.without
        points = mesh_tetrahedra(setup.shape).points
        assert points[:, 0].min() == 0.0


def test_case_is_readable_and_holds_no_label(written: Path) -> None:
    folder = written / 'cases' / 'clean_000'
    scene = load_scene(folder / 'scene.yaml')
    assert [setup.name for setup in scene.observations] == ['level']
    low, high = scene.mesh.extent
    box = yaml.safe_load((folder / 'extra.yaml').read_text())['fixture']['box']
    # The jaws enclose the held section.
    assert box['y'][0] < low[1] < high[1] < box['y'][1]
    true = draw_case(list_cases('development')[0])[0].youngs_modulus
    assert scene.regions[0].youngs_modulus.start != true
    text = ''.join(file.read_text() for file in folder.glob('*.yaml'))
    assert f'{true:.6g}' not in text


def test_bag_holds_noisy_frames_of_the_body(written: Path) -> None:
    frames, focal = [], 0.0
    with AnyReader([written / 'cases' / 'clean_000' / 'bag_level']) as reader:
        for connection, _, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            if connection.topic == '/depth/image_rect_raw':
                pixels = np.frombuffer(message.data, np.float32)
                frames.append(pixels.reshape(message.height, message.width))
            else:
                focal = message.k[0]
    assert len(frames) == 8
    assert focal == draw_case(list_cases('development')[0])[0].camera.fx
    stack = np.stack(frames)
    seen = np.isfinite(stack).all(axis=0)
    assert seen.sum() > 3000
    # Flying pixels apart, the frames differ by the sensor's noise.
    assert 5e-5 < np.median(stack[:, seen].std(axis=0)) < 4e-4


def test_written_cases_stay(written: Path) -> None:
    label = written / 'labels' / 'clean_000.json'
    before = label.stat().st_mtime_ns
    assert write_case(list_cases('development')[0], written) == 0.0
    assert label.stat().st_mtime_ns == before


def test_seal_finds_a_changed_label(written: Path, tmp_path: Path) -> None:
    sealed = seal(written / 'labels')
    assert broken(written / 'labels', sealed) == []
    copy = tmp_path / 'clean_000.json'
    copy.write_text((written / 'labels' / 'clean_000.json').read_text() + ' ')
    assert broken(tmp_path, sealed) == ['clean_000.json']
