# SPDX-License-Identifier: MPL-2.0
"""Bill of materials of a release as SPDX 2.3 JSON; scripts/release calls it.

usage: sbom.py VERSION BUILD ARCHIVE_FOLDER DIST    writes DIST/batten-VERSION.spdx.json, and checks it
       sbom.py --check FILE                         checks a file

It lists the files of the release, the Debian packages whose files the archive contains, and those whose headers are
compiled into the programs, with versions, sources and licences. The date is that of SOURCE_DATE_EPOCH.
"""
import datetime
import hashlib
import json
import os
import re
import sys
import urllib.parse
import uuid
from pathlib import Path

from debian import header_packages, licence_of, package_facts

NOTHING = "NOASSERTION"
RELATIONSHIPS = ("DESCRIBES", "CONTAINS", "GENERATED_FROM", "STATIC_LINK")


def digest(file, algorithm):
    with open(file, "rb") as stream:
        return hashlib.file_digest(stream, algorithm).hexdigest()


def checksums(file, *algorithms):
    return [{"algorithm": a.upper(), "checksumValue": digest(file, a)} for a in algorithms]


def identifier(kind, name):
    return f"SPDXRef-{kind}-" + re.sub(r"[^A-Za-z0-9.-]", "-", name)


def package(spdx_id, name, version, licence, **more):
    return {"SPDXID": spdx_id, "name": name, "versionInfo": version, "downloadLocation": NOTHING, "filesAnalyzed": False,
            "licenseConcluded": licence, "licenseDeclared": licence, "copyrightText": NOTHING, **more}


