# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a body's results rest on, in a few letters: they change when any of it does."""

from collections.abc import Iterator
import hashlib
from pathlib import Path
from typing import Any

from diffcal_ros import __version__
from diffcal_ros.batch.manifest import Body
from diffcal_ros.scene.model_file import model_path
from diffcal_ros.scene.reading.yaml_document import read_yaml

_LETTERS = 24


class Fingerprints:
    """Takes the fingerprints of bodies, each file that they share once."""

    def __init__(self) -> None:
        self._files: dict[Path, str] = {}
        self._scenes: dict[Path, list[Path]] = {}

    def of(self, body: Body) -> str:
        """Return the fingerprint of what is done with a body, and of every file that it reads.

        A file counts as changed when its size or the time of its last change is another; reading
        hundreds of recordings would take as long as some of the fits.

        Raises:
            SceneError: when its scene is no YAML.
        """
        content = hashlib.sha256(repr((__version__, body.arguments())).encode())
        if body.scene not in self._scenes:
            self._scenes[body.scene] = list(_files_of_scene(body.scene))
        for path in (*self._scenes[body.scene], *body.recordings):
            content.update(f'{path}\0{self._state(path)}\0'.encode(errors='surrogateescape'))
        return content.hexdigest()[:_LETTERS]

    def _state(self, path: Path) -> str:
        if path not in self._files:
            files = sorted(path.rglob('*')) if path.is_dir() else [path]
            self._files[path] = '\0'.join(_file_state(file) for file in files)
        return self._files[path]


def _file_state(file: Path) -> str:
    try:
        found = file.stat()
    except OSError:
        return f'{file.name} is not there'
    return f'{file.name} {found.st_size} {found.st_mtime_ns}'


def _files_of_scene(scene: Path) -> Iterator[Path]:
    """List a scene file, what was accepted for it, and the files that it names."""
    yield from (scene, model_path(scene))
    document = read_yaml(scene).content
    named: list[Any] = [
        *(_entry(document.get(key), 'file') for key in ('mesh', 'fixture', 'modulus_field')),
        document.get('bag'),
    ]
    observations = document.get('observations')
    if isinstance(observations, list):
        named += [_entry(observation, 'bag') for observation in observations]
    for name in named:
        if isinstance(name, str) and '\0' not in name:
            yield scene.parent / Path(name).expanduser()


def _entry(section: Any, key: str) -> Any:
    return section.get(key) if isinstance(section, dict) else None
