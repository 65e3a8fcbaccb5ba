#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Licences of the libraries that Batten's binaries use, from cmake/packages/licences.csv.

usage: licences.py [--check]    writes docs/licences.md; --check: fails if the file is not up to date
"""
import csv
import fnmatch
import sys
from dataclasses import dataclass
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1]
TABLE = SOURCE / "cmake/packages/licences.csv"
PAGE = SOURCE / "docs/licences.md"
BINARIES = {"batten": "`batten`", "batten_cad": "the module for CAD files", "batten-studio": "`batten-studio`",
            "batten_petsc": "the module for several processes", "python": "the Python module"}

# Facts that the table uses like options, and where they do not hold.
FACTS = {"BATTEN_VTK_READS_TIFF": "VTK before 9.2 (Debian 12)", "BATTEN_CERES_IS_SHARED": "a static Ceres (Debian 12)"}


@dataclass
class Library:
    """A row of the table."""
    package: str
    licence: str
    binaries: list
    options: list
    feature: str

    @property
    def gpl(self):
        """True if every alternative of the licence contains the GPL without an exception."""
        def is_gpl(term):
            return term.startswith("GPL-") and " WITH " not in term
        return all(any(is_gpl(term) for term in choice.split(" AND ")) for choice in self.licence.split(" OR "))

    def is_used_by(self, package, binary):
        return fnmatch.fnmatchcase(package, self.package) and ("all" in self.binaries or binary in self.binaries)


def read_table():
    rows = [line for line in TABLE.read_text().splitlines() if not line.startswith("#")]
    return [Library(row["package"], row["licence"], row["used by"].split(), row["option"].split(), row["feature"])
            for row in csv.DictReader(rows)]


def library_of(package, binary, table):
    """The first row for a package that a binary uses, or None."""
    return next((library for library in table if library.is_used_by(package, binary)), None)


def binaries_text(library):
    return "all" if "all" in library.binaries else ", ".join(BINARIES[name] for name in library.binaries)


def without(library):
    if not library.options:
        return "cannot be switched off"
    return " and ".join(FACTS.get(option, f"`-D{option}=OFF`") for option in library.options)


def page(table):
    """The text of docs/licences.md."""
    gpl = [library for library in table if library.gpl and not library.package.endswith("suitesparse-dev")]
    lines = [
        "# Licences", "",
        "<!-- Written by scripts/licences.py from cmake/packages/licences.csv. -->", "",
        "The source code of Batten is licensed under the Mozilla Public License 2.0 (`LICENSE`). The following tables list",
        "the libraries with which the binaries are linked when they are built on Debian, directly or through other",
        "libraries, and the libraries whose headers or static libraries are compiled into them. A test compares the tables",
        "with the binaries of each build.", "",
        "You may distribute a binary that is linked with a library under the GNU General Public License only under the",
        "terms of the GPL. `batten --version` prints the licence of the program as a whole. Each Debian package states it in",
        "its copyright file.", "",
        "## Libraries under the GPL", "",
        "| library | licence | Debian package | binaries | removed by |", "|---|---|---|---|---|"]
    for library in gpl:
        name, _, use = library.feature.partition(": ")
        lines.append(f"| {name}: {use} | {library.licence} | `{library.package}` | {binaries_text(library)} | "
                     f"{without(library)} |")
    lines += [
        "", "On Debian 12, the preset `minimal` builds `batten` without these libraries. JBIG-KIT remains in the module for",
        "CAD files: Debian's OpenCASCADE links FreeImage (`libTKXCAF` needs `libTKService`), FreeImage links the TIFF",
        "library, and the TIFF library links JBIG-KIT. `batten` loads the module only to read or write CAD files. On Debian",
        "13, `batten` itself is linked with JBIG-KIT, through `libvtkRenderingOpenGL2`, `libvtkIOImage` and the TIFF library.",
        "Batten never calls these image libraries. An OpenCASCADE without FreeImage, and on Debian 13 a VTK without TIFF,",
        "remove JBIG-KIT.", "",
        "## Other libraries", "",
        "| Debian package | licence | binaries | feature |", "|---|---|---|---|"]
    for library in table:
        if not library.gpl:
            lines.append(f"| `{library.package}` | {library.licence} | {binaries_text(library)} | {library.feature} |")
    return "\n".join(lines) + "\n"


def main(arguments):
    text = page(read_table())
    if "--check" not in arguments:
        PAGE.write_text(text)
    elif not PAGE.exists() or PAGE.read_text() != text:
        print(f"{PAGE} differs from {TABLE}; run scripts/licences.py", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
