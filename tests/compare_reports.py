#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Compares report.json of two runs of the same scenes, key by key.

    tests/compare_reports.py BEFORE AFTER [RENAMES.tsv]

BEFORE and AFTER are folders with one folder per run, each with a report.json. Prints every key whose
value differs, with both values and the relative difference; times and file sizes are ignored.
Exit code 1 if a run is missing, a key was added or removed, or a number differs by more than 1e-6.

RENAMES.tsv maps the keys of BEFORE to those of AFTER: three columns, separated by tabs, with a header.
The first column is the context, KIND:PATH, with the kind of report (surface, fair, deform, sequence, or
* for all) and the old path of the object that contains the key, [] for the items of lists:

    surface:joins[]         kind        continuity    a key
    surface:joins[].kind=   crease      G0            a value (true, false: of booleans)
    names                   region (.*) face \\1      a regular expression, for whole strings anywhere

Of sentences (warnings, reasons, failed checks) only the numbers are then compared; sentences with the
same numbers and another wording are counted as reworded.
"""
import csv
import json
import math
import pathlib
import re
import sys

PASSED_OVER = {"timings_s", "bytes"}
# Keys whose values are sentences, and keys of lists of sentences; names after a renaming.
TEXTS = {"text", "detail", "check", "reason", "rejection_reason", "stopped", "normals", "support",
         "warnings", "defects", "curves_read"}
NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


class Renames:
    """The renames of one kind of report."""

    def __init__(self, rows, kind):
        self.keys, self.values, self.names = {}, {}, []
        for context, old, new in rows:
            if context == "names":
                self.names.append((re.compile(old), new))
                continue
            of, path = context.split(":", 1)
            if of not in (kind, "*"):
                continue
            if path.endswith("="):
                self.values[path[:-1], old] = new
            else:
                self.keys[path, old] = new

    def name(self, text):
        for pattern, new in self.names:
            if pattern.fullmatch(text):
                return pattern.sub(new, text)
        return text

    def apply(self, value, path=""):
        """The value at an old path, with new keys and values."""
        if isinstance(value, dict):
            result = {}
            for key, inner in value.items():
                new = self.keys.get((path, key)) or self.name(key)
                if new in result:
                    raise SystemExit(f"{path}: two keys become '{new}'")
                result[new] = self.apply(inner, f"{path}.{key}" if path else key)
            return result
        if isinstance(value, list):
            return [self.apply(inner, path + "[]") for inner in value]
        if isinstance(value, bool):
            new = self.values.get((path, json.dumps(value)))
            return value if new is None else json.loads(new)
        if isinstance(value, str):
            return self.values.get((path, value)) or self.name(value)
        return value


def read_renames(path):
    with open(path, newline="", encoding="utf-8") as file:
        rows = [row for row in csv.reader(file, delimiter="\t", quoting=csv.QUOTE_NONE) if row][1:]
    for number, row in enumerate(rows, 2):
        if len(row) != 3 or (row[0] != "names" and ":" not in row[0]):
            raise SystemExit(f"{path}: row {number}: expected KIND:PATH, old, new")
    return rows


def kind_of(report):
    return ("surface" if "surface" in report else "deform" if "edits" in report
            else "sequence" if "sequence" in report else "fair")


def flat(value, name=""):
    """(name, value) of every leaf; rows with a name are identified by it."""
    if isinstance(value, dict):
        for key, inner in value.items():
            if key not in PASSED_OVER:
                yield from flat(inner, f"{name}.{key}" if name else key)
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            key = inner.get("name", i) if isinstance(inner, dict) else i
            yield from flat(inner, f"{name}[{key}]")
    else:
        yield name, value


def difference(a, b):
    if isinstance(a, (int, float)) and isinstance(b, (int, float)) and not isinstance(a, bool):
        return abs(a - b) / max(abs(a), abs(b), 1e-300)
    return math.inf


def agree(a, b):
    """Equal up to rounding."""
    tiny = all(isinstance(x, float) and abs(x) < 1e-8 for x in (a, b))
    return difference(a, b) <= 1e-6 or tiny


def is_text(name):
    """Whether a leaf is a sentence: its last key, or that of its list, is one of TEXTS."""
    return re.sub(r"\[\d+\]$", "", name).rsplit(".", 1)[-1] in TEXTS


def reworded(a, b):
    """Two texts with the same numbers."""
    a, b = (sorted(float(x) for x in NUMBER.findall(text)) for text in (a, b))
    return len(a) == len(b) and all(agree(x, y) for x, y in zip(a, b))


def main():
    if len(sys.argv) not in (3, 4):
        raise SystemExit(__doc__)
    before, after = (pathlib.Path(p) for p in sys.argv[1:3])
    renames = read_renames(sys.argv[3]) if len(sys.argv) == 4 else None
    bad = 0
    for file in sorted(before.glob("*/report.json")):
        run = file.parent.name
        other = after / run / "report.json"
        if not other.exists():
            print(f"{run}: no report afterwards")
            bad += 1
            continue
        a, b = (json.loads(f.read_text()) for f in (file, other))
        if renames is not None:
            a = Renames(renames, kind_of(a)).apply(a)
        a, b = dict(flat(a)), dict(flat(b))
        rows, words = [], 0
        for key in list(a) + [k for k in b if k not in a]:
            if key in a and key in b:
                if a[key] == b[key]:
                    continue
                d = difference(a[key], b[key])
                if renames is not None and is_text(key) and reworded(str(a[key]), str(b[key])):
                    words += 1
                    continue
                bad += not agree(a[key], b[key])
                rows.append(f"  {key}: {a[key]!r} -> {b[key]!r}"
                            + (f"  ({d:.1e})" if d < math.inf else ""))
            else:
                bad += 1
                rows.append(f"  {key}: {'gone' if key in a else 'new'} ({a.get(key, b.get(key))!r})")
        print(f"{run}: {'the same' if not rows else f'{len(rows)} of {len(a)} differ'}"
              + (f", {words} reworded" if words else ""))
        print("\n".join(rows), end="\n" if rows else "")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