def debian_package(fact):
    url = (f"pkg:deb/debian/{fact['name']}@{urllib.parse.quote(fact['version'], safe='')}"
           f"?arch={fact['architecture']}&distro=debian-12")
    more = {"homepage": fact["homepage"]} if fact["homepage"] else {}
    return package(identifier("deb", fact["name"]), fact["name"], fact["version"], licence_of(fact["name"]),
                   supplier="Organization: Debian",
                   sourceInfo=f"built from the Debian source package {fact['source']} {fact['source_version']}",
                   externalRefs=[{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl", "referenceLocator": url}],
                   **more)


class Document:
    def __init__(self, version):
        self.version = version
        self.packages, self.files, self.relationships = [], [], []

    def relate(self, subject, kind, other):
        self.relationships.append({"spdxElementId": subject, "relationshipType": kind, "relatedSpdxElement": other})

    def add_release(self, dist):
        """The source and the files of a release. Returns the identifier of the relocatable archive."""
        self.packages.append(package("SPDXRef-batten", "batten", self.version, "MPL-2.0",
                                     primaryPackagePurpose="SOURCE", supplier="Organization: Batten developers"))
        self.relate("SPDXRef-DOCUMENT", "DESCRIBES", "SPDXRef-batten")
        archive = None
        for file in sorted(dist.iterdir()):
            name = file.name
            if not name.endswith((".deb", ".xz", ".gz")):
                continue
            spdx_id = identifier("file", name)
            has_binaries = not name.endswith((".gz", "_all.deb"))  # which are linked with libraries under the GPL
            licence = "GPL-3.0-or-later" if has_binaries else "MPL-2.0"
            self.packages.append(package(spdx_id, name, self.version, licence, packageFileName=name,
                                         checksums=checksums(file, "sha256"),
                                         supplier="Organization: Batten developers"))
            self.relate("SPDXRef-DOCUMENT", "DESCRIBES", spdx_id)
            self.relate(spdx_id, "GENERATED_FROM", "SPDXRef-batten")
            if name.endswith("linux-x86_64.tar.xz"):
                archive = spdx_id
        return archive

    def add_bundled(self, folder, archive, headers):
        """Packages whose files an archive contains, and packages whose headers are compiled in."""
        rows = [line.split("\t") for line in (folder / "share/doc/bundled-files.tsv").read_text().splitlines()[1:]]
        bundled = {row[1] for row in rows}
        for fact in package_facts(bundled | headers):
            self.packages.append(debian_package(fact))
            spdx_id = identifier("deb", fact["name"])
            if fact["name"] in bundled:
                self.relate(archive, "CONTAINS", spdx_id)
            if fact["name"] in headers:
                self.relate(archive, "STATIC_LINK", spdx_id)
        for name, owner, *_ in rows:
            if (folder / name).is_dir():
                continue
            spdx_id = identifier("bundled", name)
            self.files.append({"SPDXID": spdx_id, "fileName": f"./{name}",
                               "checksums": checksums(folder / name, "sha1", "sha256"), "copyrightText": NOTHING,
                               "licenseConcluded": licence_of(owner), "licenseInfoInFiles": [NOTHING]})
            self.relate(identifier("deb", owner), "CONTAINS", spdx_id)

    def json(self):
        date = datetime.datetime.fromtimestamp(int(os.environ["SOURCE_DATE_EPOCH"]), datetime.timezone.utc)
        contents = json.dumps([self.packages, self.files], sort_keys=True)
        return {"spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT",
                "name": f"batten-{self.version}",
                "documentNamespace": f"https://spdx.org/spdxdocs/batten-{self.version}-{uuid.uuid5(uuid.NAMESPACE_OID, contents)}",
                "creationInfo": {"created": date.strftime("%Y-%m-%dT%H:%M:%SZ"),
                                 "creators": ["Organization: Batten developers", "Tool: scripts/sbom.py"]},
                "packages": self.packages, "files": self.files, "relationships": self.relationships}


def licence_problems(expression, where):
    names = re.findall(r"[^\s()]+", expression)
    wrong = [n for n in names if n not in ("AND", "OR", "WITH", NOTHING) and not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9.+-]*", n)]
    return [f"{where}: licence '{expression}'"] if wrong or not names else []


def problems(document):
    """What is wrong with a document by the rules of SPDX 2.3 that this script could break."""
    found = []
    required = {"packages": ["SPDXID", "name", "versionInfo", "downloadLocation", "licenseDeclared"],
                "files": ["SPDXID", "fileName", "checksums", "licenseConcluded"]}
    ids = ["SPDXRef-DOCUMENT"]
    for kind, keys in required.items():
        for element in document[kind]:
            where = element.get("SPDXID", "?")
            ids.append(where)
            found += [f"{where}: no {key}" for key in keys if not element.get(key)]
            found += licence_problems(element.get("licenseConcluded", ""), where)
            for sum_ in element.get("checksums", []):
                length = {"SHA1": 40, "SHA256": 64}[sum_["algorithm"]]
                if not re.fullmatch(f"[0-9a-f]{{{length}}}", sum_["checksumValue"]):
                    found.append(f"{where}: {sum_['algorithm']} {sum_['checksumValue']}")
    found += [f"{i} is not an identifier" for i in ids if not re.fullmatch(r"SPDXRef-[A-Za-z0-9.-]+", i)]
    found += [f"{i} twice" for i in sorted({i for i in ids if ids.count(i) > 1})]
    related = set()
    for relation in document["relationships"]:
        ends = [relation["spdxElementId"], relation["relatedSpdxElement"]]
        related.update(ends)
        found += [f"relationship with unknown {end}" for end in ends if end not in ids]
        if relation["relationshipType"] not in RELATIONSHIPS:
            found.append(f"relationship {relation['relationshipType']}")
    found += [f"{i} is not related to anything" for i in ids if i not in related]
    return found


def main(arguments):
    if arguments[0] == "--check":
        document = json.loads(Path(arguments[1]).read_text())
    else:
        version, (build, folder, dist) = arguments[0], map(Path, arguments[1:])
        made = Document(version)
        archive = made.add_release(dist)
        made.add_bundled(folder, archive, header_packages(build))
        document = made.json()
        (dist / f"batten-{version}.spdx.json").write_text(json.dumps(document, indent=1) + "\n")
    if found := problems(document):
        raise SystemExit("bill of materials: " + "\n".join(found))
    print(f"bill of materials: {len(document['packages'])} packages, {len(document['files'])} files")


if __name__ == "__main__":
    main(sys.argv[1:])
