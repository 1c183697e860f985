"""The stage of a shot: prims over time, as text of USD."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from . import words
from .facts import CAMERA, Prim, Scene

__all__ = ["material", "scenery", "settings"]

Frames = Sequence[tuple[int, Scene]]
_MESH = (
    ("", "int[] faceVertexCounts"),
    ("", "int[] faceVertexIndices"),
    ("", "point3f[] points"),
    ("", "float3[] extent"),
    ("vertex", "normal3f[] normals"),
    ("vertex", "color3f[] primvars:displayColor"),
    ("vertex", "texCoord2f[] primvars:st"),
)
SCENE = "/World/_scene"
"""The parent of scenery; names of systems' prims begin with a letter."""
LOOKS = f"{SCENE}/Looks"
_TEXTURE = (
    'def Shader "at"',
    "{",
    '    uniform token info:id = "UsdPrimvarReader_float2"',
    '    string inputs:varname = "st"',
    "    float2 outputs:result",
    "}",
)


def settings(frames: Frames) -> list[str]:
    """Return the prim that says how large pictures are."""
    size = frames[-1][1]["world"][CAMERA]["size"]
    return [
        'def Scope "Render"',
        "{",
        '    def RenderSettings "Settings"',
        "    {",
        f"        rel camera = <{SCENE}/{CAMERA}>",
        f"        uniform int2 resolution = {words.vector(size)}",
        "    }",
        "}",
    ]


def scenery(frames: Frames, folder: str, looks: Mapping[str, dict[str, Any]]) -> list[str]:
    """Return the prims of camera, lights, sky and solids, and all materials.

    `looks`: those of systems, by the names of their materials.
    """
    lines = []
    for name in _names(frames, "world"):
        lines += _prim(name, _over_time(frames, "world", name), folder)
    names = _names(frames, "solids")
    materials = {name: _over_time(frames, "solids", name) for name in names}
    if names:
        lines += ['def Scope "Solids"', "{"]
        for name, shown in materials.items():
            lines += [f"    {line}" for line in _prim(name, shown, folder)]
        lines += ["}"]
    lines += ['def Scope "Looks"', "{"]
    for name, shown in materials.items():
        over = [(frame, prim and prim["material"]) for frame, prim in shown]
        lines += [f"    {line}" for line in material(name, over, folder)]
    for name, look in looks.items():
        lines += [f"    {line}" for line in material(name, [(0, look["material"])], folder)]
    lines.append("}")
    return [f'def Xform "{SCENE.rpartition("/")[2]}"', "{", *(f"    {line}" for line in lines), "}"]


def _names(frames: Frames, group: str) -> list[str]:
    return sorted({name for _, scene in frames for name in scene[group]})


def _over_time(frames: Frames, group: str, name: str) -> list[tuple[int, Prim | None]]:
    return [(frame, scene[group].get(name)) for frame, scene in frames]


def _prim(name: str, shown: Sequence[tuple[int, Prim | None]], folder: str) -> list[str]:
    """Return a prim; where it is None it is not seen."""
    known = [prim for _, prim in shown if prim is not None]
    facts, solid = known[-1], "material" in known[-1]
    apis = sorted({api for prim in known for api in prim.get("apis", ())})
    meta = [f"prepend apiSchemas = [{', '.join(map(words.quoted, apis))}]"] if apis else []
    body: list[str] = []
    if solid:
        files = [(frame, prim["mesh"]) for frame, prim in shown if prim is not None]
        if len({file for _, file in files}) == 1:
            meta.append(f"prepend references = {words.asset(folder, files[0][1])}")
        else:
            meta += _clips(files, folder)
            for interpolation, decl in _MESH:
                if decl not in facts["values"]:
                    body += _declared(decl, interpolation)
            body.append('uniform token subdivisionScheme = "none"')
        body.append(f"rel material:binding = <{LOOKS}/{name}>")
    samples: dict[str, list[tuple[int, str]]] = {}
    for frame, prim in shown:
        for decl, text in ({} if prim is None else prim["values"]).items():
            samples.setdefault(decl, []).append((frame, text))
    for decl, values in samples.items():
        body += _sampled(decl, values)
    pictures = [(f, words.asset(folder, p["picture"])) for f, p in shown if p is not None and "picture" in p]
    if pictures:
        body += _sampled("asset inputs:texture:file", pictures)
    if "matrix4d xformOp:transform" in samples:
        body.append('uniform token[] xformOpOrder = ["xformOp:transform"]')
    if any(prim is None for _, prim in shown):
        seen = [(frame, '"invisible"' if prim is None else '"inherited"') for frame, prim in shown]
        body += _sampled("token visibility", seen)
    head = [f'def {facts["type"]} "{name}"'] if not meta else [f'def {facts["type"]} "{name}" (']
    closing = [*(f"    {line}" for line in meta), ")"] if meta else []
    return [*head, *closing, "{", *(f"    {line}" for line in body), "}"]


def _declared(decl: str, interpolation: str) -> list[str]:
    return [decl] if not interpolation else [f"{decl} (", f'    interpolation = "{interpolation}"', ")"]


