# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The package is built as users build it, and what is installed is all that a node needs."""

import os
from pathlib import Path
import re
import shutil
import subprocess
import sys

from diffcal_ros.ros.run_node import PIP_PACKAGES
import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE_XML = (ROOT / 'package.xml').read_text()
SHARED = (
    'package.xml',
    'launch/calibrate.launch.py',
    'config/calibrate.yaml',
    'rviz/calibrate.rviz',
    'rviz/calibrate.foxglove.json',
)
SAMPLE = ('bags/sample/scene.yaml', 'bags/sample/finger.vtk', 'bags/sample/bag/metadata.yaml')
# Keys of rosdep's lists that stand for what pip calls otherwise.
ROSDEP = {
    'matplotlib': 'python3-matplotlib',
    'meshio': 'python3-meshio',
    'numpy': 'python3-numpy',
    'opencv-contrib-python-headless': 'python-opencv-contrib-pip',
    'pillow': 'python3-pil',
    'pyyaml': 'python3-yaml',
    'rosbags': 'python3-rosbags-pip',
    'scipy': 'python3-scipy',
    'tqdm': 'python3-tqdm',
    'trimesh': 'python3-trimesh-pip',
}
# rosdep knows no key for these: the line for pip in docs/live.md does.
PIP_ONLY = {'joblib', 'lz4', 'mcap', 'qdldl', 'threadpoolctl', 'warp-lang', 'zstandard'}


def _required() -> set[str]:
    return {re.split('[<>=]', line)[0] for line in (ROOT / 'requirements.txt').read_text().split()}


@pytest.mark.parametrize('has_requirements', [True, False])
def test_a_link_to_setup_py_finds_what_is_beside_the_file(tmp_path, has_requirements):
    source, build = tmp_path / 'source', tmp_path / 'build'
    source.mkdir()
    build.mkdir()
    shutil.copy(ROOT / 'setup.py', source)
    if has_requirements:
        shutil.copy(ROOT / 'requirements.txt', source)
    (build / 'setup.py').symlink_to(source / 'setup.py')
    done = subprocess.run(
        [sys.executable, 'setup.py', '--quiet', 'egg_info'],
        cwd=build,
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    written = build / 'diffcal_ros.egg-info' / 'requires.txt'
    assert ('warp-lang' in written.read_text()) == has_requirements


def test_package_xml_names_every_requirement_that_rosdep_knows():
    declared = set(re.findall('<exec_depend>(.*?)</exec_depend>', PACKAGE_XML))
    assert _required() == set(ROSDEP) | PIP_ONLY
    assert set(ROSDEP.values()) <= declared


def test_the_recipe_for_a_workspace_installs_what_rosdep_does_not():
    recipe = (ROOT / 'docs' / 'live.md').read_text()
    (named,) = re.findall(r'pip install --break-system-packages (.*)', recipe)
    assert set(named.split()) == PIP_ONLY
    (stated,) = re.findall('rosdep has no key for these: pip install (.*?) -->', PACKAGE_XML)
    assert set(stated.split()) == PIP_ONLY


def test_a_missing_pip_package_is_told_with_the_line_that_installs_all(tmp_path):
    (tmp_path / 'sitecustomize.py').write_text("import sys\nsys.modules['warp'] = None\n")
    done = subprocess.run(
        [sys.executable, '-c', 'from diffcal_ros.ros.calibration_node import main; exit(main())'],
        env={**os.environ, 'PYTHONPATH': f'{tmp_path}:{ROOT}'},
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )
    assert done.returncode == 2
    assert "needs the Python package 'warp', which is not installed" in done.stderr
    assert f'-m pip install {" ".join(PIP_PACKAGES)}' in done.stderr
    assert 'Traceback' not in done.stderr
    assert set(PIP_PACKAGES) <= _required()
    assert set(PIP_PACKAGES) >= PIP_ONLY


@pytest.mark.slow
@pytest.mark.skipif(shutil.which('colcon') is None, reason='colcon is not installed')
@pytest.mark.parametrize('options', [[], ['--symlink-install']])
def test_colcon_builds_and_installs_nodes_launch_file_and_sample(tmp_path, options):
    folders = ['--build-base', tmp_path / 'build', '--install-base', tmp_path / 'install']
    chosen = ['--base-paths', ROOT, '--packages-select', 'diffcal_ros']
    done = subprocess.run(
        ['colcon', '--log-base', tmp_path / 'log', 'build', *chosen, *folders, *options],
        capture_output=True,
        text=True,
        timeout=300.0,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    installed = tmp_path / 'install' / 'diffcal_ros'
    for name in ('calibration', 'depth_source', 'marker_pose'):
        assert (installed / 'lib' / 'diffcal_ros' / name).is_file()
    for name in (*SHARED, *SAMPLE):
        assert (installed / 'share' / 'diffcal_ros' / name).is_file(), name
