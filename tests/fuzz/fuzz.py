#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Runs the batten program on damaged files and reports unexpected results.

fuzz.py SERVER TARGET SECONDS [--runs N] [--first K] [--keep FOLDER] [--jobs N]
        [--slow SECONDS] [--seeds FOLDER …] [--faults]

SERVER is the executable of server.cpp. TARGET is one of the folders in seeds/, or "all" (SECONDS are
then per target); the FOLDERs contain additional seeds. Run K of a target always produces the same
file: a damaged seed or, sometimes, a damaged file to which it refers.

Findings are: termination by a signal, an exit code outside the list in docs/conventions.md, an
unexpected error, more than 2 GB, a report that is not valid JSON or contains numbers that are not
finite, output files after a rejection, remaining hidden files, and a changed input file. "sketches" have errors of hand
drawings: strokes are removed, moved, duplicated, split and jittered; inverted faces that are not
reported, and a missing model, are findings there. A run of more than 10 s is asked to stop. It is a
finding unless it stops within 2 s, with exit code 130 and no remaining files; otherwise it is
counted and listed as long, since the input may require much work. Files of findings and of long
runs are kept. The exit code is 1 after findings. Needs Python 3 only.

--faults: half of the runs have a fault of the system (server.cpp): closed or full output, limits of
memory, open files, file size, stack and threads, a full disk. Then exit code 0 is a finding if the
text could not be written. The counts of exit codes for each kind of fault are printed at the end.
"""
import argparse
import collections
import json
import math
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HERE = Path(__file__).resolve().parent
MEMORY, MOST_MEGABYTES = "2", 2048  # memory limit of a run, GB; finding, MB
EXIT_CODES = {0, 1, 2, 3, 4, 130}

# The command for a file of each target; "@" is the file, "OUT" a folder that does not exist yet.
COMMANDS = {
    "lines": [["info", "@"], ["fair", "@", "--out", "OUT.csv"], ["skin", "@", "--out", "OUT"],
              ["fair", "@", "--out", "@"], ["convert", "@", "OUT.dxf"], ["convert", "@", "@"]],
    "cad": [["info", "@"], ["fair", "@", "--out", "OUT.csv"],
            ["skin", "@", "--out", "OUT"], ["convert", "@", "OUT.iges"],
            ["convert", "@", "OUT.step"], ["convert", "@", "OUT.obj"], ["fit", "@", "--out", "OUT"]],
    "drawings": [["info", "@"], ["fair", "@", "--out", "OUT.csv"],
                 ["skin", "@", "--out", "OUT"]],
    "meshes": [["info", "@"], ["convert", "@", "OUT.vtp"], ["fit", "@", "--out", "OUT"],
               ["convert", "@", "OUT.glb", "--from-unit", "mm"],
               ["convert", "@", "OUT.3mf", "--from-unit", "mm"], ["convert", "@", "@"]],
    "networks": [["skin", "@", "--unit", "m", "--out", "OUT"]],
    "sketches": [["skin", "@", "--unit", "m", "--out", "OUT"]],
    "scenes": [["run", "@", "--out", "OUT"], ["info", "@"]],
    "edits": [["deform", "@", "--out", "OUT"], ["info", "@"]],
    "sculpting": [["sculpt", "@", "--out", "OUT"]],
    "logs": [["sculpt", "scene.toml", "--replay", "@", "--out", "OUT"],
             ["sculpt", "scene.toml", "--replay", "@", "--out", "OUT", "--record", "@"]],
    "stress": [["stress", "@", "--out", "OUT"]],
    "sequences": [["sequence", "@", "--out", "OUT"], ["info", "@"]],
    "scripts": [["run-script", "@"]],
}
# Extensions of further seeds.
ENDINGS = {
    "lines": {".csv", ".txt", ".dat", ".xyz", ".json", ".curves"},
    "cad": {".step", ".stp", ".igs", ".iges", ".brep"},
    "drawings": {".dxf", ".svg"},
    "meshes": {".obj", ".off", ".ply", ".stl", ".bdf", ".dat", ".inp", ".k", ".rad", ".vtp", ".vtu"},
    "networks": {".csv", ".txt", ".json", ".curves"},
    "sketches": {".json"},
    "scenes": {".toml"},
    "edits": {".toml"},
    "sculpting": {".toml"},
    "logs": set(),
    "stress": {".toml"},
    "sequences": {".toml"},
    "scripts": set(),
}
# Faults of the system, see server.cpp. The probability of each value is the same.
FAULTS = {
    "closed": ["0", "1", "2", "01", "12", "012"],
    "full": ["1", "2"],
    "memory": ["5", "20", "50", "100", "200", "400", "800"],
    "files": ["3", "4", "5", "6", "8", "12", "20"],
    "size": ["0", "100", "1000", "4096", "20000"],
    "stack": ["64", "128", "256", "512", "1024"],
    "threads": ["1", "2", "3", "5"],
    "disk": ["0", "4", "8", "16", "40"],
}
MOST_BYTES = 1 << 20  # of a further seed including the files beside it
NUMBERS = [b"0", b"-1", b"1", b"1e308", b"-1e308", b"1e-320", b"nan", b"inf", b"-inf", b"1e9",
           b"4294967296", b"2147483648", b"-2147483649", b"9223372036854775807", b"65536",
           b"1e-9", b"1e400", b"0x10", b"1,5", b"--3", b""]
NOT_FINITE = {  # by extension; a name may be "inf"
    ".csv": re.compile(rb"(?i),[-+]?(?:nan|inf)[\s,]"),
    ".obj": re.compile(rb"(?i) [-+]?(?:nan|inf)\s"),
    ".inp": re.compile(rb"(?i),\s*[-+]?(?:nan|inf)[\s,]"),
    ".step": re.compile(rb"(?i)[(,][-+]?(?:nan|inf)[,)]"),
}
LONG = "long"  # a run that stopped on request
NUMBER = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")


def cut(data, rng, _):
    return data[:rng.randrange(len(data) + 1)]


def flip(data, rng, _):
    changed = bytearray(data)
    for _ in range(rng.choice([1, 1, 2, 5, 20])):
        changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
    return bytes(changed)


def set_bytes(data, rng, _):
    changed = bytearray(data)
    at = rng.randrange(len(changed))
    for i in range(at, min(len(changed), at + rng.choice([1, 2, 4, 8]))):
        changed[i] = rng.choice([0, 255, 127, 128, ord("-"), ord("9"), ord("\n"), rng.randrange(256)])
    return bytes(changed)


def number(data, rng, _):
    places = list(NUMBER.finditer(data))
    for _ in range(rng.choice([1, 1, 1, 3])):
        if places:
            place = rng.choice(places)
            data = data[:place.start()] + rng.choice(NUMBERS) + data[place.end():]
            places = list(NUMBER.finditer(data))
    return data


def other_number(data, rng, _):
    """An unusual number that the format allows: it is read and leads to unusual computations."""
    places = list(NUMBER.finditer(data))
    for place in sorted(rng.sample(places, min(len(places), rng.choice([1, 1, 2, 5]))),
                        key=lambda p: -p.start()):
        if b"." in place.group() or b"e" in place.group().lower():
            value = float(place.group()) * rng.choice([-1, 0, 0.5, 2, 10, 1e3, 1e-3, 1 + 1e-9, 1e9])
            value += rng.choice([0, 0, 1e-6, 1])
            text = f"{value:.9f}" if abs(value) < 1e6 else f"{value:.9e}"
        else:
            text = str(max(0, int(place.group()) + rng.choice([-1, 1, 2, 10])))
        data = data[:place.start()] + text.encode() + data[place.end():]
    return data


def part(data, rng):
    a, b = sorted(rng.randrange(len(data) + 1) for _ in range(2))
    return (a, min(b, a + rng.choice([4, 40, 400, 4000])))


def drop(data, rng, _):
    a, b = part(data, rng)
    return data[:a] + data[b:]


def double(data, rng, _):
    a, b = part(data, rng)
    return data[:b] + data[a:b] * rng.choice([1, 1, 10, 1000]) + data[b:]


def lines(data, rng, _):
    rows = data.split(b"\n")
    for _ in range(rng.choice([1, 2, 4])):
        i, j = rng.randrange(len(rows)), rng.randrange(len(rows))
        kind = rng.randrange(3)
        if kind == 0:
            rows[i], rows[j] = rows[j], rows[i]
        elif kind == 1:
            rows.insert(i, rows[j])
        elif len(rows) > 1:
            del rows[i]
    return b"\n".join(rows)


def nest(data, rng, _):
    at = rng.randrange(len(data) + 1)
    what = rng.choice([b"[", b"{", b"(", b"[[", b"a.", b"<g>", b'{"a":', b"'", b'"'])
    return data[:at] + what * rng.choice([3, 100, 100000]) + data[at:]


def splice(data, rng, others):
    other = rng.choice(others)
    return data[:rng.randrange(len(data) + 1)] + other[rng.randrange(len(other) + 1):]


def sketched(data, rng):
    """The strokes of a sketch graph with errors of hand drawings."""
    graph = json.loads(data)
    segments = {s["id"]: s for s in graph["segments"]}
    points = [p for s in segments.values() for piece in s["ctrl_pts"] for p in piece]
    size = math.dist([min(c) for c in zip(*points)], [max(c) for c in zip(*points)])

    def by(length):
        way = [rng.gauss(0, 1) for _ in range(3)]
        return [length * w / (math.hypot(*way) or 1) for w in way]

    def moved(segment, shift):
        return {**segment, "ctrl_pts": [[[x + d for x, d in zip(p, shift(tuple(p)))] for p in piece]
                                        for piece in segment["ctrl_pts"]]}

    for _ in range(rng.choice([1, 2, 4, 8])):
        kind = rng.randrange(5)
        stroke = rng.choice(graph["strokes"])
        ids = stroke["segments"]
        if kind == 0 and len(graph["strokes"]) > 1:
            graph["strokes"].remove(stroke)
        elif kind == 1:
            whole = by(size * rng.uniform(0.002, 0.03))
            for i in ids:
                segments[i] = moved(segments[i], lambda _: whole)
        elif kind == 2:
            length, places = size * rng.uniform(0.0005, 0.003), {}
            for i in ids:
                segments[i] = moved(segments[i], lambda p: places.setdefault(p, by(length)))
        elif kind == 3:
            whole, first = by(size * rng.uniform(0.0005, 0.01)), max(segments) + 1
            for k, i in enumerate(ids):
                segments[first + k] = {**moved(segments[i], lambda _: whole), "id": first + k}
            graph["strokes"].append({"id": max(s["id"] for s in graph["strokes"]) + 1,
                                     "segments": list(range(first, first + len(ids)))})
        elif len(ids) > 1:
            at = rng.randrange(1, len(ids))
            graph["strokes"].append({"id": max(s["id"] for s in graph["strokes"]) + 1,
                                     "segments": ids[at:]})
            stroke["segments"] = ids[:at]
    used = {i for s in graph["strokes"] for i in s["segments"]}
    return json.dumps({"segments": [s for i, s in segments.items() if i in used],
                       "strokes": graph["strokes"]}).encode()


GENTLE = [other_number, other_number, other_number, number, lines]
MUTATIONS = [cut, flip, set_bytes, number, number, number, drop, double, lines, nest, splice]


def finite(value):
    if isinstance(value, float):
        return math.isfinite(value)
    if isinstance(value, dict):
        return all(finite(v) for v in value.values())
    if isinstance(value, list):
        return all(finite(v) for v in value)
    return True


def not_named(report):
    """An inverted face that no defect reports."""
    said = {name for defect in report["defects"] for name in defect["faces"]}
    for face in report.get("faces", []):
        if face["skinned"] and not face["min_jacobian_ratio"] > 0 and face["name"] not in said:
            return face["name"]
    return ""


class Server:
    """The program in server.cpp, one per thread."""

    def __init__(self, path):
        self.process = subprocess.Popen([path], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                        text=True)

    def run(self, command, folder, fault="-"):
        """Exit code (negative: a signal), output, seconds, megabytes."""
        print("\t".join([str(folder), fault, *command]), file=self.process.stdin, flush=True)
        code, seconds, megabytes = self.process.stdout.readline().split()
        text = (folder / "printed").read_bytes()[:100000].decode("utf-8", "replace")
        return int(code), text, float(seconds), float(megabytes)


def not_finite(out):
    """A text file of results that contains nan or inf in place of a number."""
    for path in [out] if out.is_file() else sorted(out.rglob("*")):
        if path.suffix in NOT_FINITE and NOT_FINITE[path.suffix].search(path.read_bytes()):
            return path.name
    return ""


def possible_faults(server):
    """The names of the faults that this user can make."""
    names = []
    for name, values in FAULTS.items():
        with tempfile.TemporaryDirectory(prefix="batten_fuzz_") as folder:
            if server.run(["--version"], Path(folder), f"{name}={values[-1]}")[0] != 99:
                names.append(name)
    return names


def wrong(code, text, seconds, megabytes, folder, names, fault, command):
    """The finding of a run, or an empty text."""
    if seconds > float(os.environ["BATTEN_FUZZ_SECONDS"]) and code == -9:
        return f"no answer to SIGTERM after {seconds:.1f} s"
    if code < 0:
        return f"signal {-code}"
    if "Sanitizer" in text or "runtime error:" in text:
        return "sanitizer"
    if code not in EXIT_CODES:
        return f"exit code {code}"
    if "batten: unexpected" in text or "terminate called" in text:
        return "an error that nobody expected"
    if code == 0 and command[0] == "info" and fault in ("full=1", "closed=1", "closed=01"):
        return "the text was not written"
    if megabytes > MOST_MEGABYTES and "Sanitizer" not in os.environ.get("BATTEN_FUZZ_BUILD", ""):
        return f"memory: {megabytes:.0f} MB"
    out = folder / "OUT"
    results = [p for p in folder.iterdir() if p.name.startswith("OUT.")]
    left = [p.name for p in folder.iterdir()
            if p.name not in names | {"OUT", "printed", "disk"} and p not in results]
    if left or (out.is_dir() and any(p.name.startswith(".") for p in out.iterdir())):
        return f"left behind: {left}"
    if code in (0, 4):
        if out.is_dir():
            try:
                report = json.loads((out / "report.json").read_text())
            except (OSError, ValueError) as error:
                return f"report: {error}"
            if not finite(report):
                return "report: numbers that are not finite"
            if name := not_named(report) if "network" in report else "":
                return f"{name} turns over and is not named"
        for result in (out, *results):
            if name := not_finite(result):
                return f"{name}: numbers that are not finite"
    elif out.exists() or results:
        # Sequences keep finished frames, scripts finished commands; results whose summary cannot be written are kept.
        if command[0] not in ("run-script", "sequence") and not fault.startswith(("full", "closed")):
            return "files beside a refusal"
    return LONG if code == 130 else ""


class Seed:
    """A file, and the files beside it, to which it may refer."""

    def __init__(self, path, beside):
        self.path, self.data = path, path.read_bytes()
        self.beside = {}
        if beside.is_dir() and path.suffix in (".toml", ".jsonl"):
            files = [p for p in sorted(beside.rglob("*")) if p.is_file() and p != path and
                     p.suffix not in (".md", ".png", ".cpp", ".gif")]
            if sum(p.stat().st_size for p in files) <= MOST_BYTES:
                self.beside = {p.relative_to(beside): p.read_bytes() for p in files}


class Target:
    def __init__(self, name, keep, folders):
        self.name, self.keep = name, keep
        own = HERE / "seeds" / ("networks" if name == "sketches" else name)
        self.seeds = [Seed(p, own / "beside") for p in sorted(own.iterdir())
                      if p.is_file() and (name != "sketches" or p.suffix in ENDINGS[name])]
        self.seeds += [Seed(p, p.parent) for f in folders for p in sorted(f.rglob("*"))
                       if p.suffix in ENDINGS[name] and p.is_file() and
                       p.stat().st_size <= MOST_BYTES]

    def damage(self, name, data, rng):
        if self.name == "sketches":
            return sketched(data, rng)
        alike = [s.data for s in self.seeds if s.path.suffix == Path(name).suffix]
        kinds = rng.choice([GENTLE, MUTATIONS])
        for _ in range(rng.choice([1, 1, 2, 3])):
            data = rng.choice(kinds)(data or b"x", rng, alike or [data or b"x"])
        return data

    def once(self, k, server, faults):
        """Run k: its finding, or an empty text, the kind of its fault and its exit code."""
        rng = random.Random(f"{self.name} {k}")
        seed = rng.choice(self.seeds)
        main = "input" + seed.path.suffix
        files = {Path(main): seed.data, **seed.beside}
        damaged = rng.choice(list(files)) if rng.randrange(3) == 0 else Path(main)
        files[damaged] = self.damage(damaged, files[damaged], rng)
        command = rng.choice(COMMANDS[self.name])
        fault = "-"
        if faults and rng.randrange(2):
            kind = rng.choice(faults)
            fault = f"{kind}={rng.choice(FAULTS[kind])}"
        with tempfile.TemporaryDirectory(prefix="batten_fuzz_") as name:
            folder = Path(name)
            for path, data in files.items():
                (folder / path).parent.mkdir(parents=True, exist_ok=True)
                (folder / path).write_bytes(data)
            words = [main if w == "@" else w for w in command]
            if fault.startswith("disk"):
                words = ["disk/" + w if w.startswith("OUT") else w for w in words]
            if command[0] not in ("info", "run-script"):
                words += ["--memory", MEMORY]
            code, text, seconds, megabytes = server.run(words, folder, fault)
            names = {path.parts[0] for path in files}
            what = wrong(code, text, seconds, megabytes, folder, names, fault, command)
            changed = [str(path) for path, data in files.items()
                       if not (folder / path).is_file() or (folder / path).read_bytes() != data]
            if changed and (command[0] != "run-script" or main in changed):
                what = what or f"changed: {', '.join(changed)}"
            if self.name == "sketches" and fault == "-" and code == 1 and "found no closed loop" not in text:
                what = what or "no model"
            if what:
                kept = self.keep / f"{self.name}-{k}"
                shutil.rmtree(kept, ignore_errors=True)
                shutil.copytree(folder, kept, ignore=shutil.ignore_patterns("OUT*"))
                print(f"{self.name} {k}: {what}: batten {' '.join(words)} in {kept}, fault {fault}, made "
                      f"from {seed.path} with {damaged} damaged\n    {text.strip()[-300:]}", flush=True)
        return what, fault.split("=")[0], code


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("server")
    parser.add_argument("target", choices=["all", *COMMANDS])
    parser.add_argument("seconds", type=float)
    parser.add_argument("--runs", type=int, default=10**9, help="at most so many of each target")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--keep", type=Path, default=Path("fuzz-findings"))
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--seeds", type=Path, nargs="*", default=[], help="folders of more seeds")
    parser.add_argument("--slow", type=int, default=10, help="seconds that a run may take")
    parser.add_argument("--faults", action="store_true", help="faults of the system in half of the runs")
    a = parser.parse_args()
    os.environ["BATTEN_FUZZ_SECONDS"] = str(a.slow)
    found = 0
    faults = possible_faults(Server(os.path.abspath(a.server))) if a.faults else []
    codes = collections.Counter()
    for name in COMMANDS if a.target == "all" else [a.target]:
        target = Target(name, a.keep.absolute(), a.seeds)
        until, number_of_run, lock, count = time.monotonic() + a.seconds, [a.first], threading.Lock(), [0] * 3

        def work(_):
            server = Server(os.path.abspath(a.server))
            while time.monotonic() < until:
                with lock:
                    k = number_of_run[0]
                    number_of_run[0] += 1
                if k >= a.first + a.runs:
                    break
                what, fault, code = target.once(k, server, faults)
                with lock:
                    codes[fault, code] += 1
                    count[0] += 1
                    count[1] += what == LONG
                    count[2] += what not in ("", LONG)
            server.process.stdin.close()
            server.process.wait()

        with ThreadPoolExecutor(a.jobs) as pool:
            list(pool.map(work, range(a.jobs)))
        print(f"{name}: {count[0]} runs, {count[2]} findings, {count[1]} long", flush=True)
        found += count[2]
    if faults:
        print("exit codes by fault:")
        for fault in ("-", *faults):
            of_fault = {code: n for (kind, code), n in sorted(codes.items()) if kind == fault}
            print(f"  {'none' if fault == '-' else fault:8} " +
                  ", ".join(f"{code}: {n}" for code, n in of_fault.items()))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
