# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Simulators that a body is exported to: one file each, found by its name.

A target's module is a `Target`; a new one is a file here and its player in `export.players`.
"""

from importlib import import_module
from pathlib import Path
from typing import cast, Protocol

from diffcal_ros.export.exported_body import ExportedBody


class Target(Protocol):
    """What the module of a target has.

    Attributes:
        SIMULATOR: whose effective modulus it takes, see `export.effective`; empty where the
            material's own is right.
    """

    SIMULATOR: str

    def write(self, body: ExportedBody, folder: Path) -> list[Path]:
        """Write the asset, each file whole or not at all; return the files, the main one first.

        Raises:
            InputError: when a package is missing or a file cannot be written.
        """


def target_names() -> tuple[str, ...]:
    """List the targets; none is imported."""
    return tuple(sorted(file.stem for file in Path(__file__).parent.glob('[!_]*.py')))


def find_target(name: str) -> Target:
    """Return the module of a target.

    Raises:
        ValueError: for a name that is no target.
    """
    if name not in target_names():
        raise ValueError(f'target is {name!r}: use one of {", ".join(target_names())}')
    return cast(Target, import_module(f'{__name__}.{name}'))
