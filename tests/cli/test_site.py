"""The site of docs/: links and pictures, the tables of contents, the blocks of tutorials and guides, and its build by Sphinx."""
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import smidgen
from support.pages import python, sh

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
CODE = re.compile(r"^(```+).*?^\1`*$|`[^`\n]+`", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)\s]+)\)")
STEP = re.compile(r"(?:`(?P<name>[\w.]+)`:\n\n)?^```(?P<language>\w+)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)


def anchor(heading: str) -> str:
    """The fragment by which a heading is found, on the site as on the usual hosts of repositories."""
    text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").strip().lower()
    return re.sub(r"[^\w\- ]", "", text).replace(" ", "-")


def anchors(page: Path) -> set:
    text = re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    return {anchor(heading) for heading in re.findall(r"^#+ (.+)$", text, re.MULTILINE)}


def broken(page: Path, text: str) -> list:
    """The links of a page that lead nowhere."""
    found = []
    for target in LINK.findall(CODE.sub("", text)):
        path, _, fragment = target.partition("#")
        file = (page.parent / path).resolve() if path else page
        if not re.match(r"https?:", target) and not (file.exists() and (not fragment or file.suffix != ".md" or fragment in anchors(file))):
            found.append(target)
    return found


@pytest.mark.quick
def test_links_and_pictures_are_there():
    assert {str(page): links for page in [ROOT / "README.md", *PAGES] if (links := broken(page, page.read_text()))} == {}
    page = DOCS / "spec.md"
    assert broken(page, "[a](gone.md) [b](command.md#gone) ![c](img/gone.png) [d](command.md#files) [e](#units)") == ["gone.md", "command.md#gone", "img/gone.png"]


def listed(page: Path) -> set:
    """The pages of the tables of contents of a page, and of theirs."""
    trees = re.findall(r"^```{toctree}\n(.*?)^```$", page.read_text(), re.MULTILINE | re.DOTALL)
    entries = [line for tree in trees for line in tree.splitlines() if line and not line.startswith(":")]
    found = [page.parent / f"{entry}.md" for entry in entries]
    return {page}.union(*map(listed, found))


@pytest.mark.quick
def test_every_page_is_in_a_table_of_contents():
    assert listed(DOCS / "index.md") == set(PAGES)


@pytest.mark.long
def test_the_site_builds_without_a_warning(tmp_path):
    pytest.importorskip("furo")
    said = subprocess.run([sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", DOCS, tmp_path / "site"], capture_output=True, text=True)
    assert said.returncode == 0, said.stderr
    assert (tmp_path / "site" / "search.html").exists()
    fetched = re.compile(r"<(?:script|img)[^>]+src=\"(?:https?:)?//|<link[^>]+href=\"(?:https?:)?//")
    assert [page.name for page in (tmp_path / "site").rglob("*.html") if fetched.search(page.read_text())] == []


RUN = {"sh": sh, "python": python}
GUIDES = [page for page in PAGES if page.parent.name in ("tutorials", "howto") and page.name != "index.md"]


@pytest.mark.long
@pytest.mark.parametrize("page", GUIDES, ids=lambda page: f"{page.parent.name}/{page.stem}")
def test_a_reader_who_follows_the_page_gets_through(page, tmp_path):
    for step in STEP.finditer(page.read_text()):
        if step["language"] in RUN:
            RUN[step["language"]](step["text"], tmp_path)
        elif step["name"]:
            (tmp_path / step["name"]).write_text(step["text"])


@pytest.mark.long
def test_the_guide_links_with_cmake_and_from_fortran(tmp_path):
    text = (DOCS / "howto" / "link.md").read_text()
    for step in STEP.finditer(text):
        if step["name"]:
            (tmp_path / step["name"]).write_text(step["text"])
    sh("smidgen gen free_rigid_body --amalgamate --out .", tmp_path)
    programs = {}
    if shutil.which("cmake"):
        programs["cmake"] = sh("cmake -S . -B made >/dev/null; cmake --build made >/dev/null; made/body", tmp_path)
    if shutil.which("gfortran"):
        build = next(step["text"] for step in STEP.finditer(text) if "gfortran" in step["text"])
        programs["fortran"] = sh(build, tmp_path)
    if not programs:
        pytest.skip("neither CMake nor a Fortran compiler is installed")
    ends = [[float(number) for number in said.split()] for said in programs.values()]
    assert all(abs(sum(x * x for x in end) - 1) < 1e-12 and end == pytest.approx(ends[0], abs=1e-14) for end in ends)


@pytest.mark.quick
def test_the_page_of_statuses_is_the_header_s():
    header = dict(re.findall(r"^  (SMG_[A-Z_]+) = (\d+)", (ROOT / "runtime" / "core" / "smidgen.h").read_text(), re.MULTILINE))
    page = (DOCS / "reference" / "statuses.md").read_text()
    assert {name: value for value, name in re.findall(r"^\| (\d+) \| `(\w+)`", page, re.MULTILINE)} == header


def test_the_page_of_functions_has_every_public_name():
    page = (DOCS / "reference" / "python.md").read_text()
    assert set(re.findall(r"^\.\. auto\w+:: smidgen\.(\w+)$", page, re.MULTILINE)) == set(smidgen.__all__)
