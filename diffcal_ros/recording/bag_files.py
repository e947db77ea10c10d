# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Find the mcap files that a path stands for."""

from pathlib import Path
from typing import Any

from diffcal_ros.errors import RecordingError
import yaml


def mcap_files(path: Path) -> tuple[Path, ...]:
    """List the mcap files of a rosbag2 directory, or the one file given.

    A directory without a readable metadata.yaml stands for the .mcap files in it.

    Raises:
        RecordingError: when there are none, or the bag is stored in another way.
    """
    if not path.exists():
        raise RecordingError(f'there is no recording {path}: check the path')
    if path.is_dir():
        return _in_directory(path)
    if path.suffix != '.mcap':
        raise RecordingError(
            f'{path.name} is no .mcap file: give a rosbag2 directory or its .mcap{_cure(path)}'
        )
    return (path,)


def _in_directory(path: Path) -> tuple[Path, ...]:
    information = _information(path / 'metadata.yaml')
    storage = information.get('storage_identifier', 'mcap')
    if storage != 'mcap':
        raise RecordingError(
            f'{path} is stored as {storage}: convert it to mcap with `ros2 bag convert`'
        )
    if information.get('compression_mode'):
        raise RecordingError(
            f'{path} is compressed by {str(information["compression_mode"]).lower()}: convert it '
            'with `ros2 bag convert` to mcap without a compression mode (chunks inside mcap may '
            'be compressed)'
        )
    listed = information.get('relative_file_paths')
    if isinstance(listed, list) and listed:
        files = tuple(path / Path(str(name)).name for name in listed)
        missing = [file.name for file in files if not file.is_file()]
        if not missing:
            return files
    found = tuple(sorted(path.glob('*.mcap'), key=_natural))
    if not found:
        stray = next(iter(sorted(path.glob('*.db3')) + sorted(path.glob('*.mcap.zstd'))), path)
        raise RecordingError(f'{path} holds no .mcap file: check the path{_cure(stray)}')
    return found


def _information(file: Path) -> dict[str, Any]:
    """Return what metadata.yaml says; nothing when it is missing or damaged."""
    try:
        content = yaml.safe_load(file.read_text(encoding='utf-8'))
        information = content['rosbag2_bagfile_information']
    except (OSError, ValueError, TypeError, KeyError, yaml.YAMLError):
        return {}
    return information if isinstance(information, dict) else {}


def _natural(file: Path) -> tuple[str, int, str]:
    """Sort bag_10.mcap behind bag_9.mcap."""
    stem, _, number = file.stem.rpartition('_')
    return (stem, int(number), '') if number.isdecimal() else (file.stem, -1, '')


def _cure(path: Path) -> str:
    if path.suffix == '.db3':
        return '; SQLite bags are converted with `ros2 bag convert`'
    if path.suffix == '.zstd':
        return '; unpack it with `zstd -d`'
    return ''
