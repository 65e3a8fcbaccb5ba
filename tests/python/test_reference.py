# SPDX-License-Identifier: MPL-2.0
"""The reference of scenes: its tables list exactly the keys that the readers accept, and its examples run.

The readers list the permitted keys of a table in the message about an unknown key, here `probe`.
"""

import json
import os
import re
import unittest
from pathlib import Path

from properties import SOURCE, PropertyTests, batten

REFERENCE = Path(SOURCE) / "docs/reference"
PROBE = "probe = 1"
CURVE = '[[curve]]\nname = "a"\npoints = [[0, 0, 0], [1, 0, 0]]\n'
SEQUENCE = '[sequence]\nfile = "s.pc2"\n'
STRESS = '[stress]\nmaterial = "steel"\nthickness = 1'
LOAD, STIFFNESS = ('name = "x"\nvalue = 1\ntype = "%s"' % kind for kind in ("pressure", "beta"))
PULLS = 'name = "x"\nvalue = 1\ntype = "attractors"\nat = [[0, 0, 0]]'
SOURCE_AND = 'source = { file = "s.pc2" }\n'
TARGET_AND = 'target = { file = "s.pc2" }\n'
FEET = 'feet = ["f"]'


class Probe:
    """A scene with the unknown key `probe` in the table `name`, or in the table `prefix` inside of it."""

    def __init__(self, name, prefix, text, kind=""):
        self.name, self.prefix, self.text, self.kind = name, prefix, text, kind

    def keys(self, documented):
        """The keys of this table among the documented ones of a page."""
        own = (key[len(self.prefix):] for key in documented.get(self.name, ()) if key.startswith(self.prefix))
        return {key for key in own if "." not in key}

    def scene(self, folder):
        top = PROBE if self.name == "" else ""
        text = self.text if self.name else ""
        if folder == "mesh-edit":
            return f'unit = "mm"\nmesh = "m.obj"\n{top}\n{text}\n'
        if folder == "sequence":
            return f'unit = "mm"\n{top}\n' + ("" if text.startswith("[sequence]") else SEQUENCE) + text
        return f'unit = "mm"\n{top}\n{CURVE}' + ("[[fair]]\n" if self.kind == "fair" else "") + text


def one(name, more=""):
    return Probe(name, "", f"{more}[{name}]\n{PROBE}")


def each(name, more=""):
    return Probe(name, "", f"{more}[[{name}]]\n{PROBE}")


def inner(name, prefix, head="", several=False):
    """The table `prefix` in [[name]], which begins with the lines of `head`; `several`: it is a list of tables."""
    key = prefix.split(".")[-1]
    value = "[{ probe = 1 }]" if several else "{ probe = 1 }"
    return Probe(name, prefix + ".", f"[[{name}]]\n{head}\n{key} = {value}")


def stress(name, prefix, key):
    return Probe(name, prefix, f"{STRESS}\n{key} = [{{ probe = 1 }}]")


def operation(kind, *inners):
    """The keys of an operation, and of tables in it: (prefix, lines, whether it is a list). A key of another type is rejected
    with the list of all keys of this type."""
    other = "keyframe = []" if kind != "keyframes" else "through = []"
    probes = [Probe("operation", "", f'[[operation]]\ntype = "{kind}"\n{other}')]
    return probes + [inner("operation", prefix, f'type = "{kind}"\n{head}', several) for prefix, head, several in inners]


