# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The changelog is in ROS's format, and versions agree wherever they stand."""

from pathlib import Path
import re

import diffcal_ros
import pytest

ROOT = Path(__file__).resolve().parents[2]
CHANGELOG = ROOT / 'CHANGELOG.rst'


def test_versions_agree():
    package = re.search(r'<version>(.*)</version>', (ROOT / 'package.xml').read_text())
    setup = re.search(r"version='(.*)'", (ROOT / 'setup.py').read_text())
    assert package is not None
    assert setup is not None
    assert package[1] == setup[1] == diffcal_ros.__version__


def test_the_newest_version_of_the_changelog_is_that_of_the_package():
    titles = re.findall(r'^(.+)\n-+$', CHANGELOG.read_text(), re.MULTILINE)
    released = [title.partition(' ')[0] for title in titles if title != 'Forthcoming']
    assert released[0] == diffcal_ros.__version__


def test_release_tools_read_every_line():
    """A release gives `Forthcoming` its version; only then do they read it."""
    changelog = pytest.importorskip('catkin_pkg.changelog')
    text = CHANGELOG.read_text().replace('Forthcoming\n', '99.0.0 (2099-01-01)\n', 1)
    text = text.replace('-----------\n', '-------------------\n', 1)
    read = changelog.Changelog('diffcal_ros')
    changelog.populate_changelog_from_rst(read, text)
    contents = [one for _, _, found in read.foreach_version() for one in found]
    bullets = [bullet for one in contents for bullet in getattr(one, 'bullets', ())]
    assert len(bullets) == len(re.findall(r'^\* ', text, re.MULTILINE))
