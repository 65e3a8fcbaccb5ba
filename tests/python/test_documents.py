# SPDX-License-Identifier: MPL-2.0
"""Runs the blocks of Python, TOML and C++ in the documents.

Each block of Python runs by itself, each whole scene (a block of TOML with a `unit`) runs, and its report must have the
form of docs/reference/report.schema.json. Parts of scenes contain only keys of the reference. Blocks of C++ are compiled,
those without main() as the body of a function. A block is left out if the line above it is `<!-- not run: REASON -->`.
docs/tutorial and docs/howto have a test of their own (tests/project/run_pages.py); document_commands.py runs commands.
"""

import json
import os
import re
import subprocess
import sys
import tomllib
import unittest
from pathlib import Path

from properties import PROGRAM, SOURCE, PropertyTests, batten
from test_reference import PROBES, documented

ROOT = Path(SOURCE)
BLOCK = re.compile(r"(<!-- not run: .+? -->\n)?^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
SKIPPED_FOLDERS = ("docs/tutorial", "docs/howto")


def documents():
    files = [ROOT / "README.md", *ROOT.glob("docs/**/*.md"), *ROOT.glob("examples/*/README.md"), ROOT / "benchmarks/README.md"]
    return sorted(f for f in files if not str(f.relative_to(ROOT)).startswith(SKIPPED_FOLDERS))


def blocks(*languages):
    """(name, text) of the blocks in these languages that are to be run."""
    for file in documents():
        for number, (left_out, language, text) in enumerate(BLOCK.findall(file.read_text(encoding="utf-8"))):
            if language in languages and not left_out:
                yield f"{file.relative_to(ROOT)}, block {number + 1}", text


def keys_of(table):
    """The keys of a parsed table and of the tables in it, with dots."""
    keys = set()
    for key, value in table.items():
        keys.add(key)
        for inner in value if isinstance(value, list) else [value]:
            if isinstance(inner, dict):
                keys |= {f"{key}.{one}" for one in keys_of(inner)}
    return keys


def tables_of_reference():
    """{table: key sets}, one set per page of the reference that describes the table."""
    common = documented("sequence/operation")["operation"]
    tables = {}
    for page in PROBES:
        of_page = {}
        for name, keys in documented(page).items():
            table, _, inner = name.partition(".")
            of_page.setdefault(table, set()).update({f"{inner}.{key}" for key in keys} | {inner} if inner else keys)
        for table, keys in of_page.items():
            tables.setdefault(table, []).append(keys | common if table == "operation" else keys)
    tables["sweep"][0] |= tables["picture"][0]
    tables["operation"] = [keys | {f"source.select.{key}" for key in tables["select"][0]} for keys in tables["operation"]]
    return tables


class Documents(PropertyTests):
    def setUp(self):
        super().setUp()
        os.symlink(ROOT / "examples", self.file("examples"))

    def test_python(self):
        count = 0
        for name, text in blocks("python"):
            done = subprocess.run([sys.executable, "-c", text], cwd=self.folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
            missing = re.search(r"No module named '(scipy|meshio|matplotlib|pandas)'", done.stderr)
            if missing:
                print(f"skipped: {name} needs {missing[1]}")
                continue
            count += 1
            self.assertEqual(done.returncode, 0, f"{name}\n{text}{done.stderr}")
        self.assertGreater(count, 8)

    def test_scenes(self):
        before = os.getcwd()
        os.chdir(self.folder)
        self.addCleanup(os.chdir, before)
        validator = report_validator()
        count = 0
        for name, text in blocks("toml"):
            scene = tomllib.loads(text)
            if "unit" not in scene:
                continue
            with self.subTest(name):
                Path("scene.toml").write_text(text, encoding="utf-8")
                report = batten.run("scene.toml", "out")
                self.assertEqual(report["failed_checks"], [])
                for problem in validator.iter_errors(json.loads(Path("out/report.json").read_text())):
                    self.fail(f"report.json: {problem.json_path}: {problem.message}")
                if "stress" in scene:
                    self.assertEqual(batten.stress(batten.load("scene.toml")).failed_checks, [])
                count += 1
        self.assertGreater(count, 45)

    def test_parts_of_scenes(self):
        known = tables_of_reference()
        every = [keys for table in known.values() for keys in table]
        for name, text in blocks("toml"):
            scene = tomllib.loads(text)
            if "unit" in scene:
                continue
            parts = {key: scene.pop(key) for key in list(scene) if key in known and not isinstance(scene[key], (str, float, int))}
            for table, value in [*parts.items(), ("", scene)]:
                for one in value if isinstance(value, list) else [value]:
                    keys = keys_of(one)
                    self.assertTrue(any(keys <= own for own in (known[table] if table else every)),
                                    f"{name}: no table '{table}' of the reference has the keys {keys}")

    def test_citation(self):
        try:
            import yaml
        except ImportError:
            self.skipTest("yaml is not there (python3-yaml)")
        citation = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
        self.assertLessEqual({"cff-version", "message", "title", "authors", "version", "date-released", "license"}, set(citation))
        cmake = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
        self.assertIn(f"project(batten VERSION {citation['version']}", cmake)
        self.assertIn(f"## [{citation['version']}] – {citation['date-released']}", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"))

    def test_cpp(self):
        parts = ["#include <batten/batten.h>\n"]
        for number, (_, text) in enumerate(blocks("cpp")):
            includes = "".join(re.findall(r"#include .*\n", text))
            body = re.sub(r"#include .*\n", "", text).replace("int main()", f"int main_{number}()")
            parts.append(includes + (body if "main_" in body else f"void block_{number}() {{\n{body}\n}}\n"))
        self.assertGreaterEqual(len(parts), 4)
        Path(self.file("blocks.cpp")).write_text("\n".join(parts), encoding="utf-8")
        include = Path(PROGRAM).parent.parent / "include"
        done = subprocess.run(["c++", "-std=c++20", "-fsyntax-only", f"-I{include}", "-isystem", "/usr/include/eigen3", "blocks.cpp"],
                              cwd=self.folder, stderr=subprocess.PIPE, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)


def report_validator():
    try:
        from jsonschema import Draft202012Validator
    except ImportError:
        raise unittest.SkipTest("jsonschema is not there (python3-jsonschema)")
    return Draft202012Validator(json.loads((ROOT / "docs/reference/report.schema.json").read_text(encoding="utf-8")))


if __name__ == "__main__":
    unittest.main()
