# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where compiled kernels are kept: in the user's cache folder, or else in a temporary one."""

from collections.abc import Iterator
from contextlib import suppress
import os
from pathlib import Path
import sys
import tempfile

from diffcal_ros.user_folders import cache_home, settle_home, temporary_folder

_ASKED = 'WARP_CACHE_PATH'
# Compiled kernels of a fit take some such space [bytes].
_ROOM = 4_000_000


def settle_kernel_cache() -> None:
    """Set `WARP_CACHE_PATH` where Warp would choose a folder that cannot be used.

    Processes that this one starts find it set.

    Raises:
        InputError: when there is no temporary folder either.
    """
    settle_home()
    asked = os.environ.get(_ASKED)
    if not asked and sys.platform != 'linux':
        return  # Warp follows the system's custom.
    usual = Path(asked) if asked else cache_home() / 'warp'
    if _has_room(usual):
        return
    fresh = temporary_folder('kernels')
    _take_over(usual, fresh)
    os.environ[_ASKED] = str(fresh)
    print(
        f'compiled kernels cannot be kept in {usual}, and go to a temporary folder: set {_ASKED} '
        'to one that may be written to and has room, or they are compiled again each time',
        file=sys.stderr,
    )


def _has_room(folder: Path) -> bool:
    """Tell whether a folder can be made, and written to."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as probe:
            probe.write(bytes(_ROOM))
    except (OSError, ValueError):
        return False
    return True


def _take_over(usual: Path, fresh: Path) -> None:
    """Use the kernels that are there already, though none can be added."""
    with suppress(OSError):
        for module in _modules(usual):
            place = fresh / module.parent.name
            place.mkdir(exist_ok=True)
            (place / module.name).symlink_to(module, target_is_directory=True)


def _modules(cache: Path) -> Iterator[Path]:
    """List the folders of compiled modules, each in a folder of Warp's version."""
    for module in cache.glob('*/*/'):
        if os.access(module, os.R_OK | os.X_OK):
            yield module.resolve()
