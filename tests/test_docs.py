"""What the documentation names is there: records, files of the code, pages that links lead to."""

import re
from pathlib import Path

import pytest

import iwis

ROOT = Path(iwis.__file__).resolve().parent
RECORDS = sorted((ROOT / "docs" / "decisions").glob("*.md"))
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]
CODE = sorted(
    path
    for folder in ("core", "iwis_addon", "operators", "paper", "scripts", "tests", "benchmarks")
    for path in (ROOT / folder).rglob("*.py")
)


def numbers_of_records(names) -> list[int]:
    return [int(name[:4]) for name in names]


def dead_links(page: Path, text: str) -> list[str]:
    """Of [text](target), targets that are files of the repository and not there."""
    targets = re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", text)
    return [t for t in targets if "://" not in t and not (page.parent / t).exists()]


def files_that_are_gone(text: str, known: set[str]) -> set[str]:
    """Names of Python files in backticks that no folder of the code has."""
    named = re.findall(r"`(?:[\w/]+/)?([a-z_]\w*\.py)`", text)
    return set(named) - known


def records_that_are_gone(text: str) -> set[str]:
    """Records that a path names, with their title or without."""
    there = [record.stem for record in RECORDS]
    named = re.findall(r"decisions/(\d{4}[\w-]*)", text)
    return {name for name in named if not any(stem.startswith(name) for stem in there)}


def test_records_have_numbers_of_their_own():
    """One after another from 1 on, and each says its own in the first line."""
    numbers = numbers_of_records(record.name for record in RECORDS)
    assert numbers == list(range(1, len(RECORDS) + 1))
    for number, record in zip(numbers, RECORDS, strict=True):
        assert record.read_text().startswith(f"# {number}. "), record.name


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_pages_name_what_is_there(page):
    """Links, files of the code, and [decision 7](...) leads to record 7."""
    text, known = page.read_text(), {path.name for path in CODE}
    known |= {path.name for path in ROOT.glob("*.py")}
    assert dead_links(page, text) == []
    assert files_that_are_gone(text, known) == set()
    for number, target in re.findall(r"\[(?:decision|record)\s+(\d+)\]\(([^)]+)\)", text):
        assert numbers_of_records([Path(target).name]) == [int(number)], target


def test_code_names_records_that_are_there():
    """Docstrings and comments send readers to docs/decisions."""
    gone = {path.name: records_that_are_gone(path.read_text()) for path in CODE}
    assert {name: records for name, records in gone.items() if records} == {}


def test_these_tests_would_notice():
    """A link to nowhere, a file that is gone, a record that never was."""
    page = ROOT / "README.md"
    assert dead_links(page, "[a](docs/no.md), [b](docs/measured.md#c)") == ["docs/no.md"]
    assert files_that_are_gone("`core/gone.py`, `here.py`", {"here.py"}) == {"gone.py"}
    assert records_that_are_gone("docs/decisions/" + "0000 and decisions/0007") == {"0000"}
