#!/usr/bin/env python3
"""Compares report.json of two runs of the same scenes, key by key.

    tests/compare_reports.py BEFORE AFTER

BEFORE and AFTER are folders with one folder a run, each with a report.json. Prints every key whose
value differs, with both values and the relative difference; times and file sizes are passed over.
Exit code 1 when a run is missing or a key has come or gone, or a number differs by more than 1e-6.
"""
import json
import math
import pathlib
import sys

PASSED_OVER = {"timings_s", "bytes"}


def flat(value, name=""):
    """(name, value) of every leaf; rows with a name of their own go by it."""
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


def main():
    before, after = (pathlib.Path(p) for p in sys.argv[1:3])
    bad = 0
    for file in sorted(before.glob("*/report.json")):
        run = file.parent.name
        other = after / run / "report.json"
        if not other.exists():
            print(f"{run}: no report afterwards")
            bad += 1
            continue
        a, b = (dict(flat(json.loads(f.read_text()))) for f in (file, other))
        rows = []
        for key in list(a) + [k for k in b if k not in a]:
            if key in a and key in b:
                if a[key] == b[key]:
                    continue
                d = difference(a[key], b[key])
                tiny = all(isinstance(x, float) and abs(x) < 1e-8 for x in (a[key], b[key]))
                bad += not (d <= 1e-6 or tiny)
                rows.append(f"  {key}: {a[key]!r} -> {b[key]!r}"
                            + (f"  ({d:.1e})" if d < math.inf else ""))
            else:
                bad += 1
                rows.append(f"  {key}: {'gone' if key in a else 'new'} ({a.get(key, b.get(key))!r})")
        print(f"{run}: {'the same' if not rows else f'{len(rows)} of {len(a)} differ'}")
        print("\n".join(rows), end="\n" if rows else "")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
