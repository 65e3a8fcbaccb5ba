# SPDX-License-Identifier: MPL-2.0
"""Runs the commands in the documents: README.md, docs/*.md, examples/*/README.md.

usage: document_commands.py SOURCE PROGRAM SCRATCH [--words]

--words checks the options only, and runs nothing.

A command is an indented line of a document that begins with `batten` or `build/release/bin/batten`,
optionally after `xvfb-run -a`. It runs in the source folder, or in the folder of the document if
its files are there; its output goes to the scratch folder. Commands with input that is not part of
the source (FILE, scan.stl) do not run: their options must be listed by `--help` of the command.
Exit codes 0 and 4 (finished, but a check failed) are accepted, others only if the line contains
them: `# exit code 2`.
"""
import re
import shlex
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

SOURCE, PROGRAM, SCRATCH = (Path(word).resolve() for word in sys.argv[1:4])
LINE = re.compile(r"^ {4,}(?:xvfb-run -a )?(?:build/release/bin/)?batten ([a-z].*)$")
ENDINGS = re.compile(r"\.(?!\d+$)[a-z0-9]{2,7}$")


def expand_loops(lines):
    """The lines of a document; those in a loop of the shell once per value of its variable."""
    variable, values = "", [""]
    for line in lines:
        loop = re.match(r"^ {4,}for (\w+) in (.*); do$", line)
        if loop:
            variable, values = "$" + loop.group(1), loop.group(2).split()
        elif line.strip() == "done":
            variable, values = "", [""]
        else:
            yield from [line.replace(variable, value) for value in values] if variable else [line]


def commands():
    """(document, arguments, expected exit code) of every command, without duplicates."""
    seen = set()
    documents = [SOURCE / "README.md", *sorted(SOURCE.glob("docs/*.md")), *sorted(SOURCE.glob("examples/*/README.md"))]
    for document in documents:
        for line in expand_loops(document.read_text(encoding="utf-8").splitlines()):
            found = LINE.match(line)
            if not found:
                continue
            text = re.split(r"\s{3,}|\s#\s", found.group(1))[0].rstrip(" \\…")
            code = re.search(r"# exit code (\d)", line)
            key = (document.parent, text)
            if key not in seen:
                seen.add(key)
                yield document, shlex.split(text), int(code.group(1)) if code else 0


def is_out(words, i):
    return i > 0 and words[i - 1] in ("--out", "--picture", "--report", "--record", "--screenshot", "--drawing")


def place_of(document, words):
    """The folder that contains all files that the command reads, or None."""
    files = [w for i, w in enumerate(words) if i > 0 and ENDINGS.search(w) and not is_out(words, i) and "=" not in w]
    if words[0] == "convert":
        files = files[:1]
    for folder in (SOURCE, document.parent):
        if files and all((folder / f).exists() or (SCRATCH / f).exists() for f in files):
            return folder
    return None


def redirected(words):
    """The arguments with output paths in the scratch folder, also for inputs written there before."""
    to = list(words)
    for i, word in enumerate(words):
        written = is_out(words, i) or (words[0] == "convert" and i == 2)
        if written or (i > 0 and ENDINGS.search(word) and (SCRATCH / word).exists()):
            (SCRATCH / word).parent.mkdir(parents=True, exist_ok=True)
            to[i] = str(SCRATCH / word)
    return to


def run(document, words, code):
    """The error of a command, or an empty text; whether it was run."""
    folder = None if "--words" in sys.argv else place_of(document, words)
    if folder is None:
        known = subprocess.run([PROGRAM, words[0], "--help"], capture_output=True, text=True, check=False).stdout
        options = [w.split("=")[0].strip("[]") for w in words if w.strip("[").startswith("--")]
        wrong = [o for o in options if not re.search(re.escape(o) + r"\b", known)]
        return (f"unknown to --help: {wrong}" if wrong else ""), False, 0.0
    start = time.time()
    done = subprocess.run([PROGRAM, *redirected(words)], cwd=folder, capture_output=True, text=True, check=False)
    good = done.returncode == code or (code == 0 and done.returncode == 4)
    return ("" if good else f"exit code {done.returncode}: {done.stderr.strip()[-400:]}"), True, time.time() - start


def main():
    SCRATCH.mkdir(parents=True, exist_ok=True)
    rows = list(commands())
    failed = ran = 0
    with ThreadPoolExecutor(2) as pool:
        # The commands of one document run in order: one may read the output of another.
        by_document = {}
        for row in rows:
            by_document.setdefault(row[0], []).append(row)
        results = pool.map(lambda group: [(row, run(*row)) for row in group], by_document.values())
        for group in results:
            for (document, words, _), (wrong, was_run, seconds) in group:
                ran += was_run
                if wrong:
                    failed += 1
                    print(f"{document.relative_to(SOURCE)}: batten {' '.join(words)}\n    {wrong}")
                elif seconds > 10:
                    print(f"{seconds:.0f} s: batten {' '.join(words)}")
    print(f"{len(rows)} commands of {len(by_document)} documents: {ran} run, {len(rows) - ran} checked by --help, {failed} wrong")
    return 1 if failed or len(rows) < 60 or (ran < 20 and "--words" not in sys.argv) else 0


if __name__ == "__main__":
    sys.exit(main())
