#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Files that state more than they contain, full disks, and dates in files.

    tests/apps/test_hostile_files.py BATTEN

Needs no display. The tests with small disks are skipped if `unshare` is not permitted.
"""
import argparse
import base64
import json
import os
import pathlib
import resource
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

PROGRAM = ""
CURVES = "0,0,0\n100,0,0\n100,80,0\n0,80,0\n0,0,0\n"
SVG = '<svg xmlns="http://www.w3.org/2000/svg">{}</svg>'
VTP = """<?xml version="1.0"?>
<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64"{compressor}><PolyData>
<Piece NumberOfPoints="{points}" NumberOfVerts="0" NumberOfLines="0" NumberOfStrips="0" NumberOfPolys="{faces}">
<PointData><DataArray type="Float64" Name="x" NumberOfComponents="{components}" format="ascii">0 0 0</DataArray></PointData>
<Points><DataArray type="Float64" NumberOfComponents="3" {data}</DataArray></Points>
<Polys><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">3</DataArray></Polys></Piece></PolyData></VTKFile>"""
TRIANGLE = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
ACCESSOR = {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}


def dxf(entities, blocks=""):
    pairs = f"0 SECTION 2 BLOCKS {blocks} 0 ENDSEC 0 SECTION 2 ENTITIES {entities} 0 ENDSEC 0 EOF"
    return "\n".join(pairs.split()) + "\n"


def block(name, content):
    return f"0 BLOCK 2 {name} 10 0 20 0 {content} 0 ENDBLK "


def insert(name):
    return f"0 INSERT 2 {name} 10 0 20 0 "


def vtp(points=3, faces=1, components=1, data='format="ascii">0 0 0 1 0 0 0 1 0', compressor=""):
    return VTP.format(points=points, faces=faces, components=components, data=data, compressor=compressor)


def compressed(megabytes):
    packed = zlib.compress(bytes(megabytes << 20), 9)
    blocks = base64.b64encode(struct.pack("<4Q", 1, megabytes << 20, 0, len(packed))) + base64.b64encode(packed)
    return vtp((megabytes << 20) // 24, data='format="binary">' + blocks.decode(),
               compressor=' compressor="vtkZLibDataCompressor"')


def gltf(**changes):
    scene = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
             "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "bufferViews": [{"buffer": 0, "byteLength": 36}],
             "buffers": [{"byteLength": 36, "uri": "data:;base64," + base64.b64encode(TRIANGLE).decode()}],
             "accessors": [ACCESSOR]}
    return json.dumps(scene | changes)


def used_often(**changes):
    """Many uses of an accessor of 300,000 vertices without data."""
    return gltf(accessors=[{"componentType": 5126, "count": 300000, "type": "VEC3"}], **changes)


def levels(count, each, name, of, last):
    """`count` definitions, each of which uses the next one `each` times."""
    return "".join(of(f"{name}{i}", each, f"{name}{i + 1}") for i in range(count)) + last(f"{name}{count}")


LINE = "0 LINE 10 0 20 0 11 1 21 1 "
BLOCKS = levels(9, 20, "B", lambda a, n, b: block(a, insert(b) * n), lambda a: block(a, LINE))
POLYLINE = "0 LWPOLYLINE " + " ".join(f"10 {i} 20 {i % 7}" for i in range(5000))
ENTITIES = levels(8, 10, "e", lambda a, n, b: f'<!ENTITY {a} "{f"&{b};" * n}">', lambda a: f'<!ENTITY {a} "<g/>">')
PLY = """ply
format ascii 1.0
element vertex {}
property float x
property float y
property float z
element face {}
property list uchar int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
3 0 1 2
"""

