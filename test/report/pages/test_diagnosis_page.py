# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The page of a diagnosis says what the terminal does, line by line."""

from dataclasses import replace
from html import unescape
import re

from diffcal_ros.diagnosis.answers import Verdict
from diffcal_ros.diagnosis.diagnose import diagnose
from diffcal_ros.diagnosis.verdict.time_course import TimeCourse
from diffcal_ros.diagnosis.verdict.verdict import NamedEffect
from diffcal_ros.effects.spots import OF_SIDE, ROUND, ROWS, spot_settings, Spots
from diffcal_ros.report.figures.course_figure import course_figure
from diffcal_ros.report.figures.spot_figure import spot_figure
from diffcal_ros.report.pages.diagnosis_page import write_diagnosis_page
from diffcal_ros.report.tables.verdict_text import verdict_lines
import numpy as np
import pytest
from support.scenes import beam_scene
from support.watched import watched


def test_each_line_of_the_verdict_stands_by_itself(tmp_path) -> None:
    """A long one is continued beneath its own text, and none runs out of its card."""
    trace = diagnose(beam_scene((6, 2, 2)), [watched(seed=1, bias=0.003)])
    write_diagnosis_page(tmp_path / 'report.html', 'beam', trace)
    page = (tmp_path / 'report.html').read_text()
    said = [unescape(line) for line in re.findall(r'<div class="said">(.*?)</div>', page)]
    assert said == verdict_lines(trace.diagnosis)
    assert any(line.startswith('DISAGREE') for line in said)


@pytest.mark.slow
def test_a_parameter_beside_something_unknown_is_not_known(tmp_path) -> None:
    trace = diagnose(beam_scene((6, 2, 2)), [watched(seed=1, bias=0.003)])
    told = verdict_lines(trace.diagnosis)
    assert not any('not known' in line for line in told)
    after = trace.diagnosis.parameters['after']
    unsure = {name: {**entry, 'std_error': float('nan')} for name, entry in after.items()}
    diagnosis = replace(
        trace.diagnosis,
        effects=(),
        ambiguity_set=(),
        unknown_class='load',
        parameters={**trace.diagnosis.parameters, 'after': unsure},
    )
    (said,) = (line for line in verdict_lines(diagnosis) if line.startswith('FITTED'))
    assert "Young's modulus" in said
    assert said.endswith('not known')
    assert diagnosis.as_dict()['parameters']['after']['youngs_modulus']['std_error'] is None
    write_diagnosis_page(tmp_path / 'report.html', 'beam', replace(trace, diagnosis=diagnosis))
    assert '>not known<' in (tmp_path / 'report.html').read_text()


def test_it_says_what_may_have_drawn_a_modulus_where_nothing_shows() -> None:
    found = diagnose(beam_scene((6, 2, 2)), [watched(seed=1)]).diagnosis
    diagnosis = replace(found, verdict=Verdict.AGREE, effects=(), unknown_class=None)
    shares = {'gravity_tilt': 0.001, 'added_mass': 0.31, 'rest_curvature': 0.12}
    drawn = replace(diagnosis, drawn={'youngs_modulus': shares})
    (said,) = (line for line in verdict_lines(drawn) if line.startswith('DRAWN'))
    assert "Young's modulus by what does not show" in said
    assert said.endswith('at most 31% (added_mass), 12% (rest_curvature) (95 %)')
    far = replace(diagnosis, drawn={'youngs_modulus': {'added_mass': np.inf}})
    assert any(
        line.endswith('at most any amount (added_mass) (95 %)') for line in verdict_lines(far)
    )
    sure = replace(diagnosis, drawn={'youngs_modulus': {'added_mass': 1e-9}})
    assert not any(line.startswith('DRAWN') for line in verdict_lines(sure))
    assert diagnosis.drawn['youngs_modulus']['added_mass'] > 0.1


@pytest.mark.slow
def test_a_map_of_spots_is_shown_where_one_is_stated(tmp_path) -> None:
    """The picture has dark what the map has, side by side from below, from the clamp on."""
    cells = np.zeros((ROWS, ROUND), dtype=bool)
    cells[: ROWS // 2, :OF_SIDE] = True
    panel = spot_figure(Spots(cells)).axes[0]
    (image,) = panel.get_images()
    assert image.origin == 'lower'
    shown = np.asarray(image.get_array(), dtype=bool)
    assert shown[:OF_SIDE, : ROWS // 2].all()
    assert shown.sum() == cells.sum()
    pages = []
    for number, effects in enumerate(({}, {'depth_bias_by_region': spot_settings(cells)})):
        scene = replace(beam_scene((6, 2, 2)), effects=effects)
        path = tmp_path / f'{number}.html'
        write_diagnosis_page(path, 'beam', diagnose(scene, [watched(seed=1)]))
        pages.append(path.read_text())
    assert ['map of spots' in page for page in pages] == [False, True]


@pytest.mark.slow
def test_a_course_is_shown_frame_by_frame(tmp_path) -> None:
    trace = diagnose(beam_scene((6, 2, 2)), [watched(seed=1, bias=0.003)])
    named = NamedEffect(
        'time_offset', 'sensor', {'late': 2.9}, {'late': 0.3}, {'late': 'ms'}, {}, {}, 0.8, 'late'
    )
    course = {'late': [1.0, 2.0, 4.0, 4.5]}
    when = TimeCourse(
        times=(0.0, 0.1, 0.2, 0.3),
        rms_mm=(0.1, 0.2, 0.3, 0.4),
        held_out=(False, False, True, False),
        largest='late, at 0.300 s',
        part='near the tip',
        mean_mm=(0.0, 0.1, None, 0.2),
        frequency_hz=None,
    )
    effect = replace(named, course=course)
    line, fitted, hollow, _ = course_figure(effect, when.times, when.held_out).axes[0].lines
    np.testing.assert_array_equal(line.get_ydata(), course['late'])
    np.testing.assert_array_equal(fitted.get_xdata(), [0.0, 0.1, 0.3])
    np.testing.assert_array_equal(hollow.get_xydata(), [[0.2, 4.0]])
    assert hollow.get_markerfacecolor() == 'white'
    pages = []
    for number, effects in enumerate(((named,), (effect,))):
        diagnosis = replace(trace.diagnosis, effects=effects, when=when)
        path = tmp_path / f'{number}.html'
        write_diagnosis_page(path, 'beam', replace(trace, diagnosis=diagnosis))
        pages.append(path.read_text())
    assert [f'{effect.identifier} over time' in page for page in pages] == [False, True]
    assert ['What changes in the recording' in page for page in pages] == [False, True]
