# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Write files whole or not at all."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
import json
import math
import os
from pathlib import Path
from typing import Any

from diffcal_ros.errors import InputError
from diffcal_ros.leftovers import fresh_path, remove_leftovers


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Offer a new path beside `path`; what was written there takes its place at the end.

    Readers see the old file or the new one, never a part. After an error, a full disk or an
    interruption, `path` is as it was before. Missing folders are made.

    Raises:
        InputError: when the folder cannot be written to or the disk is full.
    """
    if not path.name or os.path.isdir(path):  # `Path.is_dir` raises for long names.
        raise InputError(f'{path} is a folder: name the file to write')
    fresh = fresh_path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        remove_leftovers(path)
        yield fresh
        with fresh.open('rb') as written:
            os.fsync(written.fileno())
        fresh.replace(path)
    except OSError as error:
        raise InputError(
            f'{path} cannot be written ({error.strerror or error}): see that its folder '
            'may be written to and that the disk has room, or choose another folder'
        ) from error
    finally:
        with suppress(OSError):
            fresh.unlink(missing_ok=True)


def write_text_atomically(path: Path, text: str) -> None:
    """Write a UTF-8 text; see `replacing`.

    Bytes of a file's name that are no UTF-8 are written as escapes.
    """
    write_bytes_atomically(path, text.encode('utf-8', errors='backslashreplace'))


def write_json_atomically(path: Path, content: Any) -> None:
    """Write a JSON document of `json_values`; see `replacing`."""
    text = json.dumps(json_values(content), indent=2, allow_nan=False)
    write_text_atomically(path, text + '\n')


def json_values(content: Any) -> Any:
    """Return a document as JSON knows it: NaN and infinity become null, arrays' numbers plain."""
    if isinstance(content, dict):
        return {key: json_values(item) for key, item in content.items()}
    if isinstance(content, (list, tuple)):
        return [json_values(item) for item in content]
    if hasattr(content, 'item'):  # A number of NumPy's, which is not loaded for asking.
        return json_values(content.item())
    if isinstance(content, float) and not math.isfinite(content):
        return None
    return content


def write_bytes_atomically(path: Path, content: bytes) -> None:
    """Write a binary file; see `replacing`."""
    with replacing(path) as fresh:
        fresh.write_bytes(content)
