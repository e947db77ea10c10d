# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where MKL is, which pypardiso seeks among all files of all packages."""

from importlib.metadata import files, PackageNotFoundError
import os

_WHERE = 'PYPARDISO_MKL_RT'


def say_where_mkl_is() -> None:
    """Spare pypardiso its search: a second when it is imported, and for every solver."""
    if _WHERE in os.environ:
        return
    try:
        known = files('mkl') or []
    except PackageNotFoundError:
        return  # It came another way, as with conda.
    for path in known:
        if path.name.startswith('libmkl_rt') and os.path.isfile(path.locate()):
            os.environ[_WHERE] = os.path.realpath(path.locate())
