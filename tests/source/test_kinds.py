"""A kind owns its members: no struct has members of which a comment says that only one kind uses them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

CPP = Path(__file__).resolve().parents[2] / "cpp"
pytestmark = pytest.mark.skipif(not CPP.is_dir(), reason="the kinds are those of the source tree")


def kinds(files: dict[Path, str]) -> set[str]:
    """Return the names of all kinds: those that lists register, and enumerators of kinds and blends."""
    found = {"burst", "emit", "interaction", "law", "set", "source", "tie"}
    for path, text in files.items():
        if path.suffix == ".inc":
            found |= set(re.findall(r"^MOTES_(?!ATTRIBUTE|OP)\w+\((\w+),", text, re.MULTILINE))
        for names in re.findall(r"enum class (?:\w*Kind|Blend)\b[^{]*\{([^}#]*)\}", text):
            found |= set(re.findall(r"\b[a-z]\w*", re.sub(r"//.*|= *\w+", "", names)))
    return found - {"none", "value", "state", "part"}


def of_one_kind(text: str, names: set[str]) -> list[str]:
    """Return the members whose comments begin with the name of a kind, also in the plural."""
    name = f"(?i:(?:{'|'.join(sorted(names))})e?s?)"
    some = f"{name}(?:(?:, | and | or ){name})*"
    comment = rf"//+<? *(?:(?:of (?:an? )?|kinds? )?{some}(?: alone| only)?:(?!:)|kinds? {some}$)"
    member = rf"^ +(?:[\w:<>,*& ]+ )?[*&]?\w+(?:\[.*\])*(?:\{{.*\}}| = [^;]*)?(?:, [^;]*)?; *{comment}.*"
    above = rf"^ +{comment}.*\n +(?! |enum )[\w:<>,*& ]+ \w+[^();]*;"
    return re.findall(member, text, re.MULTILINE) + re.findall(above, text, re.MULTILINE)


def test_no_member_is_of_one_kind():
    paths = [path for path in CPP.rglob("*") if path.suffix in (".h", ".inc")]
    files = {path.relative_to(CPP): path.read_text() for path in paths}
    names = kinds(files)
    assert {"ribbon", "gravity", "source", "contact", "opaque", "stretch"} <= names
    found = {str(path): of_one_kind(text, names) for path, text in files.items()}
    assert {path: members for path, members in found.items() if members} == {}


@pytest.mark.parametrize(
    "line",
    [
        "  float width = 0;  // ribbon: at its head, m",
        "  Facing facing = Facing::orientation;  // kinds card, mesh: what turns it",
        "  float of_ground = 0;  // kinds card, mesh",
        "  const float *corners, *colors;  // meshes: see MeshCorners",
        "  double rate = 0;  // source: particles per second",
        "  std::array<float, 3> slid{};  // contact, collide: m",
        "  /// Spheres: their lighting.\n  float sun;",
    ],
)
def test_members_of_one_kind_are_found(line: str):
    names = {"ribbon", "card", "mesh", "sphere", "source", "contact", "collide"}
    assert len(of_one_kind(f"struct A {{\n{line}\n}};", names)) == 1
    assert of_one_kind(f"struct A {{\n{line.replace('//', '// if')}\n}};", names) == []


def test_members_of_all_kinds_are_not_found():
    text = "  float fade;  // 0: no softness\n  int pixels = 5;  // diameter of a disc; 0: its size"
    assert of_one_kind(f"struct A {{\n{text}\n}};", {"disc", "mesh"}) == []
