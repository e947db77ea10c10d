# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Find the mcap files that a path stands for."""

from collections.abc import Sequence
from dataclasses import dataclass
import filecmp
from itertools import combinations
from pathlib import Path

from diffcal_ros.errors import RecordingError
from diffcal_ros.plain_text import listed
from diffcal_ros.recording.bag.bag_information import BagInformation, read_information

_METADATA = 'metadata.yaml'


@dataclass(frozen=True)
class BagFiles:
    """The files of a recording.

    Attributes:
        files: in the order of recording.
        missing: names of those that metadata.yaml lists and that are not there.
        counts: messages of each topic as metadata.yaml counts them; None where it does not.
        notes: what is odd, in sentences.
    """

    files: tuple[Path, ...]
    missing: tuple[str, ...] = ()
    counts: dict[str, int] | None = None
    notes: tuple[str, ...] = ()


def bag_files(path: Path) -> BagFiles:
    """List the mcap files of a rosbag2 directory, or the one file given.

    A directory without a readable metadata.yaml stands for the .mcap files in it.

    Raises:
        RecordingError: when there are none, they do not belong together, or the bag is stored in
            another way.
    """
    if not path.exists():
        raise RecordingError(f'there is no recording {path}: check the path')
    if path.is_dir():
        return _in_directory(path)
    if path.suffix != '.mcap':
        raise RecordingError(
            f'{path.name} is no .mcap file: give a rosbag2 directory or its .mcap{_cure(path)}'
        )
    _require_regular([path])
    return BagFiles((path,))


def _in_directory(path: Path) -> BagFiles:
    information, notes = read_information(path / _METADATA)
    if information is not None:
        _require_readable(path, information)
        if information.files:
            return _listed(path, information)
    found = sorted(path.glob('*.mcap'), key=_natural)
    if not found:
        stray = next(iter(sorted(path.glob('*.db3')) + sorted(path.glob('*.mcap.zstd'))), path)
        raise RecordingError(f'{path} holds no .mcap file: check the path{_cure(stray)}')
    names = sorted({_natural(file)[0] for file in found})
    if len(names) > 1:
        raise RecordingError(
            f'{path} holds .mcap files of {len(names)} recordings ({listed(names)}) and no '
            f'{_METADATA} that tells which belong together: give one of the files, or a folder '
            'for each recording'
        )
    _require_regular(found)
    _require_different(path, found)
    return BagFiles(tuple(found), notes=notes)


def _listed(path: Path, information: BagInformation) -> BagFiles:
    """Take the files that metadata.yaml lists, and no others."""
    names = information.files
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise RecordingError(
            f'{path / _METADATA} lists {twice[0]} twice: each file belongs there once; correct '
            'it, or remove it to read the .mcap files beside it'
        )
    files = [path / name for name in names]
    there = [file for file in files if file.exists()]
    _require_regular(there)
    _require_different(path, there)
    others = sorted({file.name for file in path.glob('*.mcap')} - set(names))
    notes = [f'{name} is not read: {_METADATA} does not list it' for name in others]
    missing = tuple(file.name for file in files if file not in there)
    if not there:
        have = f'the folder holds {listed(others)}' if others else 'there is no other .mcap file'
        raise RecordingError(
            f'{path} lacks {listed(missing)}, which its {_METADATA} lists ({have}): copy the '
            'whole bag again, or give an .mcap file itself'
        )
    return BagFiles(tuple(there), missing, information.counts, tuple(notes))


def _require_readable(path: Path, information: BagInformation) -> None:
    if information.storage != 'mcap':
        raise RecordingError(
            f'{path} is stored as {information.storage}: convert it to mcap with `ros2 bag '
            'convert`'
        )
    if information.compression not in ('', 'none'):
        raise RecordingError(
            f'{path} is compressed by {information.compression}: convert it with `ros2 bag '
            'convert` to mcap without a compression mode (chunks inside mcap may be compressed)'
        )


def _require_regular(files: Sequence[Path]) -> None:
    for file in files:
        # A pipe would be waited for without end.
        if not file.is_file():
            raise RecordingError(f'{file} is no regular file: give a file that was recorded')


def _require_different(path: Path, files: Sequence[Path]) -> None:
    for first, second in combinations(files, 2):
        same_size = first.stat().st_size == second.stat().st_size
        if same_size and filecmp.cmp(first, second, shallow=False):
            raise RecordingError(
                f'{first.name} and {second.name} in {path} are the same, and every frame would '
                'count twice: remove the copy'
            )


def _natural(file: Path) -> tuple[str, int]:
    """Sort bag_10.mcap behind bag_9.mcap."""
    stem, _, number = file.stem.rpartition('_')
    return (stem, int(number)) if number.isdecimal() else (file.stem, -1)


def _cure(path: Path) -> str:
    if path.suffix == '.db3':
        return '; SQLite bags are converted with `ros2 bag convert`'
    if path.suffix == '.zstd':
        return '; unpack it with `zstd -d`'
    return ''
