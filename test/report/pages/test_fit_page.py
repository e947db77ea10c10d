# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The report page: one file that needs nothing else and leaves nothing out."""

import base64
from dataclasses import replace
from html.parser import HTMLParser
import re

from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.results.result import FittedParameter
from diffcal_ros.report.naming import title
from diffcal_ros.report.pages.fit_page import write_report
from diffcal_ros.report.tables.page_tables import interval_ends
import numpy as np
import pytest


class Page(HTMLParser):
    """Collects tables, images and text; refuses tags left open."""

    def __init__(self, source):
        super().__init__()
        self.tables, self.images, self.texts, self.open = [], [], [], []
        self.links = []
        self.feed(source)
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        self.links += [attributes[key] for key in ('src', 'href') if key in attributes]
        if tag == 'img':
            self.images.append(attributes)
        if tag not in ('img', 'meta'):
            self.open.append(tag)
        if tag == 'table':
            self.tables.append([])
        elif tag == 'tr':
            self.tables[-1].append([])
        elif tag in ('td', 'th'):
            self.tables[-1][-1].append('')

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)
        if {'td', 'th'} & set(self.open):
            self.tables[-1][-1][-1] += data

    @property
    def text(self):
        return ' '.join(self.texts)


@pytest.fixture(scope='module')
def source(fitted, tmp_path_factory):
    path = tmp_path_factory.mktemp('page') / 'report.html'
    write_report(path, *fitted)
    assert [p.name for p in path.parent.iterdir()] == ['report.html']
    return path.read_text()


@pytest.fixture(scope='module')
def page(source):
    return Page(source)


def test_nothing_is_fetched_from_elsewhere(source, page):
    assert 'http' not in source
    assert not re.search(r'<script|<link|@import|url\(|src="(?!data:image/png;base64,)', source)
    assert all(link.startswith('data:image/png;base64,') for link in page.links)
    assert len(source) < 2e6


def test_every_picture_is_a_png_with_words_for_it(page):
    assert len(page.images) == 3
    for image in page.images:
        png = base64.b64decode(image['src'].partition(',')[2], validate=True)
        assert png.startswith(b'\x89PNG\r\n\x1a\n')
        assert png.endswith(b'IEND\xaeB\x60\x82')
        assert len(image['alt']) > 10


def test_every_parameter_is_in_a_table_with_its_start_and_error(fitted, page):
    _, result = fitted
    rows = {row[0]: row for table in page.tables for row in table}
    assert {p.name for p in result.parameters if p.is_nuisance} >= {'edge_bias'}
    for parameter in result.parameters:
        row = rows[title(parameter.name)]
        assert '±' in row[1], parameter.name
        assert '…' in row[3]
    modulus = result['youngs_modulus']
    row = rows["Young's modulus"]
    value, error = (float(part) for part in re.findall(r'[\d.]+', row[1])[:2])
    assert value == pytest.approx(1e-3 * modulus.value, abs=0.5 * 10.0 ** -(decimals(row[1])))
    # The error of the mesh has a column of its own.
    mesh = float(re.findall(r'[\d.]+', row[2])[0])
    assert mesh > 0.0
    assert np.hypot(error, mesh) == pytest.approx(1e-3 * modulus.std_error, rel=0.06)
    assert '126 kPa' in row[4]


def decimals(text):
    number = re.search(r'[\d.]+', text).group()
    return len(number.partition('.')[2])


def test_the_correlation_table_holds_the_results_matrix(fitted, page):
    _, result = fitted
    asked = [place for place, p in enumerate(result.parameters) if not p.is_nuisance]
    (table,) = [t for t in page.tables if t[0][0] == '' and len(t) == len(asked) + 1]
    assert [row[0].split('\u2002')[1] for row in table[1:]] == [
        title(result.parameters[place].name) for place in asked
    ]
    shown = [[float(cell.replace('−', '-')) for cell in row[1:]] for row in table[1:]]
    np.testing.assert_allclose(shown, result.correlation[np.ix_(asked, asked)], atol=0.0051)


def test_outcome_gap_and_inputs_are_told(fitted, page):
    _, result = fitted
    assert 'converged' in page.text
    assert f'{1e3 * result.gap_end.median:.3g}' in page.text
    assert f'coverage {result.gap_end.coverage:.1%}' in page.text
    rows = {row[0]: row[1] for table in page.tables for row in table if len(row) == 2}
    assert rows['scene.sha256'] == result.details['scene']['sha256']
    assert rows['recordings[0].sha256'] == result.details['recordings'][0]['sha256']
    assert 'pose of the marker from 2 colour frames' in page.text


@pytest.mark.slow
def test_warnings_are_shown_and_no_text_becomes_markup(fitted, tmp_path):
    calibration, result = fitted
    nasty = 'E < 5 & "x" <script>alert(1)</script>'
    told = replace(
        result,
        outcome=Outcome.NOT_IDENTIFIABLE,
        warnings=('the data cannot tell apart: a, b', nasty),
        details={**result.details, 'notes': [nasty], 'settings': {nasty: nasty}},
    )
    write_report(tmp_path / 'r.html', calibration, told)
    source = (tmp_path / 'r.html').read_text()
    assert '<script' not in source
    page = Page(source)
    assert 'the data cannot tell apart: a, b' in page.texts
    assert page.text.count(nasty) >= 3
    assert 'not identifiable' in page.text
    assert Outcome.NOT_IDENTIFIABLE.remedy in page.text


def test_ends_of_an_interval_are_written_without_exponents():
    stiff = FittedParameter(
        name='youngs_modulus',
        value=1.428e6,
        std_error=82e3,
        mesh_error=4e3,
        unit='Pa',
        start=1.96e6,
        interval_95=(1.2741e6, 1.5939e6),
    )
    assert interval_ends(stiff) == ['1274', '1594']
