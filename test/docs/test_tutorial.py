# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The tutorial's commands lead a new user in an empty folder to an asset, as the page says."""

import json
from pathlib import Path
import runpy
import subprocess

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / 'docs' / 'tutorial.md').read_text()


SCRIPT = runpy.run_path(str(ROOT / 'docs' / 'make_tutorial_pictures.py'))


def commands() -> list[list[str]]:
    """Return what the page has to be typed."""
    return SCRIPT['commands'](ROOT)


def test_the_page_reaches_an_asset_in_few_commands() -> None:
    asked = [words[1] for words in commands() if words[0] == 'diffcal']
    assert asked == ['init', 'check', 'calibrate', 'export']
    assert len(commands()) + PAGE.count('python asset/play_mjcf.py') <= 7


@pytest.mark.slow
def test_it_leads_from_the_recording_to_an_asset(tmp_path: Path) -> None:
    for words in commands():
        typed = [SCRIPT['program'](words[0]), *words[1:]]
        done = subprocess.run(typed, cwd=tmp_path, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stderr[-2000:]
    fitted = json.loads((tmp_path / 'fit' / 'result.json').read_text())
    truth = json.loads((ROOT / 'bags' / 'sample' / 'truth.json').read_text())
    true = truth['parameters']['silicone']['youngs_modulus']
    low, high = fitted['parameters']['youngs_modulus']['interval_95']
    assert low < true < high
    asset = json.loads((tmp_path / 'asset' / 'export.json').read_text())
    assert 'mujoco' in asset['moduli']
    assert asset['regions']['body']['youngs_modulus'] < 0.8 * true
