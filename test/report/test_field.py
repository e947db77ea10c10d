# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A fitted field on the page, on a terminal and in a file."""

from pathlib import Path

from diffcal_ros.errors import InputError
from diffcal_ros.report.field_file import write_field
from diffcal_ros.report.figures.field_figure import field_figure
from diffcal_ros.report.figures.observed_view import observed_views
from diffcal_ros.report.pages.field_section import field_section, field_text
from diffcal_ros.scene.sections.mesh_files import read_mesh
import meshio
import numpy as np
import pytest
from support.fields import fitted_halves


def test_file_holds_mesh_field_and_shape(tmp_path: Path) -> None:
    calibration, field = fitted_halves()
    path = tmp_path / 'field.vtu'
    write_field(path, calibration, field)
    content = meshio.read(path)
    np.testing.assert_allclose(content.cell_data['youngs_modulus'][0], field.youngs_modulus)
    np.testing.assert_allclose(content.cell_data['log_std_error'][0], field.log_std)
    moved = content.point_data['displacement_hanging']
    mesh = calibration.scene.mesh
    held = calibration.scene.observations[0].held[0].vertices
    assert np.abs(moved[held]).max() < 1e-12
    # Its tip sags; the object's frame is turned a little against gravity.
    tip = mesh.rest_positions[:, 0].argmax()
    assert moved[tip] @ [0.0, -1.0, 0.0] > 5e-3
    # A mesh that comes back is the one that went out.
    again = read_mesh(path, unit='m').mesh
    np.testing.assert_array_equal(again.tets, mesh.tets)


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match='is a folder'):
        write_field(tmp_path, *fitted_halves())


def test_figure_shows_both_sides_error_and_profile() -> None:
    figure = field_figure(*fitted_halves())
    titles = [axes.get_title() for axes in figure.axes]
    for words in ('at rest, from behind', 'standard error', 'along the body'):
        assert any(words in title for title in titles)
    colors = figure.axes[0].collections[0].get_facecolors()
    assert len(np.unique(colors.round(3), axis=0)) > 20


def test_section_lists_every_weight() -> None:
    calibration, field = fitted_halves()
    section = field_section(calibration, field)
    assert section.count('<tr>') == 1 + len(field.weights.trials)
    assert "Young's modulus over the body" in section
    assert 'unknowns' in field_text(field)


def test_start_is_shown_without_the_field() -> None:
    calibration, field = fitted_halves()
    before = calibration.model
    (view,) = observed_views(calibration, field.result)
    kept = np.isfinite(view.fitted.residual) & view.fitted.counted
    size = np.median(np.abs(view.fitted.residual[kept]))
    assert size == pytest.approx(field.result.gap_end.median, rel=0.02)
    assert calibration.model is before
