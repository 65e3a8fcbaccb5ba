# SPDX-License-Identifier: MPL-2.0
"""Debian packages of the build folder, unpacked into a separate root and used there.

usage: test_packages.py BUILD SCRATCH

scripts/package builds and checks the same packages for a release, and installs them in a clean root.
"""
import os
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

BUILD, SCRATCH = Path(sys.argv[1]), Path(sys.argv[2])
SOURCE = Path(__file__).resolve().parents[2]
ROOT = SCRATCH / "root"
COMPONENTS = {"program": "batten", "dev": "libbatten-dev", "studio": "batten-studio", "freecad": "batten-freecad", "python": "python3-batten"}


def run(*command, **more):
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more)
    if done.returncode:
        raise AssertionError(f"{' '.join(map(str, command))} ended with {done.returncode}:\n{done.stdout}")
    return done.stdout


def built():
    """The packages for which this build has the parts."""
    missing = set()
    if not (BUILD / "bin/batten-studio").exists():
        missing.add("studio")
    if not (BUILD / "python/batten").exists():
        missing.add("python")
    return [component for component in COMPONENTS if component not in missing]


class Packages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        shutil.rmtree(SCRATCH, ignore_errors=True)
        ROOT.mkdir(parents=True)
        run("cpack", "-G", "DEB", "-B", SCRATCH, "-D", f"CPACK_PACKAGE_DIRECTORY={SCRATCH}", "-D", "CPACK_DEBIAN_COMPRESSION_TYPE=gzip",
            "-D", "CPACK_COMPONENTS_ALL=" + ";".join(built()), cwd=BUILD)
        cls.debs = {deb.name.split("_")[0]: deb for deb in SCRATCH.glob("*.deb")}
        for deb in cls.debs.values():
            run("dpkg-deb", "-x", deb, ROOT)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(SCRATCH, ignore_errors=True)

    def test_there_is_a_package_for_each_part(self):
        self.assertEqual(set(self.debs), {COMPONENTS[component] for component in built()})
        for name, deb in self.debs.items():
            depends = run("dpkg-deb", "-f", deb, "Depends")
            self.assertIn({"batten-freecad": "freecad", "libbatten-dev": "libeigen3-dev"}.get(name, "libc6"), depends, name)

    def test_programs_use_the_library_of_its_package(self):
        run("cmake", "-D", f"BUILD={BUILD}", "-D", f"SOURCE={SOURCE}", "-D", "GENERATOR=Ninja", "-D", f"PREFIX={ROOT / 'usr'}",
            "-D", "COMPONENTS=scenes", "-P", SOURCE / "tests/project/consumer.cmake")

    def test_the_program_makes_an_example_of_its_package(self):
        if not os.environ.get("DISPLAY") and not shutil.which("Xvfb"):
            self.skipTest("no X server: the example has pictures")
        scene = ROOT / "usr/share/doc/batten/examples/01-pentagon/scene.toml"
        run(ROOT / "usr/bin/batten", "run", scene, "--out", SCRATCH / "made", "--quiet")
        made = {file.suffix for file in (SCRATCH / "made").iterdir()}
        self.assertLessEqual({".step", ".json"}, made)  # STEP: by the CAD module

    def test_python_finds_the_package(self):
        if "python3-batten" not in self.debs:
            self.skipTest("no Python package in this build")
        words = run("/usr/bin/python3", "-c", "import batten, sys\n"
                    "model = batten.skin({'rim': [[0, 0, 0], [1, 0, 0], [1, 1, 0.2], [0, 1, 0], [0, 0, 0]]})\n"
                    f"assert model.save({str(SCRATCH / 'rim.step')!r}) == []\n"
                    "print(batten.__file__)", env={**os.environ, "PYTHONPATH": str(ROOT / "usr/lib/python3/dist-packages")})
        self.assertIn(str(ROOT), words)
        self.assertTrue((SCRATCH / "rim.step").exists())

    def test_the_window_and_the_workbench_are_where_others_look(self):
        self.assertTrue((ROOT / "usr/share/freecad/Mod/Batten/InitGui.py").exists())
        if "batten-studio" in self.debs:
            for file in ("applications/batten-studio.desktop", "mime/packages/batten-studio.xml", "batten/door/scene.toml"):
                self.assertTrue((ROOT / "usr/share" / file).exists(), file)
            self.assertIn("Usage: batten-studio", run(ROOT / "usr/bin/batten-studio", "--help"))


if __name__ == "__main__":
    for tool in ("cpack", "dpkg-deb", "dpkg-shlibdeps"):
        if not shutil.which(tool):
            print(f"{tool} is not there: packages are not tested")
            sys.exit(77)
    unittest.main(argv=sys.argv[:1])
