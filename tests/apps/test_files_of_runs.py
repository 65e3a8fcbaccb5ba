#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""What the program does with files that exist: inputs, links, permissions, runs that meet or are killed, full disks.

    tests/apps/test_files_of_runs.py BATTEN [--kills 8] [--pairs 6] [--table]

Needs no display. The tests with namespaces (same process id, small disks) are skipped if `unshare` is not permitted.
--table prints what happens for each pair of a file that a command reads and a file that it writes.
"""
import argparse
import hashlib
import json
import os
import pathlib
import shutil
import signal
import stat
import subprocess
import sys
import tempfile
import time
import unittest

# No X server; the same date in all files.
ENVIRONMENT = {key: value for key, value in os.environ.items() if key != "DISPLAY"} | {
    "BATTEN_XVFB": "", "SOURCE_DATE_EPOCH": "1700000000"}
ARGUMENTS = argparse.Namespace(program="", kills=8, pairs=6, table=False)

RECTANGLE = "0,0,0\n100,0,0\n100,80,0\n0,80,0\n0,0,0\n"
SCENE = """
name = "shape"
unit = "mm"
[mesh]
edge_length = 25
[[curve]]
name = "outline"
file = "curves.csv"
[[load]]
name = "swell"
type = "pressure"
value = {height}
[output]
step = "{stem}.step"
vtp = "{stem}.vtp"
"""
DECK = """*NODE
{nodes}
*ELEMENT, TYPE=S4, ELSET=PLATE
{elements}
"""
EDIT = """
name = "plate"
unit = "mm"
mesh = "{deck}"
[[select]]
name = "wall"
box = [[-1, -1, -1], [1, 99, 1]]
[[select]]
name = "end"
box = [[39, -1, -1], [41, 99, 1]]
[[edit]]
name = "longer"
fixed = "wall"
[[edit.handle]]
name = "end"
translate = [{shift}, 0, 0]
[output]
mesh = "{out}"
vtp = "plate.vtp"
"""


def deck_text():
    """A plate of 4 by 2 elements."""
    nodes = "\n".join(f"{5 * j + i + 1}, {10 * i}., {10 * j}., 0." for j in range(3) for i in range(5))
    elements = "\n".join(
        f"{4 * j + i + 1}, {5 * j + i + 1}, {5 * j + i + 2}, {5 * j + i + 7}, {5 * j + i + 6}"
        for j in range(2) for i in range(4))
    return DECK.format(nodes=nodes, elements=elements)


def digest(path):
    return hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()


def without_times(report):
    """A report without measured times, whose keys end with "_s" or "seconds"."""
    if isinstance(report, dict):
        return {key: without_times(value) for key, value in report.items()
                if not key.endswith(("_s", "seconds"))}
    return [without_times(value) for value in report] if isinstance(report, list) else report


def state(folder, ignore_times=True):
    """{file name: contents} of a folder; the times are removed from the report. Temporary folders of a killed run may
    disappear meanwhile."""
    found = {}
    for file in sorted(pathlib.Path(root) / name for root, _, names in os.walk(folder) for name in names):
        if not file.is_file():
            continue
        try:
            text = file.read_bytes()
        except FileNotFoundError:
            if not str(file.relative_to(folder)).startswith("."):
                raise
            continue
        if file.name == "report.json" and ignore_times:
            text = json.dumps(without_times(json.loads(text)), sort_keys=True).encode()
        found[str(file.relative_to(folder))] = hashlib.sha256(text).hexdigest()
    return found


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="batten_files_"))
        self.write("curves.csv", RECTANGLE)
        self.write("scene.toml", SCENE.format(height=2, stem="shape"))
        self.write("deck.inp", deck_text())
        self.write("edit.toml", EDIT.format(deck="deck.inp", shift=8, out="longer.inp"))

    def tearDown(self):
        shutil.rmtree(self.folder, ignore_errors=True)

    def write(self, name, text):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        return path

    def run_batten(self, *words, prefix=(), **options):
        return subprocess.run([*prefix, ARGUMENTS.program, *map(str, words)], cwd=self.folder, env=ENVIRONMENT,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=120, **options)

    def succeeds(self, *words, **options):
        done = self.run_batten(*words, **options)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def is_refused(self, *words, about, **options):
        """The command ends with code 1 and a message, and changes no file."""
        before = state(self.folder, False)
        done = self.run_batten(*words, **options)
        self.assertEqual(done.returncode, 1, f"{words}: {done.stdout}{done.stderr}")
        self.assertIn(about, done.stderr)
        self.assertEqual(state(self.folder, False), before, f"{words} changed files")
        return done

    def is_clean(self, folder):
        """No temporary file was left."""
        hidden = [str(f) for f in pathlib.Path(folder).rglob(".*")]
        self.assertEqual(hidden, [])


class InputsAreKept(Case):
    def test_fair_does_not_replace_the_points(self):
        self.is_refused("fair", "curves.csv", "--out", "curves.csv", about="input file of this command")
        self.is_refused("fair", "curves.csv", "--out", "./../" + self.folder.name + "/curves.csv",
                        about="input file of this command")
        self.is_refused("fair", "curves.csv", "--out", "new.csv", "--report", "curves.csv",
                        about="input file of this command")
        self.succeeds("fair", "curves.csv", "--out", "curves.csv", "--in-place")

    def test_other_names_of_the_input_are_found(self):
        os.symlink("curves.csv", self.folder / "link.csv")
        self.is_refused("fair", "curves.csv", "--out", "link.csv", about="input file of this command")
        self.is_refused("fair", "link.csv", "--out", "curves.csv", about="input file of this command")
        os.link(self.folder / "curves.csv", self.folder / "hard.csv")
        self.is_refused("fair", "curves.csv", "--out", "hard.csv", about="input file of this command")
        os.symlink(".", self.folder / "here")
        self.is_refused("fair", "curves.csv", "--out", "here/curves.csv", about="input file of this command")

    def test_two_outputs_are_two_files(self):
        self.is_refused("fair", "curves.csv", "--out", "new.csv", "--report", "new.csv", about="two output files")
        self.write("scene.toml", SCENE.format(height=2, stem="shape").replace("shape.vtp", "./shape.step"))
        self.assertEqual(self.run_batten("run", "scene.toml", "--out", "out").returncode, 1)

    def test_scenes_do_not_replace_what_they_read(self):
        self.write("edit.toml", EDIT.format(deck="deck.inp", shift=8, out="deck.inp"))
        self.is_refused("deform", "edit.toml", "--out", ".", about="input file of this command")
        self.succeeds("deform", "edit.toml", "--out", "other")
        self.succeeds("deform", "edit.toml", "--out", ".", "--in-place")
        os.makedirs(self.folder / "out")
        os.rename(self.folder / "curves.csv", self.folder / "out/shape.vtp.csv")
        self.write("scene.toml", SCENE.format(height=2, stem="shape").replace("curves.csv", "out/link"))
        os.symlink("shape.vtp.csv", self.folder / "out/link")
        self.assertNotEqual(self.run_batten("run", "scene.toml", "--out", "out").returncode, 0)

    def test_scripts_keep_the_script_and_the_curves(self):
        self.write("script.txt", "open scene.toml\nsave script.txt\n")
        self.is_refused("run-script", "script.txt", about="input file of this command")
        self.write("script.txt", "open scene.toml\nsave curves.csv\n")
        self.is_refused("run-script", "script.txt", about="which this scene reads")
        self.write("script.txt", "open scene.toml\nsave scene.toml\nsave scene.toml\n")
        self.succeeds("run-script", "script.txt")
        self.write("script.txt", "open scene.toml\nexport a.vtp\nexport a.vtp\n")
        self.succeeds("run-script", "script.txt")

    def test_convert(self):
        self.is_refused("convert", "deck.inp", "deck.inp", about="input file")
        self.succeeds("convert", "curves.csv", "curves.dxf")
        self.is_refused("convert", "curves.dxf", "curves.dxf", about="input file")


SEQUENCE = """
name = "moving"
unit = "mm"
[sequence]
file = "{source}"
[[select]]
name = "wall"
box = [[-1, -1, -9], [1, 99, 9]]
[[select]]
name = "end"
box = [[39, -1, -9], [49, 99, 9]]
[[handle]]
name = "end"
[[operation]]
name = "longer"
type = "keyframes"
fixed = "wall"
[[operation.keyframe]]
frame = 2
handle = [{{ name = "end", translate = [4, 0, 0] }}]
[output]
frames = "{frames}"
"""

# (files read, file written, which is one of them, command). In the command and in the files that prepare() writes,
# {0} is the file written.
PAIRS = [
    ("curves", "curves.csv", "fair curves.csv --out {0}"),
    ("curves", "curves.csv", "fair curves.csv --out new.csv --picture {0}"),
    ("curves", "curves.csv", "fair curves.csv --out new.csv --report {0}"),
    ("curves", "a.curves", "run fair.toml --out ."),
    ("curves", "report.json", "fair report.json --out new.csv --report {0}"),
    ("curves", "report.json", "skin report.json --out ."),
    ("curves", "curves.step", "run scene.toml --out ."),
    ("curves", "curves.step", "skin {0} --out ."),
    ("curves", "curves.csv", "info curves.csv --picture {0}"),
    ("curves", "curves.csv", "view curves.csv --screenshot {0}"),
    ("curves", "curves.csv", "convert curves.csv {0}"),
    ("curves", "curves.dxf", "convert curves.dxf {0}"),
    ("curves", "curves.svg", "convert curves.svg {0}"),
    ("CAD file", "part.step", "convert part.step {0}"),
    ("CAD file", "part.step", "run scene.toml --out ."),
    ("target", "target.vtp", "run scene.toml --out ."),
    ("target", "part.step", "fit part.step --out ."),
    ("scene", "scene.toml", "sculpt scene.toml --out out --record {0}"),
    ("curves", "curves.csv", "sculpt scene.toml --out out --record {0}"),
    ("mesh", "deck.inp", "convert deck.inp {0}"),
    ("mesh", "deck.obj", "convert deck.obj {0}"),
    ("mesh", "deck.vtp", "convert deck.vtp {0}"),
    ("material file", "deck.mtl", "convert coloured.obj deck.obj"),
    ("mesh", "deck.inp", "deform edit.toml --out ."),
    ("included file", "nodes.inp", "deform edit.toml --out ."),
    ("mesh", "plate.vtp", "deform edit.toml --out ."),
    ("mesh", "deck.inp", "deform modes.toml --out ."),
    ("frames", "f_0001.obj", "sequence frames.toml --out ."),
    ("point cache", "cache.pc2", "sequence frames.toml --out ."),
    ("mesh of the cache", "cache.obj", "sequence frames.toml --out ."),
    ("script", "script.txt", "run-script script.txt"),
    ("curves", "curves.csv", "run-script script.txt"),
]


class EveryPair(Case):
    """No command replaces a file that it reads, whichever of its files it is."""

    def prepare(self, read, name, command):
        plate = EDIT.format(deck=name, shift=8, out=name)
        if name.endswith((".step", ".vtp", ".dxf", ".svg")) and read == "curves":
            self.succeeds("convert", "curves.csv", name)
            stem = pathlib.Path(name).stem
            text = SCENE.format(height=2, stem=stem).replace('name = "outline"\nfile = "curves.csv"', f'file = "{name}"')
            self.write("scene.toml", text.replace("[[curve]]", "[[curves]]"))
        if name == "a.curves":
            self.succeeds("convert", "curves.csv", name)
        if name == "report.json":
            points = [[0, 0, 0], [100, 0, 0], [100, 80, 0], [0, 80, 0], [0, 0, 0]]
            pieces = [{"id": i, "ctrl_pts": [[a, [(2 * x + y) / 3 for x, y in zip(a, b)],
                                              [(x + 2 * y) / 3 for x, y in zip(a, b)], b]]}
                      for i, (a, b) in enumerate(zip(points, points[1:]))]
            self.write(name, json.dumps({"segments": pieces,
                                         "strokes": [{"id": i, "segments": [i]} for i in range(4)]}))
        if read in ("CAD file", "target"):
            self.succeeds("run", "scene.toml", "--out", "made")
            shutil.copy(self.folder / ("made/shape" + pathlib.Path(name).suffix), self.folder / name)
            stem = pathlib.Path(name).stem
            added = (f'[compare]\nfile = "{name}"\n' if read == "CAD file" else
                     f'[[target]]\nfile = "{name}"\n')
            self.write("scene.toml", SCENE.format(height=2, stem=stem) + added)
            if read == "target":
                text = (self.folder / "scene.toml").read_text()
                load, output = text.index("[[load]]"), text.index("[output]")
                self.write("scene.toml", text[:load] + text[output:])
        if name == "deck.obj" or name == "deck.vtp" or name == "plate.vtp" or name == "f_0001.obj":
            self.succeeds("convert", "deck.inp", name)
        if name == "plate.vtp":
            self.write("edit.toml", EDIT.format(deck=name, shift=8, out="other.vtp"))
        if name == "deck.inp":
            self.write("edit.toml", plate)
        if name == "deck.mtl":
            self.write(name, "newmtl red\nKd 1 0 0\n")
            self.write("coloured.obj", "mtllib deck.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n")
        if name == "nodes.inp":
            text = deck_text()
            nodes, elements = text[:text.index("*ELEMENT")], text[text.index("*ELEMENT"):]
            self.write(name, nodes)
            self.write("deck.inp", f"*INCLUDE, INPUT={name}\n" + elements)
            self.write("edit.toml", EDIT.format(deck="deck.inp", shift=8, out="longer.inp"))
        self.write("modes.toml", EDIT.format(deck="deck.inp", shift=8, out="longer.inp") +
                   '[modes]\nthickness = 1\nyoung = 1\npoisson = 0.3\ndensity = 1\ncount = 1\n'
                   'before = "deck.inp"\nafter = "after.inp"\n')
        self.write("fair.toml", 'unit = "mm"\nname = "fair"\n[[curve]]\nname = "a"\nfile = "a.curves"\n'
                   '[[fair]]\n[output]\ncurves = "a.curves"\n')
        if "sequence" in command:
            self.succeeds("convert", "deck.inp", "f_0001.obj")
            shutil.copy(self.folder / "f_0001.obj", self.folder / "f_0002.obj")
            self.write("frames.toml", SEQUENCE.format(source="f_*.obj", frames="cache.pc2"))
            if name.startswith("cache"):
                self.succeeds("sequence", "frames.toml", "--out", ".")
                os.remove(self.folder / "report.json")
                self.write("frames.toml", SEQUENCE.format(source="cache.pc2", frames="cache.pc2"))
            else:
                self.write("frames.toml", SEQUENCE.format(source="f_*.obj", frames="f_*.obj"))
        if command == "run-script script.txt":
            self.write("script.txt", f"open scene.toml\nsave {name}\n")

    def test_every_pair(self):
        for read, name, command in PAIRS:
            with self.subTest(command=command, reads=read, writes=name):
                self.tearDown()
                self.setUp()
                self.prepare(read, name, command)
                before = digest(self.folder / name)
                done = self.run_batten(*command.format(name).split())
                if ARGUMENTS.table:
                    print(f"| {read} | `{command.format(name)}` | {name} | {done.returncode} | "
                          f"{(done.stderr.strip().splitlines() or [''])[-1].replace('batten: ', '')} |")
                self.assertEqual(digest(self.folder / name), before, f"{done.stdout}{done.stderr}")
                self.assertEqual(done.returncode, 1, f"{done.stdout}{done.stderr}")
                self.assertRegex(done.stderr, "input file of this command|no display|a file of the deck that was read|"
                                 "not written by batten sequence|which this scene reads")
                self.is_clean(self.folder)


class ExistingFiles(Case):
    def mode(self, name):
        return stat.S_IMODE(os.stat(self.folder / name).st_mode)

    def test_permissions_are_kept(self):
        for mode in (0o600, 0o640, 0o664):
            self.write("new.csv", "old").chmod(mode)
            self.succeeds("fair", "curves.csv", "--out", "new.csv")
            self.assertEqual(self.mode("new.csv"), mode)
            self.write("out/shape.step", "old").chmod(mode)
            self.succeeds("run", "scene.toml", "--out", "out")
            self.assertEqual(self.mode("out/shape.step"), mode)
        self.is_clean(self.folder)

    def test_write_protected_files_are_kept(self):
        self.write("new.csv", "old").chmod(0o444)
        self.is_refused("fair", "curves.csv", "--out", "new.csv", about="write-protected")
        self.write("out/shape.step", "old").chmod(0o444)
        self.is_refused("run", "scene.toml", "--out", "out", about="write-protected")

    def test_symbolic_links_are_followed(self):
        self.write("elsewhere/real.csv", "old")
        os.symlink("elsewhere/real.csv", self.folder / "new.csv")
        self.succeeds("fair", "curves.csv", "--out", "new.csv")
        self.assertTrue((self.folder / "new.csv").is_symlink())
        self.assertNotEqual((self.folder / "elsewhere/real.csv").read_text(), "old")
        os.makedirs(self.folder / "out")
        os.symlink("../elsewhere/not_yet.step", self.folder / "out/shape.step")
        self.succeeds("run", "scene.toml", "--out", "out")
        self.assertTrue((self.folder / "out/shape.step").is_symlink())
        self.assertTrue((self.folder / "elsewhere/not_yet.step").is_file())
        os.symlink("loop.csv", self.folder / "loop.csv")
        self.is_refused("fair", "curves.csv", "--out", "loop.csv", about="symbolic links")

    def test_links_to_another_disk_are_followed(self):
        other = pathlib.Path(tempfile.mkdtemp(dir="/dev/shm"))
        try:
            os.makedirs(self.folder / "out")
            os.symlink(other / "real.step", self.folder / "out/shape.step")
            self.succeeds("run", "scene.toml", "--out", "out")
            self.assertIn(b"ISO-10303-21", (other / "real.step").read_bytes())
            self.assertEqual(os.listdir(other), ["real.step"])
        finally:
            shutil.rmtree(other)

    def test_hard_links_are_not_broken(self):
        self.write("new.csv", "old")
        os.link(self.folder / "new.csv", self.folder / "same.csv")
        self.is_refused("fair", "curves.csv", "--out", "new.csv", about="hard links")
        self.write("out/shape.step", "old")
        os.link(self.folder / "out/shape.step", self.folder / "same.step")
        self.is_refused("run", "scene.toml", "--out", "out", about="hard links")

    def test_a_name_that_cannot_be_written_changes_nothing(self):
        self.succeeds("run", "scene.toml", "--out", "out")
        self.write("scene.toml", SCENE.format(height=5, stem="shape"))
        os.remove(self.folder / "out/shape.vtp")
        os.makedirs(self.folder / "out/shape.vtp")
        self.is_refused("run", "scene.toml", "--out", "out", about="found a folder of this name")


class KilledRuns(Case):
    """A kill in the commit leaves the old files or the new files."""

    def kill_at_the_commit(self, words, out, delay, in_the_move):
        child = subprocess.Popen([ARGUMENTS.program, *words], cwd=self.folder, env=ENVIRONMENT,
                                 stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        lock, report = str(out / ".batten-lock"), str(out / "report.json")
        end = time.monotonic() + 60
        while (os.path.exists(report) if in_the_move else not os.path.exists(lock)) and \
                child.poll() is None and time.monotonic() < end:
            pass
        until = time.perf_counter() + delay
        while time.perf_counter() < until:
            pass
        child.kill()
        return child.wait() == -signal.SIGKILL

    def check(self, words, change, out):
        change(0)
        self.succeeds(*words)
        states = [None, None]
        for k in (1, 0):
            change(k)
            self.succeeds(*words)
            states[k] = state(out)
        self.assertNotEqual(states[0], states[1])
        now, killed, new = 0, 0, 0
        for kill in range(ARGUMENTS.kills):
            change(1 - now)
            # Every other kill when the old report has been removed, the others some milliseconds after the lock.
            in_the_move = kill % 2 == 0
            delay = (0.0002 if in_the_move else 0.02) * (kill // 2) / ARGUMENTS.kills
            killed += self.kill_at_the_commit(words, out, delay, in_the_move)
            found = {name: text for name, text in state(out).items() if not name.startswith(".")}
            self.assertIn(found, states, f"kill {kill}: a mixture: " + str({
                name: [k for k in (0, 1) if states[k].get(name) == text] for name, text in found.items()}))
            new += found == states[1 - now]
            now = states.index(found)
        print(f"{words[0]}: {ARGUMENTS.kills} kills, {killed} before the end; {new} all new, "
              f"{ARGUMENTS.kills - new} all old")
        change(now)
        self.succeeds(*words)  # removes what the killed runs have left
        self.is_clean(out)

    def test_run(self):
        def change(k):
            self.write("scene.toml", SCENE.format(height=(2, 5)[k], stem="shape"))
        self.check(["run", "scene.toml", "--out", "out"], change, self.folder / "out")

    def test_deform(self):
        def change(k):
            self.write("edit.toml", EDIT.format(deck="deck.inp", shift=(8, 9)[k], out="longer.inp"))
        self.check(["deform", "edit.toml", "--out", "out"], change, self.folder / "out")


def namespaces():
    """The command that starts a program as process 1 of its own namespace; empty if that is not permitted."""
    words = ["unshare", "--mount", "--pid", "--fork", "--mount-proc"]
    try:
        subprocess.run([*words, "true"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    except (OSError, subprocess.CalledProcessError):
        return []
    return words


class RunsThatMeet(Case):
    def test_same_process_id(self):
        prefix = namespaces()
        if not prefix:
            self.skipTest("unshare is not permitted")
        states = []
        for k, height in enumerate((2, 5)):
            self.write(f"scene{k}.toml", SCENE.format(height=height, stem="shape"))
            self.succeeds("run", f"scene{k}.toml", "--out", "out")
            states.append({n: s for n, s in state(self.folder / "out").items()})
        whole = [0, 0]
        for _ in range(ARGUMENTS.pairs):
            both = [subprocess.Popen([*prefix, ARGUMENTS.program, "run", f"scene{k}.toml", "--out", "out", "--quiet"],
                                     cwd=self.folder, env=ENVIRONMENT) for k in (0, 1)]
            self.assertEqual([child.wait() for child in both], [0, 0])
            found = state(self.folder / "out")
            self.assertIn(found, states)
            whole[states.index(found)] += 1
        print(f"{ARGUMENTS.pairs} pairs with process id 1: {whole[0]} and {whole[1]} whole sets")
        self.is_clean(self.folder / "out")

    def test_leftovers(self):
        """Leftovers of a dead run are removed, those of other systems only after a week."""
        out = self.folder / "out"
        self.succeeds("run", "scene.toml", "--out", "out")
        name = next(n for n in self.names_of_a_live_run(out))
        system = name.split(".")[-1].split("-")[0]
        dead, foreign, old = (out / f".batten.{s}-{d * 16}" for s, d in
                              ((system, "1"), ("0" * 8, "2"), ("0" * 8, "3")))
        for folder in (dead, foreign, old):
            folder.mkdir()
            (folder / ".lock").touch()
            (folder / "shape.step").write_text("half")
        week = time.time() - 8 * 24 * 3600
        os.utime(old, (week, week))
        self.succeeds("run", "scene.toml", "--out", "out")
        self.assertEqual([dead.exists(), foreign.exists(), old.exists()], [False, True, False])

    def names_of_a_live_run(self, out):
        child = subprocess.Popen([ARGUMENTS.program, "run", "scene.toml", "--out", "out", "--quiet"], cwd=self.folder,
                                 env=ENVIRONMENT)
        names = set()
        while child.poll() is None:
            names |= {n for n in os.listdir(out) if n.startswith(".batten.")}
        return names


class FullDisks(Case):
    def test_small_disk(self):
        if not namespaces():
            self.skipTest("unshare is not permitted")
        os.makedirs(self.folder / "disk")
        self.succeeds("run", "scene.toml", "--out", ".")
        for words in ("convert shape.step disk/a.glb", "convert shape.step disk/a.igs", "convert shape.step disk/a.brep",
                      "run scene.toml --out disk/out", "fair curves.csv --out disk/new.csv",
                      "deform edit.toml --out disk/out", "convert deck.inp disk/a.vtu",
                      "convert deck.inp disk/a.stl", "convert deck.inp disk/a.obj",
                      "convert deck.inp disk/a.glb --from-unit mm", "convert deck.inp disk/a.3mf --from-unit mm",
                      "convert curves.csv disk/a.dxf", "convert curves.csv disk/a.svg"):
            script = ("mount -t tmpfs -o size=16k,nr_inodes=40 none disk || exit 77; touch disk/old; "
                      "head -c 16384 /dev/zero > disk/fill 2>/dev/null; \"$0\" " + words +
                      "; echo code $?; ls -A disk")
            done = subprocess.run(["unshare", "--mount", "sh", "-c", script, ARGUMENTS.program], cwd=self.folder,
                                  env=ENVIRONMENT, stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, text=True, timeout=120)
            if done.returncode == 77:
                self.skipTest("disks may not be mounted")
            self.assertIn("No space left on device", done.stderr, words)
            self.assertIn("code 1\n", done.stdout, words + done.stderr)
            self.assertEqual(done.stdout.split("code 1\n")[1].split(), ["fill", "old"], words)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("--kills", type=int, default=8)
    parser.add_argument("--pairs", type=int, default=6)
    parser.add_argument("--table", action="store_true")
    known, rest = parser.parse_known_args(namespace=ARGUMENTS)
    ARGUMENTS.program = os.path.abspath(ARGUMENTS.program)
    unittest.main(argv=[sys.argv[0], *rest])
