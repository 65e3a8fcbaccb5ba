# SPDX-License-Identifier: MPL-2.0
"""Debian packages of files: which packages a build was made from, and what dpkg knows about them."""
import csv
import fnmatch
import os
import re
import subprocess
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[1]
# glibc, which every Linux system has, and what the kernel provides.
GLIBC = re.compile(r"^(ld-linux-x86-64|libc|libm|libdl|libpthread|librt|libresolv|libutil|libmvec|libanl|libnsl|libnss_\w+|"
                   r"linux-vdso)\.so(\.\d+)?$")


def run(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def needed_libraries(file):
    """{soname: path} of all shared libraries that a file needs, directly or not, without glibc."""
    libraries = {}
    for line in run("ldd", str(file)).splitlines():
        if "not found" in line:
            raise SystemExit(f"{file}: {line.strip()}")
        words = line.split()
        if len(words) > 2 and words[1] == "=>" and not GLIBC.match(words[0]):
            libraries[words[0]] = Path(words[2])
    return libraries


def owners_of(files):
    """{file: package} by dpkg's database; None for files that belong to no package."""
    spellings = {}  # /lib and /usr/lib are one folder, and dpkg knows a file under one of the names
    for file in files:
        real = os.path.realpath(file)
        for name in {real, real.removeprefix("/usr"), f"/usr{real}"}:
            spellings[name] = file
    output = subprocess.run(["dpkg-query", "-S", *spellings], capture_output=True, text=True).stdout
    packages = dict.fromkeys(files)
    for line in output.splitlines():
        owner, _, name = line.partition(": ")
        if name in spellings and not owner.startswith("diversion"):
            packages[spellings[name]] = owner.split(",")[0].split(":")[0]
    return packages


def package_of(files):
    """{file: package} by dpkg's database; files that belong to no package are an error."""
    packages = owners_of(files)
    if missing := sorted(str(file) for file, package in packages.items() if not package):
        raise SystemExit("no Debian package has " + ", ".join(missing[:5]))
    return packages


def package_facts(packages):
    """[{name, version, architecture, source, source_version, homepage}], sorted by name."""
    keys = ["name", "version", "architecture", "source", "source_version", "homepage"]
    fields = r"${Package}\t${Version}\t${Architecture}\t${source:Package}\t${source:Version}\t${Homepage}\n"
    lines = run("dpkg-query", "-W", f"-f={fields}", *sorted(packages)).splitlines()
    facts = {}
    for line in lines:
        fact = dict(zip(keys, line.split("\t")))
        if fact["architecture"] in ("amd64", "all"):
            facts[fact["name"]] = fact
    return [facts[name] for name in sorted(facts)]


def header_packages(build):
    """Packages whose headers are compiled into the libraries and programs of a build, without those of the C library."""
    headers, product = set(), False
    for line in run("ninja", "-C", str(build), "-t", "deps").splitlines():
        if not line.startswith(" "):
            product = not line.startswith(("tests/", "benchmarks/", "examples/", "apps/python/"))
        elif product and line.strip().startswith("/usr/include/"):
            headers.add(line.strip())
    return {p for p in package_of(headers).values() if not re.match(r"(libc6|linux-libc|libcrypt)-dev$", p)}


def copyright_text(package):
    return Path(f"/usr/share/doc/{package}/copyright").read_text(errors="replace")


def licence_of(package):
    """SPDX expression of a package, by the tables in cmake."""
    for table in ("packages/licences.csv", "archive/licences.csv"):
        lines = (SOURCE / "cmake" / table).read_text().splitlines()
        for row in csv.DictReader(line for line in lines if not line.startswith("#")):
            if fnmatch.fnmatchcase(package, row["package"]):
                return row["licence"]
    raise SystemExit(f"{package}: no licence in cmake/packages/licences.csv and cmake/archive/licences.csv")
