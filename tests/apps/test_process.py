#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""How the program ends: under limits of the system, with closed or full streams, after signals, with names that
contain control characters.

    tests/apps/test_process.py BATTEN

Needs no display. The test without threads is skipped if it may not run the program as another user.
"""
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = ""
MEGABYTE = 1 << 20
NOBODY = 65534
CURVES = "0,0,0\n100,0,0\n100,80,0\n0,80,0\n0,0,0\n"
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
value = 0.1
[output]
vtp = "shape.vtp"
"""
# Runs for minutes: time steps of a motion.
LONG = ("sculpt", "scene.toml", "--out", "long", "--time", "100", "--dt", "0.001")
NAMES = """
name = "n\\u001b[31m\\nbatten: forged"
unit = "mm"
[mesh]
edge_length = 25
[[curve]]
name = "outline\\u001b]0;title\\u0007\\nwarning: forged"
file = "curves.csv"
[[load]]
name = "swell\\u009b31m\\u202e\\ncheck failed: forged"
type = "pressure"
value = 0.1
[output]
vtp = "shape.vtp"
"""


def limited(kind, soft, hard=None):
    def apply():
        resource.setrlimit(kind, (soft, soft if hard is None else hard))
    return apply


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="batten-process-"))
        self.addCleanup(shutil.rmtree, self.folder)
        (self.folder / "curves.csv").write_text(CURVES)
        (self.folder / "scene.toml").write_text(SCENE)

    def start(self, *words, before=None, **streams):
        environment = {**os.environ, "BATTEN_XVFB": ""}
        environment.pop("DISPLAY", None)
        streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **streams}
        return subprocess.Popen([PROGRAM, *words], cwd=self.folder, env=environment, preexec_fn=before,
                                stdin=subprocess.DEVNULL, **streams)

    def run_program(self, *words, before=None, **streams):
        process = self.start(*words, before=before, **streams)
        try:
            out, err = process.communicate(timeout=60)
        finally:
            process.kill()
        text = (err or b"").decode()
        self.assertGreaterEqual(process.returncode, 0, f"{words}: ended by a signal: {text}")
        self.assertNotRegex(text, "terminate called|batten: unexpected|OpenBLAS", words)
        self.assertEqual([p for p in self.folder.rglob(".*")], [], f"{words}: temporary files")
        return process.returncode, (out or b"").decode(), text

    def refused(self, code, message, *words, **how):
        found, _, text = self.run_program(*words, **how)
        self.assertIn(message, text, words)
        self.assertEqual(found, code, text)


class Limits(Case):
    def test_memory(self):
        self.assertEqual(self.run_program("skin", "curves.csv", "--out", "given")[0], 0)
        for megabytes in (150, 200, 220, 235, 260, 400):
            before = limited(resource.RLIMIT_AS, megabytes * MEGABYTE)
            for words in (("--version",), ("run", "scene.toml", "--out", "out"), ("info", "given/curves.step"),
                          ("convert", "given/curves.vtp", "a.stl")):
                code, _, text = self.run_program(*words, before=before)
                self.assertIn(code, (0, 1, 3), text)
                self.assertTrue(code == 0 or text, words)
                self.assertNotIn("damaged", text, words)

    def test_threads(self):
        if os.geteuid() != 0:
            self.skipTest("not permitted to run the program as another user")
        self.folder.chmod(0o777)

        def with_threads(count):
            def apply():
                resource.setrlimit(resource.RLIMIT_NPROC, (count, count))
                os.setgroups([])
                os.setresuid(NOBODY, NOBODY, NOBODY)
            return apply
        try:
            self.assertEqual(self.run_program("--version", before=with_threads(1))[0], 0)
        except PermissionError:
            self.skipTest("the program is not accessible to other users")
        self.refused(3, "cannot create a thread", "run", "scene.toml", "--out", "none", before=with_threads(1))
        files = []
        for count in (2, 3, 1000):
            code, _, text = self.run_program("run", "scene.toml", "--out", str(count), before=with_threads(count))
            if code == 3 and count < 1000:  # the other user has other processes
                self.assertIn("cannot create a", text)
                continue
            self.assertEqual(code, 0, text)
            files.append((self.folder / str(count) / "shape.vtp").read_bytes())
        self.assertEqual(len(set(files)), 1)

    def test_open_files(self):
        run = ("run", "scene.toml", "--out", "out")
        for count in (8, 20):
            self.refused(3, "open files", *run, before=limited(resource.RLIMIT_NOFILE, count))
        self.assertEqual(self.run_program(*run, before=limited(resource.RLIMIT_NOFILE, 32))[0], 0)
        self.assertEqual(self.run_program(*run, before=limited(resource.RLIMIT_NOFILE, 8, 64))[0], 0)

    def test_stack(self):
        run = ("run", "scene.toml", "--out", "out")
        for kilobytes in (64, 256):
            before = limited(resource.RLIMIT_STACK, kilobytes << 10)
            self.refused(3, "the stack", *run, before=before)
            before = limited(resource.RLIMIT_STACK, kilobytes << 10, 8 << 20)
            self.assertEqual(self.run_program(*run, before=before)[0], 0)
        self.assertEqual(self.run_program(*run, before=limited(resource.RLIMIT_STACK, 1 << 20))[0], 0)

    def test_processor_time(self):
        self.refused(3, "the limit of the processor time is reached", *LONG, before=limited(resource.RLIMIT_CPU, 1))
        self.assertFalse((self.folder / "long").exists())

    def test_file_size(self):
        before = limited(resource.RLIMIT_FSIZE, 1000)
        self.refused(1, "shape.vtp: cannot write this file: File too large", "run", "scene.toml", "--out", "out",
                     before=before)


