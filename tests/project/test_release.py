# SPDX-License-Identifier: MPL-2.0
"""The bill of materials of a release: its form, what it lists, and that its check finds errors.

usage: test_release.py SCRATCH
"""
import copy
import hashlib
import json
import os
import shutil
import sys
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
SCRATCH = Path(sys.argv[1])
sys.path.insert(0, str(SOURCE / "scripts"))
os.environ["SOURCE_DATE_EPOCH"] = "1700000000"

import debian  # noqa: E402
import sbom  # noqa: E402

ARCHIVE = "batten-1.2.3-linux-x86_64.tar.xz"


def release():
    """A release of two files, whose archive contains one library; one package of headers is compiled in."""
    shutil.rmtree(SCRATCH, ignore_errors=True)
    dist, folder = SCRATCH / "dist", SCRATCH / "folder"
    (folder / "share/doc").mkdir(parents=True)
    (folder / "lib").mkdir()
    dist.mkdir()
    (folder / "lib/libc.so").write_bytes(b"a library")
    (folder / "share/doc/bundled-files.tsv").write_text(
        "file\tpackage\tversion\tsource package\tsource version\nlib/libc.so\tlibc6\t2\tglibc\t2\n")
    (dist / ARCHIVE).write_bytes(b"an archive")
    (dist / "batten-1.2.3.tar.gz").write_bytes(b"a source archive")
    document = sbom.Document("1.2.3")
    document.add_bundled(folder, document.add_release(dist), {"libeigen3-dev"})
    return json.loads(json.dumps(document.json()))


class BillOfMaterials(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.document = release()

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(SCRATCH, ignore_errors=True)

    def test_it_has_no_errors(self):
        self.assertEqual(sbom.problems(self.document), [])
        self.assertEqual(self.document["creationInfo"]["created"], "2023-11-14T22:13:20Z")

    def test_it_lists_files_with_checksums_and_packages_with_versions(self):
        packages = {p["name"]: p for p in self.document["packages"]}
        self.assertEqual(set(packages), {"batten", ARCHIVE, "batten-1.2.3.tar.gz", "libc6", "libeigen3-dev"})
        self.assertEqual(packages[ARCHIVE]["checksums"][0]["checksumValue"], hashlib.sha256(b"an archive").hexdigest())
        self.assertEqual(packages["libeigen3-dev"]["versionInfo"],
                         debian.run("dpkg-query", "-W", "-f=${Version}", "libeigen3-dev"))
        self.assertEqual(packages["libeigen3-dev"]["licenseDeclared"], "MPL-2.0")
        self.assertEqual(packages["batten-1.2.3.tar.gz"]["licenseDeclared"], "MPL-2.0")
        self.assertEqual(packages[ARCHIVE]["licenseDeclared"], "GPL-3.0-or-later")

    def test_the_archive_contains_libraries_and_headers(self):
        relations = {(r["relationshipType"], r["spdxElementId"], r["relatedSpdxElement"]) for r in self.document["relationships"]}
        archive = sbom.identifier("file", ARCHIVE)
        self.assertIn(("CONTAINS", archive, "SPDXRef-deb-libc6"), relations)
        self.assertIn(("STATIC_LINK", archive, "SPDXRef-deb-libeigen3-dev"), relations)
        self.assertIn(("CONTAINS", "SPDXRef-deb-libc6", "SPDXRef-bundled-lib-libc.so"), relations)

    def test_the_check_finds_each_error(self):
        def broken(change):
            document = copy.deepcopy(self.document)
            change(document)
            return sbom.problems(document)

        self.assertTrue(broken(lambda d: d["packages"][0].update(licenseConcluded="GPL v3?")))
        self.assertTrue(broken(lambda d: d["packages"][0].pop("versionInfo")))
        self.assertTrue(broken(lambda d: d["packages"].append(d["packages"][0])))
        self.assertTrue(broken(lambda d: d["files"][0]["checksums"][0].update(checksumValue="12")))
        self.assertTrue(broken(lambda d: d["relationships"].pop()))
        self.assertTrue(broken(lambda d: d["relationships"][0].update(relatedSpdxElement="SPDXRef-nothing")))

    def test_a_package_without_a_known_licence_is_an_error(self):
        with self.assertRaises(SystemExit):
            debian.licence_of("a-package-that-is-in-no-table")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
