# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""`diffcal import` from the outside; what is read of the data set is tested with the importer."""

from diffcal_ros.cli.main import EXIT_BAD_INPUT, EXIT_DONE
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.scene.load import load_scene


def test_a_case_becomes_a_scene_and_a_bag(run_cli, diffcal_data, tmp_path):
    out = tmp_path / 'h_e_c'
    ran = run_cli('import', diffcal_data, 'h_e_c', '--out', out)
    assert ran.code == EXIT_DONE
    assert ran.out.splitlines() == [
        f'scene  {out / "scene.yaml"}',
        f'bag    {out / "bag"}: 1 depth, 3 colour frames',
    ]
    scene = load_scene(out / 'scene.yaml')
    assert scene.observations[0].bag == out / 'bag'
    assert open_recording(out / 'bag').depth_count == 1
    kept = (out / 'scene.yaml').read_bytes()
    again = run_cli('import', diffcal_data, 'h_e_c', '--out', out)
    assert again.code == EXIT_BAD_INPUT
    assert '--overwrite' in again.err
    assert (out / 'scene.yaml').read_bytes() == kept
    assert run_cli('import', diffcal_data, 'h_e_c', '--out', out, '--overwrite').code == EXIT_DONE


def test_an_unknown_case_lists_the_known_ones(run_cli, diffcal_data, tmp_path):
    ran = run_cli('import', diffcal_data, 'h_e', '--out', tmp_path / 'out')
    assert ran.code == EXIT_BAD_INPUT
    assert "diffcal import: 'h_e' is no experiment of " in ran.err
    assert 'h_e_c, h_e_d' in ran.err
    assert not (tmp_path / 'out').exists()


def test_another_folder_is_no_data_set(run_cli, tmp_path):
    ran = run_cli('import', tmp_path, 'h_e_c', '--out', tmp_path / 'out')
    assert ran.code == EXIT_BAD_INPUT
    assert 'holds no exp_data folder: give the root of a clone' in ran.err
    assert not (tmp_path / 'out').exists()
