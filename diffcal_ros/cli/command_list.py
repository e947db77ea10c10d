# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The subcommands of `diffcal`: each is a module with `add_parser` and `run`."""

from types import ModuleType

from diffcal_ros.cli.commands import (
    accept,
    batch,
    calibrate,
    check,
    diagnose,
    export,
    import_case,
    init,
    predict,
    reproduce,
    revert,
    schema,
    simulate,
    suggest,
    view,
)

COMMANDS: tuple[ModuleType, ...] = (
    check,
    init,
    import_case,
    simulate,
    calibrate,
    view,
    export,
    predict,
    diagnose,
    batch,
    accept,
    revert,
    suggest,
    reproduce,
    schema,
)