TOP = Probe("", "", "")
SHAPES = ("arc", "circle", "ellipse", "rectangle", "helix", "spline")
PROBES = {
    "scene/top": [TOP],
    "scene/curve": [each("curve"), *(inner("curve", shape, 'name = "b"') for shape in SHAPES),
                    *(inner("curve", change, 'name = "b"\ncopy = "a"') for change in ("scale", "rotate", "mirror"))],
    "scene/curves": [each("curves")],
    "scene/fair": [each("fair"), each("fair.condition", "[[fair]]\n"), inner("fair", "brush"), inner("fair", "segment"),
                   Probe("", "", "", "fair"), Probe("output", "", f"[output]\n{PROBE}", "fair"),
                   Probe("picture", "", f"[[picture]]\n{PROBE}", "fair")],
    "scene/face": [each("face")],
    "scene/join": [each("join")],
    "scene/skin": [one("skin")],
    "scene/mesh": [one("mesh")],
    "scene/neighbour": [each("neighbour")],
    "scene/target": [each("target")],
    "scene/constraint": [each("constraint")],
    "scene/load": [each("load"), inner("load", "paint", LOAD, True), inner("load", "drives", LOAD, True), inner("load", "plane", PULLS)],
    "scene/stiffness": [each("stiffness"), inner("stiffness", "paint", STIFFNESS, True), inner("stiffness", "drives", STIFFNESS, True)],
    "scene/offset": [each("offset"), inner("offset", "drives", 'name = "x"\nvalue = 1\ncurve = "a"', True)],
    "scene/parameter": [each("parameter"), inner("parameter", "drives", 'name = "x"\nvalue = 1', True)],
    "scene/motion": [one("motion")],
    "scene/stress": [one("stress"), *(stress("stress", f"{key}.", key) for key in ("thicknesses", "pressures", "plies", "materials", "stiffeners", "masses", "results")),
                     Probe("stress", "stiffeners.section.", f'{STRESS}\nstiffeners = [{{ curve = "a", section = {{ probe = 1 }} }}]'),
                     Probe("stress", "harmonic.", f"{STRESS}\nharmonic = {{ probe = 1 }}"),
                     Probe("stress", "spectrum.", f"{STRESS}\nspectrum = {{ probe = 1 }}"),
                     Probe("stress", "strength.", f"{STRESS}\nstrength = {{ probe = 1 }}"),
                     stress("stress", "combinations.", "loads = [{ pressure = 1 }]\ncombinations"),
                     stress("stress.supports", "", "supports"), stress("stress.loads", "", "loads"),
                     Probe("stress", "thicknesses.paint.", f"{STRESS}\nthicknesses = [{{ thickness = 1, paint = [{{ probe = 1 }}] }}]")],
    "scene/field": [each("field")],
    "scene/output": [one("output")],
    "scene/compare": [one("compare")],
    "scene/picture": [each("picture")],
    "scene/sweep": [each("sweep")],
    "mesh-edit/top": [TOP],
    "mesh-edit/select": [each("select"), *(inner("select", key, 'name = "a"') for key in ("sphere", "plane", "salient", "geodesic"))],
    "mesh-edit/proposals": [one("proposals")],
    "mesh-edit/cut": [each("cut")],
    "mesh-edit/attached": [one("attached")],
    "mesh-edit/feature": [each("feature"), each("features")],
    "mesh-edit/constraint": [each("constraint"), *(inner("constraint", key, 'name = "a"\nof = "b"') for key in ("plane", "axis"))],
    "mesh-edit/relation": [each("relation"), inner("relation", "plane", 'name = "a"\ntype = "symmetric"\nof = "b"')],
    "mesh-edit/chain": [each("chain")],
    "mesh-edit/curve": [each("curve"), *(inner("curve", key, 'name = "a"\nnodes = [1, 2]', True) for key in ("spring", "force", "uniform"))],
    "mesh-edit/position_constraint": [each("position_constraint")],
    "mesh-edit/edit": [each("edit"), *(inner("edit", key, "", True) for key in ("handle", "scale", "rotate_feature", "constraint")),
                       Probe("edit", "handle.rotate.", '[[edit]]\nhandle = [{ name = "a", rotate = { probe = 1 } }]')],
    "mesh-edit/target": [each("target")],
    "mesh-edit/dimension": [each("dimension", "[[edit]]\n")],
    "mesh-edit/require": [each("require", "[[edit]]\n")],
    "mesh-edit/output": [one("output", "[[edit]]\n")],
    "mesh-edit/modes": [one("modes", "[[edit]]\n")],
    "mesh-edit/picture": [each("picture", "[[edit]]\n")],
    "sequence/top": [TOP],
    "sequence/sequence": [one("sequence")],
    "sequence/handle": [each("handle")],
    "sequence/operation": [],
    "sequence/keyframes": [*operation("keyframes", ("keyframe", "", True)),
                           Probe("operation", "keyframe.handle.", '[[operation]]\ntype = "keyframes"\n'
                                 "keyframe = [{ frame = 1, handle = [{ probe = 1 }] }]"),
                           Probe("operation", "keyframe.handle.rotate.", '[[operation]]\ntype = "keyframes"\n'
                                 'keyframe = [{ frame = 1, handle = [{ name = "a", rotate = { probe = 1 } }] }]')],
    "sequence/root_motion": operation("root_motion"),
    "sequence/foot_plants": operation("foot_plants", ("contact_detection", FEET, False), ("terrain", FEET, False)),
    "sequence/path": operation("path", ("contact_detection", "through = [[0, 0, 0], [1, 0, 0]]\n" + FEET, False)),
    "sequence/filter": operation("filter", ("contact_detection", 'filter = "low"\nhandles = ["f"]', False)),
    "sequence/mix": operation("mix", ("source", "", False), ("pair", SOURCE_AND, True)),
    "sequence/morph": [*operation("morph", ("target", "", False), ("align", TARGET_AND, False), ("landmark", TARGET_AND, True)),
                       Probe("operation", "align.rotate.", f'[[operation]]\ntype = "morph"\n{TARGET_AND}align = {{ rotate = {{ probe = 1 }} }}')],
    "sequence/output": [one("output")],
    "sequence/picture": [each("picture")],
}


