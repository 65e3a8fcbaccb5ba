#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Rewrites scene files with keys of versions before Batten 1.0 in place: present keys, same comments and layout.

usage: update_scene.py FILE…

The old and the present names are those of io/scene/renamed_keys.cpp. In addition
  - `hold = false` of a curve becomes `trim_only = true`,
  - `along = [u, v]` of a stiffness field becomes `parametric_direction = [u, v]`,
  - keys of the mesh move from [skin] to [mesh], with the comments directly above them,
  - the keys of [network] move to [skin].
Files with present keys stay as they are. Needs Python 3 only.
"""
import re
import sys
from pathlib import Path

TABLES = Path(__file__).resolve().parents[2] / "io" / "scene" / "renamed_keys.cpp"
NETWORK_KEYS = {"tolerance": "gap_tolerance", "smooth_below": "crease_angle"}
TOKEN = re.compile(
    r'(?P<comment>#[^\n]*)'
    r'|(?P<text>"""(?:\\.|[^\\])*?"""|\'\'\'.*?\'\'\'|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\')'
    r'|(?P<word>[\w.+-]+)'
    r'|(?P<other>.)', re.DOTALL)
HEADER = re.compile(r'(\[\[?)\s*([\w.-]+)\s*(\]\]?)')


def read_names(source):
    """Present keys by (kind, table, old key), present values by (kind, table, key, old value), and the keys of [mesh]."""
    own = source.split("// Names of other programs.")[0]
    rest = source[source.index("struct RenamedValue"):]
    keys, mesh = {}, set()
    for kind, table, old, now in re.findall(r'\{([SDQ]),\s*"([^"]*)",\s*"([^"]*)",\s*"([^"]*)"\}', own):
        name = now.split()[0]
        keys[kind, table, old] = name
        if now.endswith(" in [mesh]"):
            mesh.add(name)
    values = {(kind, table, key, old): now for kind, table, key, old, now in
              re.findall(r'\{([SDQ]),\s*"([^"]*)",\s*"([^"]*)",\s*"([^"]*)",\s*"([^"]*)"\}', rest)}
    return keys, values, mesh


KEYS, VALUES, MESH_KEYS = read_names(TABLES.read_text(encoding="utf-8"))


def kind_of(text):
    """S: surface or curves, D: deformation of a mesh, Q: sequence."""
    if re.search(r'^\s*\[sequence\]|^\s*\[\[(step|operation)\b', text, re.MULTILINE):
        return "Q"
    if re.search(r'^\s*mesh\s*=\s*["\']|^\s*\[\[edit\b', text, re.MULTILINE):
        return "D"
    return "S"


def renamed(text, kind):
    """The text with present names of tables, keys and values."""
    out = []
    table = ""  # path of the last header, by its present names
    key = None  # (path, present name) of the key whose value follows
    brackets = []  # open ones of that value: ("{" or "[", path of the inner keys, key of the value)
    at_key = True
    at = 0
    while at < len(text):
        header = HEADER.match(text, at) if at_key and not brackets else None
        if header:
            path = ""
            for part in header[2].split("."):
                name = KEYS.get((kind, path, part), part)
                path = f"{path}.{name}" if path else name
            table, at_key = path, False
            out.append(header[1] + table + header[3])
            at = header.end()
            continue
        token = TOKEN.match(text, at)
        word, at = token[0], token.end()
        path = brackets[-1][1] if brackets else table
        if token["comment"]:
            pass
        elif at_key and (token["word"] or token["text"]):
            name = word.strip("\"'")
            now = KEYS.get((kind, path, name), name)
            if (path, name) == ("stiffness", "along") and re.match(r'\s*=\s*\[', text[at:]):
                now = "parametric_direction"
            key, at_key = (path, now, name), False
            word = word.replace(name, now)
        elif token["text"] and key:
            word = word[0] + VALUES.get((kind, key[0], key[1], word[1:-1]), word[1:-1]) + word[-1]
        elif key and key[1:] == ("trim_only", "hold"):
            word = {"true": "false", "false": "true"}.get(word, word)
        elif word in "{[":
            inside = ".".join(p for p in key[:2] if p) if word == "{" and key else path
            brackets.append((word, inside, key))
            at_key = word == "{"
        elif word in "}]" and brackets:
            key, at_key = brackets.pop()[2], False
        elif word == "," and brackets and brackets[-1][0] == "{":
            at_key = True
        elif word == "\n" and not brackets:
            key, at_key = None, True
        out.append(word)
    return "".join(out)


def section(text, name):
    """Beginning of the header of a table, beginning of its lines, and their end; None if there is no such table."""
    header = re.search(rf'^[ \t]*\[{name}\][^\n]*(\n|\Z)', text, re.MULTILINE)
    if not header:
        return None
    following = re.compile(r'^[ \t]*\[\[?[A-Za-z]', re.MULTILINE).search(text, header.end())
    return header.start(), header.end(), following.start() if following else len(text)


def without_network(text):
    """The text with the keys of [network] in [skin]."""
    found = section(text, "network")
    if not found:
        return text
    start, begin, end = found
    lines = re.sub(r'^(\s*)(\w+)(?=\s*=)', lambda m: m[1] + NETWORK_KEYS.get(m[2], m[2]), text[begin:end], flags=re.MULTILINE)
    text = text[:start] + text[end:]
    if not re.search(r'^\s*\w+\s*=', lines, re.MULTILINE):
        return text
    skin = section(text, "skin")
    if not skin:
        return text[:start] + "[skin]\n" + lines + text[start:]
    return text[:skin[1]] + lines.strip("\n") + "\n" + text[skin[1]:]


def with_mesh(text):
    """The text with the keys of the mesh in [mesh] after [skin], or instead of an otherwise empty [skin]."""
    found = section(text, "skin")
    if not found:
        return text
    start, begin, end = found
    stay, move = [], []
    for line in text[begin:end].splitlines(keepends=True):
        key = re.match(r'\s*(\w+)\s*=', line)
        if not (key and key[1] in MESH_KEYS):
            stay.append(line)
            continue
        above = len(stay)
        while above and stay[above - 1].lstrip().startswith("#"):
            above -= 1
        move += stay[above:] + [line if line.endswith("\n") else line + "\n"]
        del stay[above:]
    if not move:
        return text
    rest = "".join(stay).rstrip() + "\n"
    gap = "\n" if text[begin:end].endswith("\n\n") else ""
    if not rest.strip():
        return text[:start] + "[mesh]\n" + "".join(move) + gap + text[end:]
    return text[:begin] + rest + "\n[mesh]\n" + "".join(move) + gap + text[end:]


def updated(text):
    """The scene with present keys."""
    kind = kind_of(text)
    if kind != "S":
        return renamed(text, kind)
    return with_mesh(renamed(without_network(text), kind))


def main():
    for name in sys.argv[1:]:
        with open(name, encoding="utf-8", newline="") as file:
            old = file.read()
        new = updated(old)
        if new != old:
            with open(name, "w", encoding="utf-8", newline="") as file:
                file.write(new)


if __name__ == "__main__":
    main()
