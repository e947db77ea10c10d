# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is not named is accepted on request alone, and it is said how."""

import json
from pathlib import Path

from diffcal_ros.diagnosis.verdict.acceptance import accept
from diffcal_ros.errors import InputError
from diffcal_ros.scene.model_file import read_versions
import pytest


def _diagnosed(folder: Path, *alike: str) -> Path:
    """Write a verdict without a name that leaves effects open; return its folder."""
    candidates = [
        {
            'identifier': name,
            'amplitude': {'mass': 10.0},
            'std_error': {'mass': 1.0},
            'setting': {'at': 0.7},
            'confidence': 0.5,
        }
        for name in alike
    ]
    details = {'scene': str(folder / 'scene.yaml'), 'candidates': candidates, 'recordings': []}
    content = {
        'verdict': 'disagree',
        'evidence': 'confirmed',
        'effects': [],
        'ambiguity_set': list(alike),
        'separating_recording': 'the weight of the body',
        'details': details,
    }
    (folder / 'verdict.json').write_text(json.dumps(content))
    return folder


@pytest.mark.parametrize(
    ('alike', 'words'),
    [
        (('added_mass',), 'not sure of added_mass: take it with --effect added_mass, or record'),
        (('added_mass', 'gravity_tilt'), 'choose one of added_mass, gravity_tilt with --effect'),
        ((), 'found no effect to accept'),
    ],
)
def test_what_is_open_is_not_accepted_by_itself(tmp_path, alike, words):
    folder = _diagnosed(tmp_path, *alike)
    with pytest.raises(InputError, match=words) as raised:
        accept(folder)
    assert ('the weight of the body' in str(raised.value)) == bool(alike)


def test_what_is_not_sure_is_accepted_on_request(tmp_path):
    path, added = accept(_diagnosed(tmp_path, 'added_mass'), ['added_mass'])
    assert added == ('added_mass',)
    (version,) = read_versions(tmp_path / 'scene.yaml')
    assert path.is_file()
    assert (version.confidence, version.amplitudes) == (0.5, {'mass': 0.01, 'at': 0.7})


def test_what_is_another_one_in_each_frame_is_not_accepted(tmp_path):
    folder = _diagnosed(tmp_path, 'added_mass')
    content = json.loads((folder / 'verdict.json').read_text())
    content['details']['candidates'][0]['course'] = {'mass': [9.0, 12.0]}
    (folder / 'verdict.json').write_text(json.dumps(content))
    words = (
        'added_mass is another one in each frame of that recording, and a scene has one for all'
    )
    with pytest.raises(InputError, match=words) as raised:
        accept(folder, ['added_mass'])
    assert 'record again' in str(raised.value)
    assert read_versions(tmp_path / 'scene.yaml') == []