def _clips(files: Sequence[tuple[int, str]], folder: str) -> list[str]:
    """Return the metadata of a mesh that is another one in some frames."""
    assets = list(dict.fromkeys(file for _, file in files))
    active = ", ".join(f"({frame}, {assets.index(file)})" for frame, file in files)
    return [
        "clips = {",
        "    dictionary default = {",
        f"        double2[] active = [{active}]",
        f"        asset[] assetPaths = [{', '.join(words.asset(folder, file) for file in assets)}]",
        '        string primPath = "/Mesh"',
        f"        double2[] times = [({files[0][0]}, 0), ({files[-1][0]}, 0)]",
        "    }",
        "}",
    ]


def _sampled(decl: str, values: Sequence[tuple[int, str]]) -> list[str]:
    """Return an attribute: one value, or samples where a run of equal ones begins and ends."""
    if len({text for _, text in values}) == 1:
        return [f"{decl} = {values[0][1]}"]
    kept = [
        (frame, text)
        for i, (frame, text) in enumerate(values)
        if not (0 < i < len(values) - 1 and values[i - 1][1] == text == values[i + 1][1])
    ]
    lines = [f"    {frame}: {text}," for frame, text in kept]
    # Blender takes the colour of a material, and others its preview, from the value without time.
    return [f"{decl} = {values[0][1]}", f"{decl}.timeSamples = {{", *lines, "}"]


def material(name: str, shown: Iterable[tuple[int, dict[str, Any] | None]], folder: str) -> list[str]:
    """Return a material, whose numbers may change over time."""
    known = [(frame, one) for frame, one in shown if one is not None]
    facts = known[-1][1]
    samples: dict[str, list[tuple[int, str]]] = {}
    for frame, one in known:
        for decl, text in one["values"].items():
            samples.setdefault(decl, []).append((frame, text))
    here = f"{LOOKS}/{name}"
    body = ['uniform token info:id = "UsdPreviewSurface"']
    shaders: list[str] = []
    if "picture" in facts or facts.get("by") == "color":
        target = "diffuseColor" if facts.get("shaded", True) else "emissiveColor"
        samples.pop(f"color3f inputs:{target}", None)
        source = "picture.outputs:rgb" if "picture" in facts else "color.outputs:result"
        body.append(f"color3f inputs:{target}.connect = <{here}/{source}>")
        if target == "emissiveColor":
            body.append("color3f inputs:diffuseColor = (0, 0, 0)")
    if "picture" in facts:
        shaders += [*_TEXTURE, *_texture("picture", facts["picture"], folder, here, facts.get("scale"))]
        if facts.get("clear"):
            body.append(f"float inputs:opacity.connect = <{here}/picture.outputs:a>")
    elif facts.get("by") == "color":
        shaders += _reader("color", "displayColor", "float3", "(1, 1, 1)")
        if facts.get("fades"):
            shaders += _reader("opacity", "displayOpacity", "float", "1")
            body.append(f"float inputs:opacity.connect = <{here}/opacity.outputs:result>")
    if "finish" in facts:
        shaders += [] if "picture" in facts else _TEXTURE
        shaders += _texture("finish", facts["finish"], folder, here, facts["factors"], raw=True)
        for number, channel in (("roughness", "g"), ("metallic", "b")):
            samples.pop(f"float inputs:{number}", None)
            body.append(f"float inputs:{number}.connect = <{here}/finish.outputs:{channel}>")
    for decl, values in samples.items():
        body += _sampled(decl, values)
    body.append("token outputs:surface")
    return [
        f'def Material "{name}"',
        "{",
        f"    token outputs:surface.connect = <{here}/surface.outputs:surface>",
        '    def Shader "surface"',
        "    {",
        *(f"        {line}" for line in body),
        "    }",
        *(f"    {line}" for line in shaders),
        "}",
    ]


def _reader(name: str, primvar: str, kind: str, fallback: str) -> list[str]:
    return [
        f'def Shader "{name}"',
        "{",
        f'    uniform token info:id = "UsdPrimvarReader_{kind}"',
        f'    string inputs:varname = "{primvar}"',
        f"    {kind} inputs:fallback = {fallback}",
        f"    {kind} outputs:result",
        "}",
    ]


def _texture(
    name: str, file: str, folder: str, here: str, scale: Sequence[float] | None, *, raw: bool = False
) -> list[str]:
    space = "raw" if raw or file.endswith(".hdr") else "sRGB"
    return [
        f'def Shader "{name}"',
        "{",
        '    uniform token info:id = "UsdUVTexture"',
        f"    asset inputs:file = {words.asset(folder, file)}",
        f"    float2 inputs:st.connect = <{here}/at.outputs:result>",
        f'    token inputs:sourceColorSpace = "{space}"',
        '    token inputs:wrapS = "repeat"',
        '    token inputs:wrapT = "repeat"',
        *([] if scale is None else [f"    float4 inputs:scale = {words.vector((*scale, 1))}"]),
        "    float outputs:a",
        "    float outputs:b",
        "    float outputs:g",
        "    float3 outputs:rgb",
        "}",
    ]
