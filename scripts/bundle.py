# SPDX-License-Identifier: MPL-2.0
"""Makes an installed program independent of the system's libraries; scripts/archive calls it.

usage: bundle.py BUILD FOLDER

FOLDER/libexec is an installation of the build folder BUILD. Every shared library but those of glibc is copied to
libexec/lib, an X server with its keyboard data and Mesa's software driver to libexec/lib/batten/xvfb, plugins of Qt to
libexec/plugins. All find each other relative to their own folder. Licences go to FOLDER/share/doc/licences, and
FOLDER/share/doc/bundled-files.tsv lists each copied file with its package.
"""
import os
import re
import shutil
import sys
from pathlib import Path

from debian import GLIBC, copyright_text, header_packages, needed_libraries, package_facts, package_of, run

XVFB = "lib/batten/xvfb"  # where the program looks for it, and for drivers of Mesa in its folder lib/dri
SYSTEM = Path("/usr/lib/x86_64-linux-gnu")
NEWEST_GLIBC = (2, 36)
QT_PLUGINS = ["platforms/libqxcb.so", "xcbglintegrations/libqxcb-glx-integration.so",
              "platforminputcontexts/libcomposeplatforminputcontextplugin.so"]
FONTS = ["DejaVuSans.ttf", "DejaVuSans-Bold.ttf", "DejaVuSansMono.ttf"]


def is_elf(file):
    with open(file, "rb") as stream:
        return stream.read(4) == b"\x7fELF"


class Bundle:
    def __init__(self, folder):
        self.folder = folder
        self.libexec = folder / "libexec"
        self.copied = {}  # file in the folder: file of the system

    def copy(self, source, name):
        target = self.libexec / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(os.path.realpath(source), target)
        target.chmod(target.stat().st_mode | 0o200)
        self.copied[target] = Path(source)
        return target

    def copy_libraries(self, files, subfolder):
        """Copies the libraries that files of the system need, unless they are there."""
        for file in files:
            for soname, path in needed_libraries(file).items():
                if not (self.libexec / "lib" / soname).exists() and not (self.libexec / subfolder / soname).exists():
                    self.copy(path, f"{subfolder}/{soname}")

    def elf_files(self):
        return [f for f in sorted(self.libexec.rglob("*")) if f.is_file() and not f.is_symlink() and is_elf(f)]


def copy_all(bundle):
    installed = bundle.elf_files()
    x11 = [Path("/usr/bin/Xvfb"), Path("/usr/bin/xkbcomp")]
    has_studio = (bundle.libexec / "bin/batten-studio").exists()
    plugins = [SYSTEM / "qt5/plugins" / p for p in QT_PLUGINS] if has_studio else []
    bundle.copy_libraries(installed + x11 + plugins, "lib")
    cxx = os.path.realpath(bundle.copied[bundle.libexec / "lib/libstdc++.so.6"])
    (bundle.libexec / "lib/libstdc++.version").write_text(cxx.rpartition(".")[2] + "\n")
    for plugin, name in zip(plugins, QT_PLUGINS):
        bundle.copy(plugin, f"plugins/{name}")
    bundle.copy(x11[0], f"{XVFB}/bin/Xvfb.bin")
    bundle.copy(x11[1], f"{XVFB}/bin/xkbcomp")
    shutil.copytree("/usr/share/X11/xkb", bundle.libexec / XVFB / "share/xkb")
    bundle.copied[bundle.libexec / XVFB / "share/xkb"] = Path("/usr/share/X11/xkb/rules/evdev")

    # libGL asks for the driver by name (__GLX_VENDOR_LIBRARY_NAME): under a name of its own it never replaces the system's.
    mesa = [SYSTEM / "libGLX_mesa.so.0", SYSTEM / "dri/swrast_dri.so"]
    bundle.copy_libraries(mesa, f"{XVFB}/lib")
    vendor = bundle.copy(mesa[0], f"{XVFB}/lib/libGLX_batten.so.0")
    run("patchelf", "--set-soname", vendor.name, str(vendor))
    bundle.copy(mesa[1], f"{XVFB}/lib/dri/swrast_dri.so")
    if has_studio:
        for font in FONTS:
            bundle.copy(f"/usr/share/fonts/truetype/dejavu/{font}", f"share/fonts/{font}")


