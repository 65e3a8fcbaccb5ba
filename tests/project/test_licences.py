# SPDX-License-Identifier: MPL-2.0
"""The licences of all libraries in the binaries of this build are declared in cmake/packages/licences.csv.

usage: test_licences.py BUILD

For each binary, the test lists the packages of the shared libraries with which it is linked, directly or through other
libraries (ldd), and of the static libraries and headers that are compiled into it. Each package must be in the table, and
a package under the GPL must belong to a switch that is on in this build.
"""
import os
import re
import subprocess
import sys
import unittest
from collections import defaultdict
from pathlib import Path

BUILD = Path(sys.argv[1]).resolve()
SOURCE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "scripts"))
import debian  # noqa: E402
import licences  # noqa: E402

PATTERNS = {"batten": "bin/batten", "batten_cad": "bin/batten_cad.so", "batten-studio": "bin/batten-studio",
            "batten_petsc": "bin/batten_petsc.so", "python": "python/batten/_batten*.so"}


def output(*command):
    return subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                          cwd=BUILD, check=False).stdout


def binaries():
    """The binaries of this build, by their names in the table."""
    found = {name: sorted(BUILD.glob(pattern)) for name, pattern in PATTERNS.items()}
    return {name: files[0] for name, files in found.items() if files}


def switches():
    """The options and facts of this build that are on."""
    return set(re.findall(r"^(BATTEN_\w+):(?:BOOL|INTERNAL)=(?:ON|1|TRUE|YES)$", (BUILD / "CMakeCache.txt").read_text(), re.M))


def shared_libraries(binary):
    """Library files with which a binary is linked, in a closure."""
    text = output("ldd", binary)
    missing = re.findall(r"(\S+) => not found", text)
    if missing:
        raise AssertionError(f"{binary}: libraries not found: {missing}")
    return {os.path.realpath(path) for path in re.findall(r"=> (/\S+)", text)}


def dependencies():
    """Headers of packages that the targets of this build include, one of each folder."""
    headers = defaultdict(dict)
    target = ""
    for line in output("ninja", "-t", "deps").splitlines():
        if not line.startswith(" "):
            target = line.split(":")[0]
        elif line.strip().startswith("/usr/"):
            path = os.path.normpath(line.strip())
            headers[target.split(".dir/")[0]].setdefault(os.path.dirname(path), path)
    return headers


def static_libraries():
    """Static libraries of packages that are linked into each target of build.ninja."""
    found = defaultdict(set)
    for output_file, inputs in re.findall(r"^build (\S+)(?: \S+)*?: CXX_\w+_LINKER\S* (.*)$",
                                          (BUILD / "build.ninja").read_text(), re.M):
        found[output_file].update(re.findall(r"(/usr/\S+\.a)\b", inputs))
    return found


class Licences(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.table = licences.read_table()
        cls.used = {}
        headers, archives = dependencies(), static_libraries()
        # The libraries are in all binaries, except OpenCASCADE and PETSc.
        special = r"tests|benchmarks|examples|apps|core/solvers|io/CMakeFiles/batten_cad"
        everywhere = {path for target, paths in headers.items() for path in paths.values() if not re.match(special, target)}
        own = {"batten": r"apps/CMakeFiles", "batten_cad": r"io/CMakeFiles/batten_cad",
               "batten-studio": r"apps/studio|apps/CMakeFiles/batten_documents|io/CMakeFiles/batten_cad",
               "python": r"apps/python|apps/CMakeFiles/batten_documents", "batten_petsc": r"core/solvers"}
        for name, binary in binaries().items():
            files = shared_libraries(binary) | archives[str(binary.relative_to(BUILD))]
            files |= {path for target, paths in headers.items() if re.match(own[name], target)
                      for path in paths.values()}
            cls.used[name] = files if name == "batten_petsc" else files | everywhere
        cls.packages = debian.owners_of(set().union(*cls.used.values()))

    def libraries(self):
        """Pairs of a binary and a package that it uses."""
        return sorted({(name, self.packages[file]) for name, files in self.used.items() for file in files
                       if self.packages[file]})

    def test_the_headers_of_the_build_are_known(self):
        self.assertIn("libeigen3-dev", self.packages.values())

    def test_each_library_belongs_to_a_package(self):
        self.assertEqual([], sorted(file for file, package in self.packages.items() if not package))

    def test_each_package_is_in_the_table(self):
        unknown = [f"{binary}: {package}" for binary, package in self.libraries()
                   if not licences.library_of(package, binary, self.table)]
        self.assertEqual([], unknown, f"packages that {licences.TABLE} does not list for these binaries")

    def test_packages_under_the_gpl_belong_to_a_switch_that_is_on(self):
        on = switches()
        undeclared = []
        for binary, package in self.libraries():
            library = licences.library_of(package, binary, self.table)
            if library and library.gpl and library.options and not on & set(library.options):
                undeclared.append(f"{binary}: {package} ({library.licence}), though {' and '.join(library.options)} is off")
        self.assertEqual([], undeclared)

    def test_the_program_states_its_licence(self):
        if "batten" not in self.used:
            self.skipTest("no program")
        gpl = sorted({licences.library_of(package, "batten", self.table).feature.split(":")[0]
                      for binary, package in self.libraries() if binary == "batten"
                      and licences.library_of(package, binary, self.table)
                      and licences.library_of(package, binary, self.table).gpl})
        stated = re.search(r"^licence +(.*)$", output(BUILD / "bin/batten", "--version"), re.M)
        self.assertIsNotNone(stated)
        names = re.search("because of (.*)", stated[1])
        self.assertEqual(gpl, sorted(names[1].split(", ")) if names else [])

    def test_the_text_of_the_licence_is_that_of_the_project(self):
        self.assertEqual((SOURCE / "LICENSE").read_text(), (SOURCE / "LICENSES/MPL-2.0.txt").read_text())

    def test_the_page_is_up_to_date(self):
        self.assertEqual(licences.page(self.table), licences.PAGE.read_text())


if __name__ == "__main__":
    if not (BUILD / "build.ninja").exists() or not output("dpkg", "-S", "/bin/sh"):
        print("skipped: the test needs a build with Ninja on Debian")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1])
