# SPDX-License-Identifier: MPL-2.0
"""Checks the links of the built site: files, anchors and pictures.

usage: check_links.py HTML [--no-cpp]

Pages of Doxygen (api/cpp) are targets, but their own links are not checked.
"""
import sys
from functools import lru_cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

HTML = Path(sys.argv[1]).resolve()
SKIPPED = "api/cpp/" if "--no-cpp" in sys.argv else None


class Page(HTMLParser):
    def __init__(self, file):
        super().__init__()
        self.links, self.anchors = [], set()
        self.feed(file.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if value and (name in ("id", "name")):
                self.anchors.add(value)
            if value and ((name == "href" and tag in ("a", "link")) or name == "src"):
                self.links.append(value)


@lru_cache(maxsize=None)
def page(file):
    return Page(file)


def error_of(file, link):
    parts = urlsplit(link)
    if parts.scheme or parts.netloc:
        return None if parts.scheme in ("http", "https", "mailto", "data", "javascript") else "unknown scheme"
    target = (file.parent / unquote(parts.path)).resolve() if parts.path else file
    if SKIPPED and target.is_relative_to(HTML / SKIPPED):
        return None
    if not target.is_file():
        return "no such file"
    if parts.fragment and target.suffix == ".html" and unquote(parts.fragment) not in page(target).anchors:
        return "no such anchor"
    return None


def main():
    files = [f for f in sorted(HTML.rglob("*.html")) if not f.is_relative_to(HTML / "api")]
    checked, wrong = 0, []
    for file in files:
        for link in page(file).links:
            checked += 1
            error = error_of(file, link)
            if error:
                wrong.append(f"{file.relative_to(HTML)}: {link}: {error}")
    print(f"{len(files)} pages, {checked} links checked, {len(wrong)} broken")
    print(*wrong, sep="\n", end="\n" if wrong else "")
    return 1 if wrong or len(files) < 60 else 0


if __name__ == "__main__":
    sys.exit(main())
