#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Draws random comments of public headers, or random sentences of the documents, for readers to judge.

    tests/project/sample_text.py comments|sentences [--count 100] [--seed 1]

Prints one numbered item per paragraph, with its file and line. The same seed draws the same items from
the same tree. Public headers are those that CMake installs (HEADERS of batten_library).
"""
import argparse
import pathlib
import random
import re

ROOT = pathlib.Path(__file__).resolve().parents[2]


def public_headers():
    """Paths of all installed headers, sorted."""
    found = set()
    for lists in ROOT.glob("[a-z]*/**/CMakeLists.txt"):
        if lists.is_relative_to(ROOT / "build"):
            continue
        for call in re.findall(r"batten_library\(((?:[^()]|\([^()]*\))*)\)", lists.read_text()):
            headers = re.search(r"\bHEADERS\b(.*?)(?:\bLINKS\b|\bPRIVATE_LINKS\b|$)", call, re.S)
            for name in headers.group(1).split() if headers else []:
                if (lists.parent / name).exists():
                    found.add(lists.parent / name)
    return sorted(found)


def comments():
    """(place, text) of each block of /// and // comments above a declaration, and of trailing ones."""
    for header in public_headers():
        block, begin = [], 0
        for number, line in enumerate(header.read_text().splitlines(), 1):
            text = line.strip()
            comment = re.match(r"///?\s?(.*)", text)
            if comment and not text.startswith("///<"):
                begin = begin if block else number
                block.append(comment.group(1))
                continue
            if len(" ".join(block).split()) > 3:
                yield f"{header.relative_to(ROOT)}:{begin}", "\n".join(block) + f"\n    > {text}"
            block = []
            trailing = re.match(r"(.*?)\s*///<\s*(.*)", text)
            if trailing and len(trailing.group(2).split()) > 2:
                yield f"{header.relative_to(ROOT)}:{number}", f"{trailing.group(2)}\n    > {trailing.group(1)}"


def sentences():
    """(place, text) of each sentence of more than four words, outside of code and tables."""
    files = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md")),
             *sorted((ROOT / "examples").glob("*/README.md"))]
    for file in files:
        paragraph, begin, fenced = [], 0, False
        for number, line in enumerate([*file.read_text().splitlines(), ""], 1):
            if line.lstrip().startswith("```"):
                fenced = not fenced
            prose = line.strip() and not fenced and not re.match(r"(\s{4,}|\s*([|#<]|!\[|```))", line)
            item = re.match(r"\s*([-*]|\d+\.)\s", line)
            if paragraph and (not prose or item):
                for sentence in re.split(r"(?<=[.!?:])\s+(?=[A-Z*`\[])", " ".join(paragraph)):
                    if len(sentence.split()) > 4:
                        yield f"{file.relative_to(ROOT)}:{begin}", sentence
                paragraph = []
            if prose:
                begin = begin if paragraph else number
                paragraph.append(line.strip())


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("kind", choices=["comments", "sentences"])
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    items = list(comments() if options.kind == "comments" else sentences())
    drawn = random.Random(options.seed).sample(items, min(options.count, len(items)))
    for number, (place, text) in enumerate(drawn, 1):
        print(f"{number}. {place}\n{text}\n")
    print(f"{len(drawn)} of {len(items)} {options.kind}, seed {options.seed}")


main()
