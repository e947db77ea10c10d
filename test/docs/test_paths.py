# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the pages name is there: files, folders, modules, links and anchors."""

from pathlib import Path
import re

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = [*sorted((ROOT / 'docs').glob('*.md')), ROOT / 'README.md', ROOT / 'CONTRIBUTING.md']
FOLDERS = ('bags', 'benchmarks', 'config', 'demo', 'diffcal_ros', 'docs', 'launch', 'test')
CODE = re.compile(r'(?<!`)`([^`\n]+)`(?!`)')
FENCE = re.compile(r'^ *```.*?^ *```', re.MULTILINE | re.DOTALL)
LINK = re.compile(r'\]\(([^)\s]+)\)')
HEADING = re.compile(r'^#+ (.*)$', re.MULTILINE)
# In the middle of a command or sentence, too.
PATH = re.compile(rf'(?<![\w./-])((?:{"|".join(FOLDERS)})/[\w./*-]*)')
MODULE = re.compile(r'\bdiffcal_ros(?:\.\w+)+')


def _prose(page: Path) -> str:
    return FENCE.sub('', page.read_text(encoding='utf-8'))


def _is_there(path: str) -> bool:
    path = path.rstrip('.')
    return any(ROOT.glob(path)) if '*' in path else (ROOT / path).exists()


def _is_module(dotted: str) -> bool:
    """Tell whether a module is there, or one that holds the name."""
    path = ROOT / Path(*dotted.split('.'))
    if path.is_dir() or path.with_suffix('.py').is_file():
        return True
    home, name = path.parent, path.name
    file = home / '__init__.py' if home.is_dir() else home.with_suffix('.py')
    return file.is_file() and re.search(rf'\b{name}\b', file.read_text()) is not None


def _anchors(page: Path) -> set[str]:
    titles = HEADING.findall(_prose(page))
    plain = (re.sub(r'[^\w\s-]', '', title.lower()) for title in titles)
    return {re.sub(r'\s+', '-', title.strip()) for title in plain}


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.name)
def test_paths_and_modules_are_there(page):
    named = CODE.findall(_prose(page))
    paths = [path for code in named for path in PATH.findall(code)]
    modules = [module for code in named for module in MODULE.findall(code)]
    assert [path for path in paths if not _is_there(path)] == []
    assert [module for module in modules if not _is_module(module)] == []


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    for link in LINK.findall(_prose(page)):
        if link.startswith(('http://', 'https://', 'mailto:')):
            continue
        file, _, anchor = link.partition('#')
        target = (page.parent / file).resolve() if file else page
        assert target.exists(), link
        assert not anchor or anchor in _anchors(target), link


@pytest.mark.parametrize('name', ['architecture.md', 'adding-a-law.md', 'adding-a-solver.md'])
def test_the_check_finds_paths(name):
    named = CODE.findall(_prose(ROOT / 'docs' / name))
    assert sum(len(PATH.findall(code)) for code in named) >= 5


@pytest.mark.parametrize('wrong', ['diffcal_ros/no/such.py', 'docs/none*.md', 'test/absent'])
def test_what_is_not_there_is_found(wrong):
    assert PATH.findall(f'see {wrong} there') == [wrong]
    assert not _is_there(wrong)


def test_names_in_modules_are_looked_up():
    assert _is_module('diffcal_ros.scene.load')
    assert _is_module('diffcal_ros.scene.load.load_scene')
    assert not _is_module('diffcal_ros.scene.load.load_nothing')
    assert not _is_module('diffcal_ros.nowhere.load')


def test_every_package_stands_in_the_architecture():
    page = (ROOT / 'docs' / 'architecture.md').read_text()
    folders = [path.parent for path in (ROOT / 'diffcal_ros').glob('*/__init__.py')]
    assert [path.name for path in folders if f'`diffcal_ros/{path.name}/`' not in page] == []
