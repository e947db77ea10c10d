# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the installed `diffcal` starts with: a Ctrl-C while its modules load is no fault either."""

import sys

from diffcal_ros.blas_threads import keep_blas_to_one_thread
from diffcal_ros.cli.half_made import leave_half_made_untold

_INTERRUPTED = 130


def main() -> int:
    """Load and run the command; return its exit code."""
    try:
        keep_blas_to_one_thread()
        from diffcal_ros.cli.main import main as run

        return run()
    except KeyboardInterrupt:
        leave_half_made_untold()
        print('diffcal: interrupted before it began', file=sys.stderr)
        return _INTERRUPTED