def documented(page):
    """{table: keys} of a page: first column of the tables with the heading `key`, by the table in the heading above them."""
    found, name, is_keys = {}, "operation" if page.startswith("sequence/") else "", False
    for line in (REFERENCE / f"{page}.md").read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            inside = re.search(r"`\[+([a-z_.]+)\]+`", line)
            name = inside[1] if inside else "" if line.startswith(("# Keys at the top", "## Keys of scenes")) else name
        if re.match(r"\| *key *\|", line):
            is_keys = True
        elif not line.startswith("|"):
            is_keys = False
        elif is_keys:
            found.setdefault(name, set()).update(re.findall(r"`([a-z_.]+)`", line.split("|")[1]))
    return found


def sections(page):
    """The sections that a page names; at the top level, they are keys, too."""
    text = (REFERENCE / f"{page}.md").read_text(encoding="utf-8")
    return set(re.findall(r"`\[+([a-z_]+)\]+`", text)) | ({"unit", "name"} if page == "scene/fair" else set())


class Reference(PropertyTests):
    def accepted(self, text):
        """The keys that the message about `probe` lists."""
        path = self.file("probe.toml")
        Path(path).write_text(text, encoding="utf-8")
        with self.assertRaises(batten.InputError, msg=text) as error:
            batten.run(path, self.file("out"))
        found = re.search(r"found key '\w+' in .*expected one of: ([^;]*)", str(error.exception))
        self.assertTrue(found, f"{text}\n{error.exception}")
        return set(found[1].strip().split(", "))

    def test_keys_are_those_of_the_readers(self):
        others = {"scene/sweep": documented("scene/picture")["picture"]}
        common = documented("sequence/operation")["operation"]
        for page, probes in PROBES.items():
            folder, keys = page.split("/")[0], documented(page)
            unseen = {(name, key) for name in keys for key in keys[name]}
            for probe in probes:
                with self.subTest(page=page, table=probe.name, prefix=probe.prefix):
                    own = probe.keys(keys)
                    unseen -= {(probe.name, probe.prefix + key) for key in own}
                    known = own | others.get(page, set()) | (sections(page) if not probe.name else set())
                    if probe.name == "operation" and not probe.prefix:
                        known |= common
                    accepted = self.accepted(probe.scene(folder))
                    self.assertEqual(own - accepted, set(), "documented, but not accepted")
                    self.assertEqual(accepted - known, set(), "accepted, but not documented")
            self.assertTrue(not probes or not unseen, f"{page}: not asked for: {unseen}")

    def test_every_page_is_compared(self):
        pages = {f"{folder}/{file.stem}" for folder in ("scene", "mesh-edit", "sequence")
                 for file in (REFERENCE / folder).glob("*.md") if file.stem != "index"}
        self.assertEqual(pages, set(PROBES))


if __name__ == "__main__":
    unittest.main()
