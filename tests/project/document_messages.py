# SPDX-License-Identifier: MPL-2.0
"""The messages in docs/troubleshooting.md are those of the program.

usage: document_messages.py SOURCE

A heading of one `text in backquotes` is a message. `…` and words in CAPITALS are placeholders; each text between
them occurs in a string of the sources.
"""
import re
import sys
from pathlib import Path

SOURCE = Path(sys.argv[1])
FOLDERS = ("apps", "core", "elements", "fem", "constraints", "analysis", "fairing", "skinning", "sculpting", "mesh", "io", "scenes")


def strings():
    """The string literals of the sources, with adjacent ones joined."""
    for folder in FOLDERS:
        for file in sorted((SOURCE / folder).rglob("*.[ch]*")) + sorted((SOURCE / folder).rglob("*.py")):
            text = re.sub(r'"\s*\+?\s*"', "", file.read_text(encoding="utf-8"))
            yield from re.findall(r'"((?:[^"\\\n]|\\.)*)"', text)


def main():
    known = "\n".join(strings()).replace('\\"', '"')
    page = (SOURCE / "docs/troubleshooting.md").read_text(encoding="utf-8")
    messages = re.findall(r"^### `([^`]+)`$", page, re.MULTILINE)
    failed = 0
    for message in messages:
        parts = [part.strip(" ,;:.()'=") for part in re.split(r"…|\b[A-Z]{2,}\b", message)]
        for part in filter(lambda text: len(text) > 3, parts):
            if part not in known:
                failed += 1
                print(f"docs/troubleshooting.md: no message contains '{part}': {message}")
    print(f"{len(messages)} messages, {failed} parts without a source")
    return 1 if failed or len(messages) < 40 else 0


if __name__ == "__main__":
    sys.exit(main())