# Name of the file, contents, part of the message.
HOSTILE = [
    ("knots.dxf", dxf("0 SPLINE 71 3 72 2000000000 73 2000000000 10 0 20 0 10 1 20 1"), "found 2 poles"),
    ("degree.dxf", dxf("0 SPLINE 71 2000000000 10 0 20 0 10 1 20 1"), "found the degree 2000000000"),
    ("blocks.dxf", dxf(insert("B0"), BLOCKS), "curves of inserted blocks"),
    ("empty.dxf", dxf(insert("B0"), BLOCKS.replace(LINE, "")), "curves of inserted blocks"),
    ("vertices.dxf", dxf(insert("A") * 2000, block("A", POLYLINE)), "vertices of curves of inserted blocks"),
    ("cycle.dxf", dxf(insert("A"), block("A", insert("A") * 3)), "blocks that contain each other"),
    ("chain.dxf", dxf("".join(insert(f"B{i}") for i in range(300, -1, -1)),
                      levels(300, 1, "B", lambda a, n, b: block(a, insert(b)), lambda a: block(a, LINE))), "nested more than"),
    ("entities.svg", f"<!DOCTYPE svg [{ENTITIES}]>" + SVG.format("&e0;"), "found an entity with the text"),
    ("long.svg", f'<!DOCTYPE svg [<!ENTITY a "{"M0 0L1 1" * 9000}">]>' + SVG.format(f'<path d="{"&a;" * 9000}"/>'),
     "found an entity with the text"),
    ("uses.json", json.dumps({"nodes": [], "strokes": [{"id": i, "segments": [0]} for i in range(5000)], "segments": [
        {"id": 0, "stroke_id": 0, "nodes": [0, 1], "ctrl_pts": [[[i, 0, 0], [i + 1, 0, 0]] for i in range(5000)]}]}),
     "expected segments that are used once"),
    ("use.svg", SVG.format(levels(14, 10, "u", lambda a, n, b: f'<g id="{a}">{f"""<use href="#{b}"/>""" * n}</g>',
                                  lambda a: f'<path id="{a}" d="M0 0L1 1"/>')), "elements in clones"),
    ("chain.svg", SVG.format("<defs>" + levels(20000, 1, "u", lambda a, n, b: f'<use id="{a}" href="#{b}"/>',
                                               lambda a: f'<path id="{a}" d="M0 0L1 1"/>') + '</defs><use href="#u0"/>'),
     "nested more than 16 levels"),
    ("vertices.svg", SVG.format(f'<defs><path id="a" d="M0 0{"L1 1 2 3" * 5000}"/></defs>' + '<use href="#a"/>' * 20000),
     "MB of their path data"),
    ("nodes.off", "OFF\n2000000000 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "found 4 nodes, expected 2000000000"),
    ("faces.off", "OFF\n3 2000000000 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "found 1 face, expected 2000000000"),
    ("nodes.ply", PLY.format(2000000000, 1), "found the end of the file"),
    ("faces.ply", PLY.format(3, 2000000000), "found the end of the file"),
    ("elements.bdf", "GRID,1\nGRID,2\nGRID,3\nCTRIA3,1,1,1,2,3\n" + "RBE2,10,1,123,2,THRU,9999999\n" * 100,
     "found more nodes than an element has"),
    ("sets.inp", "*NODE\n" + "".join(f"{i},{i % 7}.,{i}.,0.\n" for i in range(1, 3001)) + "*ELEMENT,TYPE=S3\n1,1,2,3\n" +
     "".join(f"*NSET,NSET=A{i},GENERATE\n1,2000000000,1\n" for i in range(3000)), "nodes and faces in the sets and connections"),
    ("many.stl", bytes(80) + struct.pack("<I", 0xffffffff) + bytes(50), "for 4294967295 triangles"),
    ("many.curves", "v 2000000000\n0 0 0\n1 1 1\n", "expected 2000000000 as stated"),
    ("a.pc2", b"POINTCACHE2\0" + struct.pack("<iiffi", 1, 2147483647, 0, 1, 2147483647) + bytes(36), "expected 5.53402e+19"),
    ("a.mdd", struct.pack(">ii", 2147483647, 2147483647) + bytes(36), "expected 5.53402e+19"),
    ("points.vtp", vtp(points=2000000000), "NumberOfPoints = '2000000000'"),
    ("faces.vtp", vtp(faces=2000000000), "NumberOfPolys = '2000000000'"),
    ("components.vtp", vtp(components=30000000), "NumberOfComponents = '30000000'"),
    ("packed.vtp", compressed(200), "NumberOfPoints"),
    ("type.vtp", vtp().replace("<VTKFile", '<!DOCTYPE a [<!ENTITY b "c">]><VTKFile'), "found a document type"),
    ("count.gltf", gltf(accessors=[ACCESSOR | {"count": 2000000000}]), "more than there is room for"),
    ("zeros.gltf", gltf(accessors=[{"componentType": 5126, "count": 10000000, "type": "VEC3"}]), "more than there is room for"),
    ("offset.gltf", gltf(accessors=[ACCESSOR | {"byteOffset": 900000000000000}]), "which has 36"),
    ("view.gltf", gltf(bufferViews=[{"buffer": 0, "byteLength": 36, "byteOffset": 900000000000000}]), "which has 36"),
    ("stride.gltf", gltf(bufferViews=[{"buffer": 0, "byteLength": 36, "byteStride": 900000000000000}]), "which has 36"),
    ("nodes.gltf", used_often(nodes=[{"mesh": 0}] * 20000, scenes=[{"nodes": list(range(20000))}]), "counted for each node"),
    ("primitives.gltf", used_often(meshes=[{"primitives": [{"attributes": {"POSITION": 0}}] * 20000}]),
     "counted for each node"),
    ("targets.gltf", used_often(meshes=[{"primitives": [{"attributes": {"POSITION": 0},
                                                         "targets": [{"POSITION": 0}] * 20000}]}]), "counted for each node"),
]
PARTS = 10000  # segments of the drawings that are read in less than a second


def long_drawings():
    """Drawings with PARTS segments in one curve, and with as many curves."""
    numbers = range(PARTS)
    points = [(i, (i * i) % 7 + (i % 3) / 2) for i in range(PARTS + 1)]
    pairs = list(zip(points, points[1:]))
    polyline = " ".join(f"10 {x} 20 {y}" for x, y in points)
    knots = " ".join(f"40 {k}" for k in [0] * 3 + list(range(PARTS - 1)) + [PARTS - 2] * 3)
    return {
        "cubics.svg": SVG.format('<path d="M0 0 ' + " ".join(f"C{i} {i % 3} {i + .5} {i % 5} {i + 1} 0" for i in numbers) + '"/>'),
        "arcs.svg": SVG.format('<path d="M0 0 ' + " ".join(f"a1 .5 0 0 {i % 2} 1 0" for i in numbers) + '"/>'),
        "lines.svg": SVG.format('<path d="M' + " L".join(f"{x} {y}" for x, y in points) + '"/>'),
        "paths.svg": SVG.format("".join(f'<path d="M{a[0]} {a[1]} L{b[0]} {b[1]}"/>' for a, b in pairs)),
        "bulges.dxf": dxf("0 LWPOLYLINE " + " ".join(f"10 {x} 20 {y} 42 .3" for x, y in points)),
        "polyline.dxf": dxf("0 LWPOLYLINE " + polyline),
        "lines.dxf": dxf(" ".join(f"0 LINE 10 {a[0]} 20 {a[1]} 11 {b[0]} 21 {b[1]}" for a, b in pairs)),
        "spline.dxf": dxf(f"0 SPLINE 71 3 {knots} {polyline}"),
        "corners.json": json.dumps({"strokes": [{"id": 0, "segments": [0]}], "nodes": [], "segments": [
            {"id": 0, "stroke_id": 0, "nodes": [0, 1], "ctrl_pts": [[[*a, 0], [*b, 0]] for a, b in pairs]}]}),
    }


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="batten_hostile_"))
        self.write("curves.csv", CURVES)

    def tearDown(self):
        shutil.rmtree(self.folder, ignore_errors=True)

    def write(self, name, contents):
        path = self.folder / name
        path.write_bytes(contents if isinstance(contents, bytes) else contents.encode())
        return path

    def run_batten(self, *words, **environment):
        return subprocess.run([PROGRAM, *map(str, words)], cwd=self.folder, env={**os.environ, **environment},
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=120)

    def measured(self, *words):
        """Exit code, messages, processor time in seconds and memory in MB, with child processes."""
        with open(self.folder / "messages", "w+") as messages:
            process = subprocess.Popen([PROGRAM, *map(str, words)], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=messages,
                                       preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (60, 60)))
            _, status, used = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
            messages.seek(0)
            return process.returncode, messages.read(), used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


