# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Paths as people write them, and the files that they may stand for."""

import os
from pathlib import Path
import stat

from diffcal_ros.errors import InputError

# What Linux, macOS and Windows allow for one name, and Linux for a path [bytes].
_LONGEST_NAME, _LONGEST_PATH = 255, 4095


def user_path(text: str) -> Path:
    """Return a path with `~` replaced by the home folder that it stands for.

    Raises:
        InputError: when no file can have this name.
    """
    try:
        path = Path(text).expanduser()
    except RuntimeError as error:
        raise InputError(
            f'{text!r} starts with the home folder of a user who is not known here: write the '
            'whole path, or ./~ for a folder of that name'
        ) from error
    try:
        lengths = [len(os.fsencode(part)) for part in path.parts]
    except UnicodeEncodeError as error:
        raise InputError(f'{text!r} has a character that no file name can have') from error
    if '\0' in text:
        raise InputError(f'{text!r} has a character that no file name can have')
    if max(lengths, default=0) > _LONGEST_NAME or sum(lengths) + len(lengths) > _LONGEST_PATH:
        raise InputError(
            f'{text[:40]}... is too long for a path: a name has at most {_LONGEST_NAME} bytes, '
            f'a path {_LONGEST_PATH}'
        )
    return path


def require_plain_file(path: Path, most_bytes: int) -> None:
    """Refuse what is no file of a size that makes sense, before it is read.

    A pipe would be waited for, a device such as /dev/zero read until memory ends. What is not
    there or may not be read is left to who opens it.

    Args:
        path: what is to be read.
        most_bytes: that such a file may have.

    Raises:
        InputError: saying what it is instead.
    """
    try:
        found = path.stat()
    except OSError:
        return
    if stat.S_ISDIR(found.st_mode):
        raise InputError(f'{path} is a folder: name the file in it')
    if not stat.S_ISREG(found.st_mode):
        raise InputError(
            f'{path} is a pipe or a device: save what it gives to a file, and name that'
        )
    if found.st_size > most_bytes:
        raise InputError(
            f'{path} has {found.st_size / 1e6:.0f} MB, and {most_bytes / 1e6:.0f} are read at '
            'most: see that it is the right file'
        )
