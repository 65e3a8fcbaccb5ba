# SPDX-License-Identifier: MPL-2.0
"""Runs the commands in the documents: README.md, docs, examples/*/README.md, benchmarks/README.md.

usage: document_commands.py SOURCE PROGRAM SCRATCH [--words]

--words checks the options only, and runs nothing.

A command is an indented line of a document, or a line of a block of `sh`, that begins with a word of COMMANDS. Commands of
`batten`, also in loops of the shell, run in the source folder, or in the folder of the document if its files are there;
their output goes to the scratch folder. Commands with input that is not part of the source (FILE, scan.stl) do not run:
their options must be listed by `--help` of the command. Exit codes 0 and 4 (finished, but a check failed) are accepted,
others only if the line contains them: `# exit code 2`. The reports must have the form of docs/reference/report.schema.json.
Scripts, targets and files of other commands must exist. docs/tutorial and docs/howto are run by run_pages.py.
"""
import json
import re
import shlex
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

SOURCE, PROGRAM, SCRATCH = (Path(word).resolve() for word in sys.argv[1:4])
COMMANDS = ("batten", "build/release/bin/", "scripts/", "cmake ", "ctest ", "env PYTHONPATH=", "python3 ", "ccx ", "mpirun ", "apt ", "git ")
LINE = re.compile(r"^(?: {4,}|)(?:xvfb-run -a )?(?:build/release/bin/)?batten ([a-z].*)$")
LOOP = re.compile(r"^ *for (\w+) in ([^;]+); do")
ENDINGS = re.compile(r"\.[a-z0-9]{2,7}$")
TARGETS = "".join(file.read_text(encoding="utf-8") for file in SOURCE.glob("examples/CMakeLists.txt"))


def documents():
    files = [SOURCE / "README.md", SOURCE / "CONTRIBUTING.md", SOURCE / "benchmarks/README.md", *SOURCE.glob("docs/**/*.md"),
             *SOURCE.glob("examples/*/README.md")]
    return sorted(f for f in files if f.exists() and f.parent not in (SOURCE / "docs/tutorial", SOURCE / "docs/howto"))


def lines_of(document):
    """The lines of a document that are commands; those in a loop of the shell once for each of its values."""
    block, loop = "", None
    for line in document.read_text(encoding="utf-8").splitlines():
        if line.startswith("```"):
            block = "" if block else line[3:] or "text"
            continue
        if not (block == "sh" or (not block and line.startswith("    "))):
            continue
        found = LOOP.match(line)
        loop = found if found else None if line.strip() == "done" else loop
        text = re.sub(r"^(?: *for .*; do +| +)(?:xvfb-run -a )?", "", line)
        if block == "sh" or text.startswith(COMMANDS):
            for value in loop[2].split() if loop else [""]:
                yield text.replace(f"${loop[1]}", value) if loop else text


def commands():
    """(document, arguments, expected exit code) of every command of batten, without duplicates."""
    seen = set()
    for document in documents():
        for line in lines_of(document):
            found = LINE.match(line)
            if not found:
                continue
            text = re.split(r"\s{3,}|\s#\s", found.group(1))[0].rstrip(" \\…")
            code = re.search(r"# exit code (\d)", line)
            key = (document.parent, text)
            if key not in seen:
                seen.add(key)
                yield document, shlex.split(text), int(code.group(1)) if code else 0


def missing_parts():
    """Scripts, targets and files that other commands of the documents name, but that are missing; the number of these commands."""
    missing, count = [], 0
    for document in documents() if (SOURCE / "CMakeLists.txt").exists() else []:  # not in an installed copy
        for line in lines_of(document):
            if LINE.match(line):
                continue
            count += 1
            parts = [SOURCE / word for word in re.findall(r"(?<![\w/])(?:scripts|examples|tests)/[\w./-]+", line)]
            missing += [f"{document.relative_to(SOURCE)}: no {part.relative_to(SOURCE)}: {line}" for part in parts if not part.exists()]
            targets = re.findall(r"--target (\w+)", line) + re.findall(r"^build/release/bin/([\w-]+)", line)
            missing += [f"{document.relative_to(SOURCE)}: no target {t}: {line}" for t in targets
                        if t not in ("batten", "batten-studio") and not re.search(rf"\b{t}\b", TARGETS)]
    return missing, count


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


def wrong_reports():
    """Reports in the scratch folder that do not have the form of the schema."""
    try:
        from jsonschema import Draft202012Validator
    except ImportError:
        print("the reports are not validated: jsonschema is not there (python3-jsonschema)")
        return []
    validator = Draft202012Validator(json.loads((SOURCE / "docs/reference/report.schema.json").read_text(encoding="utf-8")))
    wrong = []
    for file in sorted(SCRATCH.rglob("report*.json")):
        for problem in validator.iter_errors(json.loads(file.read_text(encoding="utf-8"))):
            wrong.append(f"{file}: {problem.json_path}: {problem.message[:200]}")
    return wrong


def main():
    SCRATCH.mkdir(parents=True, exist_ok=True)
    rows = list(commands())
    ran = 0
    wrong, others = missing_parts()
    with ThreadPoolExecutor(2) as pool:
        # The commands of one document run in order: one may read the output of another.
        by_document = {}
        for row in rows:
            by_document.setdefault(row[0], []).append(row)
        results = pool.map(lambda group: [(row, run(*row)) for row in group], by_document.values())
        for group in results:
            for (document, words, _), (error, was_run, seconds) in group:
                ran += was_run
                if error:
                    wrong.append(f"{document.relative_to(SOURCE)}: batten {' '.join(words)}\n    {error}")
                elif seconds > 10:
                    print(f"{seconds:.0f} s: batten {' '.join(words)}")
    if "--words" not in sys.argv:
        wrong += wrong_reports()
    print(*wrong, sep="\n", end="\n" if wrong else "")
    print(f"{len(rows)} commands of {len(by_document)} documents: {ran} run, {len(rows) - ran} checked by --help; {others} other commands; "
          f"{len(wrong)} wrong")
    return 1 if wrong or len(rows) < 60 or (ran < 20 and "--words" not in sys.argv) else 0


if __name__ == "__main__":
    sys.exit(main())