def find_xkbcomp_on_path(xvfb):
    """Xvfb starts /usr/bin/xkbcomp by the shell; without the folder it starts the one on PATH."""
    data = xvfb.read_bytes()
    if data.count(b"\0/usr/bin\0") != 1 or data.count(b'"%s%sxkbcomp"') != 1:
        raise SystemExit(f"{xvfb}: found another Xvfb than expected: its folder of xkbcomp cannot be changed")
    xvfb.write_bytes(data.replace(b"\0/usr/bin\0", b"\0\0usr/bin\0"))


def set_search_paths(bundle):
    """DT_RPATH, which precedes LD_LIBRARY_PATH: libraries of other versions on that path are not loaded."""
    lib, mesa = bundle.libexec / "lib", bundle.libexec / XVFB / "lib"
    for file in bundle.elf_files():
        folders = [lib]
        if mesa in file.parents:
            folders.insert(0, mesa)
        elif file.name == "libGLX.so.0":
            folders.append(mesa)
        paths = [os.path.join("$ORIGIN", os.path.relpath(f, file.parent)) for f in folders]
        run("patchelf", "--force-rpath", "--set-rpath", ":".join(p.removesuffix("/.") for p in paths), str(file))


def check(bundle):
    """Every library is found in the folder, or is glibc's, and nothing needs a newer glibc."""
    problems = []
    for file in bundle.elf_files():
        for line in run("/lib64/ld-linux-x86-64.so.2", "--list", str(file)).splitlines():
            name, _, path = line.strip().partition(" => ")
            if path and not GLIBC.match(name) and not path.startswith(f"{bundle.folder}/"):
                problems.append(f"{file.relative_to(bundle.folder)} uses {path}")
        for version in re.findall(r"\bGLIBC_(\d+)\.(\d+)", run("readelf", "-VW", str(file))):
            if tuple(map(int, version)) > NEWEST_GLIBC:
                problems.append(f"{file.relative_to(bundle.folder)} needs glibc {'.'.join(version)}")
    if problems:
        raise SystemExit("\n".join(sorted(set(problems))))


def write_licences(bundle, build):
    packages = package_of(bundle.copied.values())
    doc = bundle.folder / "share/doc"
    licences = doc / "licences"
    licences.mkdir(parents=True, exist_ok=True)
    shutil.copytree("/usr/share/common-licenses", licences / "common-licenses", dirs_exist_ok=True)
    for package in sorted(set(packages.values()) | header_packages(build)):
        (licences / f"{package}.txt").write_text(copyright_text(package))
    facts = {fact["name"]: fact for fact in package_facts(set(packages.values()))}
    with open(doc / "bundled-files.tsv", "w") as table:
        table.write("file\tpackage\tversion\tsource package\tsource version\n")
        for target, source in sorted(bundle.copied.items()):
            fact = facts[packages[source]]
            table.write("\t".join([str(target.relative_to(bundle.folder)), fact["name"], fact["version"], fact["source"],
                                   fact["source_version"]]) + "\n")


def main():
    build, folder = (Path(a).resolve() for a in sys.argv[1:])
    bundle = Bundle(folder)
    copy_all(bundle)
    find_xkbcomp_on_path(bundle.libexec / XVFB / "bin/Xvfb.bin")
    set_search_paths(bundle)
    check(bundle)
    write_licences(bundle, build)
    print(f"{len(bundle.elf_files())} programs and libraries in {folder}")


if __name__ == "__main__":
    main()
