# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Write a proposed scene."""

from pathlib import Path

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.proposal.draft import Draft
from diffcal_ros.scene.load import load_scene


def save_draft(draft: Draft, path: Path) -> Path:
    """Write a scene file, and read it as whoever goes on from it will.

    Raises:
        InputError: when it cannot be written.
        SceneError: when it is no scene that can be used.
    """
    write_text_atomically(path, draft.text(path.parent))
    load_scene(path)
    return path