class Streams(Case):
    def setUp(self):
        super().setUp()
        self.assertEqual(self.run_program("run", "scene.toml", "--out", "given")[0], 0)

    def test_closed(self):
        text = self.run_program("info", "given/shape.vtp")[1]
        self.assertIn("faces", text)
        for closed in ((0,), (1,), (2,), (0, 1), (0, 2), (1, 2), (0, 1, 2)):
            def before(closed=closed):
                for number in closed:
                    os.close(number)
            # The program reads VTK files in another process, through a pipe.
            code, out, err = self.run_program("info", "given/shape.vtp", before=before)
            self.assertEqual(code, 1 if 1 in closed else 0, (closed, err))
            if 1 not in closed:
                self.assertEqual(out, text)
            elif 2 not in closed:
                self.assertIn("cannot write to the standard output: Bad file descriptor", err)

    def test_full(self):
        (self.folder / "s.batten").write_text('open "scene.toml"\nsave "saved.toml"\n')
        for words in (("--help",), ("run", "--help"), ("--version",), ("info", "given/shape.vtp"),
                      ("run", "scene.toml", "--out", "out"), ("run-script", "s.batten")):
            with open("/dev/full", "wb") as full:
                self.refused(1, "cannot write to the standard output: No space left on device", *words, stdout=full)
        with open("/dev/full", "wb") as full:  # nothing to write
            self.assertEqual(self.run_program("run", "scene.toml", "--out", "out", "--quiet", stdout=full)[0], 0)
            self.assertEqual(self.run_program("info", "none.vtp", stderr=full)[0], 1)

    def test_broken_pipe(self):
        reading, writing = os.pipe()
        os.close(reading)
        self.refused(1, "cannot write to the standard output: Broken pipe", "info", "given/shape.vtp", stdout=writing)
        os.close(writing)


class Signals(Case):
    def end_by(self, number, before=None):
        process = self.start(*LONG, before=before)
        try:
            while not (self.folder / "long").exists():
                self.assertIsNone(process.poll())
                time.sleep(0.01)
            process.send_signal(number)
            if before:
                time.sleep(0.5)
                self.assertIsNone(process.poll())
                process.send_signal(signal.SIGTERM)
            _, err = process.communicate(timeout=60)
        finally:
            process.kill()
        self.assertEqual((process.returncode, err.decode()), (130, "batten: cancelled\n"))
        self.assertFalse((self.folder / "long").exists())

    def test_cancelled(self):
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            self.end_by(number)

    def test_ignored(self):  # as nohup and background jobs of scripts do
        for number in (signal.SIGHUP, signal.SIGINT):
            self.end_by(number, before=lambda number=number: signal.signal(number, signal.SIG_IGN))


class Names(Case):
    def check(self, *words):
        code, out, err = self.run_program(*words)
        for text in (out, err):
            self.assertNotRegex(text, "[\x00-\x09\x0b-\x1f\x7f-\x9f\u202e]")
            self.assertIsNone(re.search("^(batten|warning|check failed): forged", text, re.MULTILINE), text)
        return code, out + err

    def test_scenes(self):
        (self.folder / "names.toml").write_text(NAMES)
        _, text = self.check("run", "names.toml", "--out", "out")
        self.assertIn("n\\x1B[31m\\nbatten: forged", text)
        self.assertIn("\\x1B]0;title\\x07\\nwarning", self.check("info", "names.toml")[1])
        self.assertIn("swell\\u009B31m\\u202E\\n", self.check("run", "names.toml", "--out", "out", "--set", "a=1")[1])

    def test_files(self):
        name = "b\x1b[31m\nbatten: forged.csv"
        self.check("info", name)
        (self.folder / name).write_text(CURVES)
        for words in (("info", name), ("skin", name, "--out", "a"), ("convert", name, name + ".obj"),
                      ("skin", "curves.csv", "--out", "o\nbatten: forged")):
            self.assertEqual(self.check(*words)[0], 0)
        self.assertIn("\\xFF", self.check("info", os.fsdecode(b"x\xff.csv"))[1])

    def test_command_line(self):
        for words in (("x\x1b\nbatten: forged",), ("run", "--x\x1b\nbatten: forged"),
                      ("run", "scene.toml", "--out", "out", "--threads", "\x1b\nbatten: forged"),
                      ("run", "scene.toml", "--out", "out", "--set", "\x1b\nbatten: forged=1")):
            self.assertEqual(self.check(*words)[0], 1)

    def test_decks(self):
        deck = ("*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n*ELEMENT,TYPE=S3,ELSET=A\x1b[31mB\n1,1,2,3\n"
                "*NSET,NSET=Q\x9bq\n1,2\n")
        (self.folder / "deck.inp").write_bytes(deck.encode("latin-1"))
        self.assertIn("Q\\x9Bq", self.check("info", "deck.inp")[1])


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv[1])
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