class HostileFiles(Case):
    def test_refused_in_a_second_and_100_mb(self):
        for name, contents, about in HOSTILE:
            if name.endswith((".pc2", ".mdd")):
                self.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
            with self.subTest(name):
                code, messages, seconds, megabytes = self.measured("info", self.write(name, contents))
                self.assertEqual(code, 1, messages)
                self.assertIn(about, messages)
                self.assertLess(seconds, 5)  # one second, with a reserve for slow machines
                self.assertLess(megabytes, 100)

    def test_included_files_that_repeat(self):
        self.write("nodes.inp", "** " + "x" * 200000 + "\n")
        deck = self.write("deck.inp", "*INCLUDE,INPUT=nodes.inp\n" * 5000)
        code, messages, seconds, megabytes = self.measured("info", deck)
        self.assertEqual(code, 1)
        self.assertIn("files that are included fewer times", messages)
        self.assertLess(seconds, 5)
        self.assertLess(megabytes, 100)

    def test_long_drawings_are_read_in_a_second(self):
        for name, text in long_drawings().items():
            with self.subTest(name):
                code, messages, seconds, _ = self.measured("info", self.write(name, text))
                self.assertEqual(code, 0, messages)
                self.assertLess(seconds, 5)


class SoundFiles(Case):
    def test_names_that_look_like_counts(self):
        text = vtp().replace('Name="x"', 'Name="NumberOfHits"')
        done = self.run_batten("info", self.write("a.vtp", text))
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_entities_of_addresses(self):
        text = '<!DOCTYPE svg [<!ENTITY a "http://ns.adobe.com/Extensibility/1.0/">]>' + SVG.format('<path d="M0 0 L9 9" class="&a;"/>')
        done = self.run_batten("info", self.write("a.svg", text))
        self.assertEqual(done.returncode, 0, done.stderr)


    def refused(self, name, contents):
        code, messages, _, _ = self.measured("info", self.write(name, contents))
        self.assertIn(code, (0, 1), messages)
        return code == 1

    def test_just_below_and_above_a_limit(self):
        entity = '<!DOCTYPE svg [<!ENTITY a "{}">]>' + SVG.format('<path d="M0 0 L9 9"/>')
        self.assertFalse(self.refused("a.svg", entity.format("x" * 200)))
        self.assertTrue(self.refused("a.svg", entity.format("x" * 201)))

        def nested(count):
            blocks = levels(count - 1, 1, "B", lambda a, n, b: block(a, insert(b)), lambda a: block(a, LINE))
            return dxf(insert("B0"), blocks)
        self.assertFalse(self.refused("a.dxf", nested(16)))
        self.assertTrue(self.refused("a.dxf", nested(17)))

        def zeros(count):
            return gltf(accessors=[ACCESSOR, {"componentType": 5126, "count": count, "type": "VEC3"}],
                        meshes=[{"primitives": [{"attributes": {"POSITION": 1}}]}])
        self.assertFalse(self.refused("a.gltf", zeros(((1 << 20) + 36) // 3)))
        self.assertTrue(self.refused("a.gltf", zeros(((1 << 20) + 36) // 3 + 1)))

        def uses(count):
            there_and_back = [[[0, 0, 0], [1, 0, 0]], [[1, 0, 0], [0, 0, 0]]]
            return json.dumps({"nodes": [], "strokes": [{"id": i, "segments": [0] * 100} for i in range(count)],
                               "segments": [{"id": 0, "stroke_id": 0, "nodes": [0, 1], "ctrl_pts": there_and_back}]})
        self.assertFalse(self.refused("a.json", uses(500)))
        self.assertTrue(self.refused("a.json", uses(501)))

        def sets(count):
            nodes = "".join(f"{i},{i}.,{i * i % 97}.,0.\n" for i in range(1, 10001))
            return f"*NODE\n{nodes}*ELEMENT,TYPE=S3\n1,1,2,3\n" + "*NSET,NSET=A,GENERATE\n1,10000,1\n" * count
        size = len(sets(0))
        most = next(count for count in range(1000) if 10000 * count > 1000000 + 16 * (size + 32 * count)) - 1
        self.assertFalse(self.refused("a.inp", sets(most)))
        self.assertTrue(self.refused("a.inp", sets(most + 1)))


class FilesOfScenes(Case):
    def reads(self, uri):
        scene = self.write("scenes/a.gltf", gltf(buffers=[{"byteLength": 36, "uri": uri}]))
        return self.run_batten("info", scene)

    def test_buffers_stay_in_the_folder(self):
        for folder in ("scenes", "scenes/data", "scenes2"):
            os.makedirs(self.folder / folder)
        for name in ("outside.bin", "scenes/own.bin", "scenes/data/own.bin", "scenes2/outside.bin"):
            self.write(name, TRIANGLE)
        os.symlink("../outside.bin", self.folder / "scenes/link.bin")
        os.symlink("own.bin", self.folder / "scenes/good.bin")
        os.symlink("..", self.folder / "scenes/up")
        for uri in ("own.bin", "./own.bin", "data/own.bin", "data/../own.bin", "good.bin", "%6Fwn.bin"):
            done = self.reads(uri)
            self.assertEqual(done.returncode, 0, uri + done.stderr)
        for uri in ("../outside.bin", "data/../../outside.bin", "%2e%2e/outside.bin", "%2E%2E%2Foutside.bin",
                    f"{self.folder}/outside.bin", f"file://{self.folder}/outside.bin", "FILE:own.bin",
                    "http://localhost/own.bin", "link.bin", "up/outside.bin", "../scenes2/outside.bin", "own.bin%00", "/dev/zero"):
            done = self.reads(uri)
            self.assertEqual(done.returncode, 1, uri)
            self.assertIn("expected a file in the folder of this scene or below it", done.stderr)


def small_disks():
    words = ["unshare", "--mount", "sh", "-c", "mount -t tmpfs none /mnt"]
    return shutil.which("unshare") and subprocess.run(words, stderr=subprocess.DEVNULL).returncode == 0


class FullDisks(Case):
    @unittest.skipUnless(small_disks(), "a mount namespace is not permitted")
    def test_files_that_libraries_write(self):
        for name in ("disk", "large"):
            os.makedirs(self.folder / name)
        self.assertEqual(self.run_batten("skin", "curves.csv", "--out", "large", "--quiet").returncode, 0)
        commands = [f"convert large/curves.step disk/a.{kind}" for kind in ("step", "iges", "brep", "3mf")]
        commands += ["fair curves.csv --out disk/a.step", "fair curves.csv --out disk/a.iges"]
        commands += ["info curves.csv --picture disk/a.png"] if shutil.which("Xvfb") else []
        for command in commands:
            for room in (0, 4) if command.endswith(("3mf", "png")) else (0,):  # KB
                with self.subTest(command, room=room):
                    script = (f"mount -t tmpfs -o size={16 + room}k none disk; head -c 16384 /dev/zero > disk/fill; "
                              f'"$0" {command}; echo code $?; ls -A disk')
                    done = subprocess.run(["unshare", "--mount", "sh", "-c", script, PROGRAM], cwd=self.folder,
                                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=120)
                    name = command.split("disk/")[1].split()[0]
                    if room > 0 and "code 0\n" in done.stdout:  # there was room enough
                        continue
                    self.assertIn(f"{name}: cannot write this file: No space left on device", done.stderr)
                    self.assertIn("code 1\n", done.stdout, done.stderr)
                    self.assertEqual(done.stdout.split("code 1\n")[1].split(), ["fill"])


class Dates(Case):
    DATED = ("fair.step", "fair.iges", "converted.step", "converted.iges")

    def written(self, folder, date, dated_only=False):
        """The files that the commands write at this date, by name."""
        environment = {} if date is None else {"SOURCE_DATE_EPOCH": date}
        os.makedirs(self.folder / folder)
        names = self.DATED if dated_only else self.DATED + ("fair.dxf", "fair.vtp", "converted.brep", "converted.glb", "converted.3mf")
        commands = [f"fair curves.csv --out {folder}/{name} --quiet" if name.startswith("fair") else
                    f"convert skin/curves.step {folder}/{name}" for name in names]
        if not dated_only:
            commands += [f"skin curves.csv --out {folder} --step-curves --quiet"]
            commands += [f"info curves.csv --picture {folder}/combs.png"] if shutil.which("Xvfb") else []
        for command in commands:
            done = self.run_batten(*command.split(), **environment)
            self.assertEqual(done.returncode, 0, command + done.stderr)
        return {file.name: file.read_bytes() for file in (self.folder / folder).iterdir() if file.name != "report.json"}

    def test_same_date_same_bytes(self):
        self.assertEqual(self.run_batten("skin", "curves.csv", "--out", "skin", "--quiet").returncode, 0)
        first = self.written("first", "1700000000")
        second = self.written("second", "1700000000")
        self.assertEqual([name for name in first if first[name] != second[name]], [])
        for name in ("curves.step", "fair.step", "converted.step"):
            self.assertIn(b"'2023-11-14T22:13:20'", first[name])
        for name in ("fair.iges", "converted.iges"):
            self.assertEqual(first[name].replace(b"\n", b"").count(b"15H20231114.221320"), 2)
        now = self.written("now", None, dated_only=True)
        self.assertEqual([name for name in self.DATED if first[name] == now[name]], [])

    def test_invalid_dates(self):
        for date in ("", "today", "1700000000.5", "-1", "99999999999999999999", " 1"):
            done = self.run_batten("fair", "curves.csv", "--out", "a.step", SOURCE_DATE_EPOCH=date)
            self.assertEqual(done.returncode, 1, date)
            self.assertIn(f"found SOURCE_DATE_EPOCH = '{date}' in the environment", done.stderr)
            self.assertFalse((self.folder / "a.step").exists())


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    known, rest = parser.parse_known_args()
    PROGRAM = os.path.abspath(known.program)
    unittest.main(argv=[sys.argv[0], *rest])
