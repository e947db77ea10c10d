# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The subcommands of `diffcal`: each is a module with `add_parser` and `run`."""

from types import ModuleType

from diffcal_ros.cli import (
    accept_command,
    batch_command,
    calibrate_command,
    check_command,
    diagnose_command,
    export_command,
    import_command,
    init_command,
    predict_command,
    reproduce_command,
    revert_command,
    schema_command,
    simulate_command,
    suggest_command,
    view_command,
)

COMMANDS: tuple[ModuleType, ...] = (
    check_command,
    init_command,
    import_command,
    simulate_command,
    calibrate_command,
    view_command,
    export_command,
    predict_command,
    diagnose_command,
    batch_command,
    accept_command,
    revert_command,
    suggest_command,
    reproduce_command,
    schema_command,
)
