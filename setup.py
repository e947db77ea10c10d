# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Build the ROS package `diffcal_ros` (colcon) and the plain library with `diffcal` (pip)."""

from glob import glob
from pathlib import Path
import sys

from setuptools import find_packages, setup

PACKAGE = 'diffcal_ros'
# colcon build --symlink-install runs a link to this file in a folder that holds little else.
SOURCE = Path(__file__).resolve().parent
REQUIREMENTS = SOURCE / 'requirements.txt'
SAMPLE = ('bags/sample', 'bags/sample/bag')

# A wheel is the ROS-free library: names such as `calibration` do not belong on everyone's PATH.
BUILDS_WHEEL = bool({'bdist_wheel', 'dist_info', 'editable_wheel'} & set(sys.argv))
NODES = [
    'calibration = diffcal_ros.ros.calibration_node:main',
    'depth_source = diffcal_ros.ros.depth_source_node:main',
    'marker_pose = diffcal_ros.ros.marker_pose_node:main',
]


def _files(folder: str) -> list[str]:
    return sorted(path for path in glob(f'{folder}/*') if Path(path).is_file())


setup(
    name=PACKAGE,
    version='0.1.0',
    packages=find_packages(include=[PACKAGE, f'{PACKAGE}.*']),
    package_data={PACKAGE: ['py.typed', 'reproduction/rows/*.yaml']},
    python_requires='>=3.10',
    # Where the file is left out, as in a package for apt, package.xml says what is needed.
    install_requires=REQUIREMENTS.read_text().split() if REQUIREMENTS.is_file() else [],
    extras_require={
        'cholmod': ['cvxopt>=1.3'],  # GPL: only on the user's own decision.
        'cluster': ['distributed>=2024.5'],
        'fast': ['pypardiso>=0.4.6'],
        'mesh': ['pytetwild>=0.2', 'pyvista>=0.43'],
        'mujoco': ['mujoco>=4.0'],
        'newton': ['newton>=1.8'],
        'rerun': ['rerun-sdk>=0.39'],
        'test': ['pytest>=7'],
        'torch': ['torch>=2.1'],
        'usd': ['usd-core>=25.5'],
        'web': ['viser>=1.1'],
    },
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE}']),
        (f'share/{PACKAGE}', ['package.xml']),
        (f'share/{PACKAGE}/config', glob('config/*')),
        (f'share/{PACKAGE}/launch', glob('launch/*.launch.py')),
        (f'share/{PACKAGE}/rviz', glob('rviz/*')),
        *((f'share/{PACKAGE}/{folder}', _files(folder)) for folder in SAMPLE),
    ],
    zip_safe=False,
    maintainer='diffcal_ros maintainers',
    maintainer_email='maintainers@diffcal-ros.org',
    description=(
        "Find a soft body's simulator parameters from depth images: differentiable FEM, "
        'differentiable depth rendering, error bars, live or from a bag.'
    ),
    license='Apache-2.0',
    entry_points={
        'console_scripts': [
            'diffcal = diffcal_ros.cli.program:main',
            *([] if BUILDS_WHEEL else NODES),
        ]
    },
)
