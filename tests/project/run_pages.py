# SPDX-License-Identifier: MPL-2.0
"""Runs the tutorial and the how-to guides as a reader would, and compares the printed output.

usage: run_pages.py SOURCE PROGRAM PYTHON_FOLDER [--pictures] [PAGE…]

The blocks of a page are used in order, in a folder that contains `examples`; the pages of the tutorial share one
folder, each guide has its own. A block is

  sh              run by bash, with `batten` in the path; exit code 0, or N of its last command if it contains
                  `# exit code N`. Skipped if a program of OPTIONAL is missing
  python          run, unless its first line names a file
  text            below a block that was run: each line occurs in the output, in this order, with the same numbers
                  within a unit of the last digit; `…` matches anything
  first line `# NAME` or `// NAME`
                  written to the file NAME; appended to it with `# NAME, continued`. If NAME is a path of the
                  repository (`examples/embed/network.cpp`), that file contains the block instead
  any other       not used

--pictures copies the pictures that a page shows from the outputs of its commands to the folder of the page.
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

WORDS = [word for word in sys.argv[1:] if not word.startswith("--")]
SOURCE, PROGRAM, PYTHON = (Path(word).resolve() for word in WORDS[:3])
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NAMED = re.compile(r"(?:#|//) ([\w./-]+\.\w+)(, continued)?(?::.*)?\n")
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
IMAGE = re.compile(r"!\[[^]]*\]\(([\w.-]+\.(?:png|gif))\)")
OPTIONAL = ("ccx", "freecadcmd", "cmake")
MODULES = r"No module named '(scipy|pandas|meshio|matplotlib)'"


def unit_of(text):
    mantissa, _, exponent = text.partition("e")
    return 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))


def same_line(shown, printed):
    """Whether a line of a page is a printed line, up to a unit in the last digit of each number."""
    form = "".join(f"({NUMBER.pattern})" if NUMBER.fullmatch(part) else ".*" if part == "…" else r"\s+" if part.isspace() else re.escape(part)
                   for part in re.split(rf"({NUMBER.pattern}|…|\s+)", shown.strip()))
    found = re.fullmatch(form, printed.strip())
    return bool(found) and all(abs(float(a) - float(b)) <= max(1.01 * unit_of(a), 1e-9)
                               for a, b in zip(NUMBER.findall(shown), found.groups()))


def missing_line(shown, output):
    """The first line of a text block that the output does not contain, in order; None if there is none."""
    lines = iter(output.splitlines())
    for line in shown.splitlines():
        if line.strip() not in ("", "…") and not any(same_line(line, printed) for printed in lines):
            return line
    return None


def use(language, text, folder, last):
    """Uses one block: its output, None if it has none or was skipped. Throws AssertionError."""
    name = NAMED.match(text)
    if name:
        if (SOURCE / name[1]).is_file():
            assert text[name.end():].strip() in (SOURCE / name[1]).read_text(), f"{name[1]} does not contain the block"
            return None
        (folder / name[1]).parent.mkdir(parents=True, exist_ok=True)
        with open(folder / name[1], "a" if name[2] else "w") as file:
            file.write(text)
        return None
    if language == "text" and last is not None:
        line = missing_line(text, last)
        assert line is None, f"not printed: {line}\nprinted:\n{last}"
        return None
    if language not in ("sh", "python"):
        return None
    if language == "sh" and any(re.search(rf"\b{word}\b", text) and not shutil.which(word) for word in OPTIONAL):
        print(f"skipped, a program is missing: {text.strip()}")
        return None
    expected = re.search(r"# exit code (\d+)", text)
    code = f"set -e; python3() {{ '{sys.executable}' \"$@\"; }}\n{text}"
    done = subprocess.run(["bash", "-c", code] if language == "sh" else [sys.executable, "-c", text], cwd=folder, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
                          env={**os.environ, "PATH": f"{PROGRAM.parent}:{os.environ['PATH']}", "PYTHONPATH": str(PYTHON)})
    if re.search(MODULES, done.stdout):
        print(f"skipped, a module is missing: {text.splitlines()[0]}")
        return None
    assert done.returncode == int(expected[1] if expected else 0), f"exit code {done.returncode} of\n{text}\n{done.stdout}"
    return done.stdout


def pictures(page, folder):
    """Each picture of a page is a result of its commands."""
    for name in IMAGE.findall(page.read_text(encoding="utf-8")):
        made = sorted(folder.rglob(name), key=lambda file: file.stat().st_mtime)
        assert made, f"no command of the page wrote {name}"
        if "--pictures" in sys.argv:
            shutil.copy(made[-1], page.parent / name)


def run(group):
    """The failures of pages that share a folder."""
    failures = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "examples").symlink_to(SOURCE / "examples")
        for page in group:
            start, last = time.time(), None
            try:
                for language, text in BLOCK.findall(page.read_text(encoding="utf-8")):
                    output = use(language, text, folder, last)
                    last = last if language == "text" else output
                pictures(page, folder)
            except AssertionError as failure:
                failures.append(f"{page.relative_to(SOURCE)}: {failure}")
            print(f"{time.time() - start:5.1f} s  {page.relative_to(SOURCE)}", flush=True)
    return failures


def main():
    tutorial = sorted(SOURCE.glob("docs/tutorial/*.md"))
    groups = [tutorial] + [[page] for page in sorted(SOURCE.glob("docs/howto/*.md"))]
    if WORDS[3:]:
        wanted = {Path(word).resolve() for word in WORDS[3:]}
        groups = [group for group in groups if wanted & set(group)]
    with ThreadPoolExecutor(2) as pool:
        failures = [failure for group in pool.map(run, groups) for failure in group]
    print("\n".join(failures) or f"{sum(map(len, groups))} pages")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
