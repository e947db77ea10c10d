# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The user's home and cache folder, where containers and services state them oddly or not at all.

Other libraries take what stands there at its word, and make a folder named `~`.
"""

import atexit
import os
from pathlib import Path
import shutil
import sys
import tempfile

from diffcal_ros.errors import InputError

# A relative one is to be ignored, says the XDG base directory specification.
_ABSOLUTE = ('XDG_CACHE_HOME', 'XDG_CONFIG_HOME')
_FOLDERS = (*_ABSOLUTE, 'MPLCONFIGDIR', 'WARP_CACHE_PATH')


def settle_home() -> None:
    """Make the environment's folders absolute ones; without a home, use a temporary one.

    Raises:
        InputError: when there is no temporary folder either.
    """
    if not os.path.isabs(os.environ.get('HOME', '/')):
        del os.environ['HOME']  # The system's own list of users is asked then.
    try:
        Path.home()
    except RuntimeError:
        os.environ['HOME'] = str(temporary_folder('home'))
        print(
            'there is no home folder, and a temporary one is used: set HOME, or kernels are '
            'compiled again each time',
            file=sys.stderr,
        )
    for name in _FOLDERS:
        given = os.environ.get(name)
        if given is not None and given.startswith('~'):
            os.environ[name] = os.path.expanduser(given)
        if name in _ABSOLUTE and not os.path.isabs(os.environ.get(name, '/')):
            del os.environ[name]


def cache_home() -> Path:
    """Return the folder of what is kept from run to run."""
    given = os.environ.get('XDG_CACHE_HOME', '')
    return Path(given) if os.path.isabs(given) else Path.home() / '.cache'


def temporary_folder(name: str) -> Path:
    """Make a folder that goes away with this process.

    Raises:
        InputError: when there is no place for it.
    """
    try:
        folder = tempfile.mkdtemp(prefix=f'diffcal-{name}-')
    except OSError as error:
        raise InputError(
            f'there is no place for temporary files ({error.strerror or error}): set TMPDIR to a '
            'folder that may be written to and has room'
        ) from error
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)
