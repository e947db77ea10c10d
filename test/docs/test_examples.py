# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Every example runs, and shows what its text says."""

from collections.abc import Callable
from pathlib import Path
import runpy
import sys
from typing import Any

from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.diagnosis.answers import Verdict
import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / 'docs' / 'examples'
# Central differences over a thousandth of the logarithm err by its square.
BY_DIFFERENCES = 1e-5
# Outline pixels are sampled, eight times a side for the gradient.
OF_OUTLINES = 0.01


@pytest.fixture
def run(monkeypatch, capsys) -> Callable[[str], dict[str, Any]]:
    """Run an example by the start of its name; its names, and `printed`."""
    monkeypatch.syspath_prepend(str(EXAMPLES))

    def run_example(start: str) -> dict[str, Any]:
        (path,) = EXAMPLES.glob(f'{start}_*.py')
        names = runpy.run_path(str(path), run_name='__main__')
        return {**names, 'printed': capsys.readouterr().out}

    yield run_example
    for module in ('beam', 'plain_neo_hookean'):
        sys.modules.pop(module, None)


def test_every_example_is_tested():
    source = Path(__file__).read_text()
    for path in EXAMPLES.glob('ex*.py'):
        assert f"run('{path.stem[:4]}')" in source


def test_a_hanging_beam(run):
    ran = run('ex01')
    assert ran['derivative'] == pytest.approx(ran['difference'], rel=BY_DIFFERENCES)
    # Less than its sag: a beam that bends far stiffens.
    assert 0.8 * ran['sag'] < ran['derivative'] < ran['sag']
    assert 'sag of the tip' in ran['printed']


def test_a_silhouette(run):
    ran = run('ex02')
    assert ran['gradient'] == pytest.approx(ran['difference'], rel=OF_OUTLINES)
    assert abs(ran['inner']) < 0.1 * abs(ran['gradient'])


def test_the_modulus_of_an_image(run):
    ran = run('ex03')
    assert ran['result'].outcome is Outcome.CONVERGED
    assert abs(ran['modulus'].value - ran['TRUTH']) < 1.96 * ran['modulus'].std_error
    assert ran['modulus'].std_error < 0.1 * ran['TRUTH']
    assert 'converged' in ran['printed']


@pytest.mark.slow
def test_the_sample_recording(run):
    ran = run('ex04')
    modulus = ran['result']['youngs_modulus']
    assert abs(modulus.value - 240e3) < 1.96 * modulus.std_error
    assert ran['printed'].startswith('12 frames')


@pytest.mark.slow
def test_a_swing(run):
    ran = run('ex05')
    assert ran['result'].outcome is Outcome.CONVERGED
    for name, truth in ran['TRUTH'].items():
        (fitted,) = (one for one in ran['result'].parameters if one.name.startswith(name))
        assert abs(fitted.value - truth) < 1.96 * fitted.std_error


@pytest.mark.slow
def test_a_hidden_effect(run):
    ran = run('ex06')
    assert ran['verdict'].verdict is Verdict.DISAGREE
    # The truth comes first; what one pose hardly tells from it, in about its form, comes next.
    assert ran['verdict'].ambiguity_set[0] == 'depth_affine'
    assert set(ran['verdict'].ambiguity_set[1:]) <= {'camera_offset', 'clamp_offset'}
    assert ran['verdict'].runner_up in ('camera_offset', 'clamp_offset')
    assert ran['verdict'].closure > 0.9
    assert 'CHECK' in ran['printed']


def test_a_law_of_ones_own(run):
    ran = run('ex07')
    assert ran['power'] == pytest.approx(ran['slope'], rel=1e-4)
    usual, own = ran['sags'].values()
    assert own == pytest.approx(usual, rel=0.01)
    assert own != usual
