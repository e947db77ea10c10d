# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Live, a sentence names parameters and services in place of options and commands."""

import os
from pathlib import Path

from diffcal_ros.diagnosis.verdict.acceptance import accept
from diffcal_ros.errors import InputError
from diffcal_ros.live.node_words import for_nodes
from diffcal_ros.live.save import check_folder, make_folder
import pytest


def test_a_verdict_that_is_not_there_is_asked_for_by_the_service(tmp_path):
    with pytest.raises(InputError, match=r'there is no .*verdict\.json: run `diffcal') as raised:
        accept(tmp_path)
    assert for_nodes(str(raised.value)) == (
        f'there is no {tmp_path}/verdict.json: call ~/diagnose first'
    )


@pytest.mark.parametrize(
    ('offline', 'live'),
    [
        ('take it out with `diffcal revert`', 'take it out with ~/revert_effect'),
        (
            'choose one of a, b with --effect, or',
            'choose one of a, b with `diffcal accept --effect`',
        ),
        ('use --pose stored', 'use the parameter pose_source stored'),
        ('add --allow-truncated', 'add the parameter allow_truncated'),
    ],
)
def test_cures_are_those_of_a_node(offline, live):
    assert for_nodes(offline).startswith(live)


def test_a_folder_that_cannot_be_made_is_refused_before_work_is_done(tmp_path):
    (tmp_path / 'file').write_text('')
    for folder in (tmp_path / 'file', tmp_path / 'file' / 'below'):
        with pytest.raises(InputError, match='file is no folder'):
            check_folder(folder)
    check_folder(tmp_path / 'a' / 'b')
    assert not (tmp_path / 'a').exists()
    make_folder(tmp_path / 'a' / 'b')
    assert os.listdir(tmp_path / 'a') == ['b']
    with pytest.raises(InputError, match='/proc/nowhere cannot be made'):
        make_folder(Path('/proc/nowhere'))
