# SPDX-License-Identifier: MPL-2.0
"""The pages of the guide for Doxygen, from README.md, docs/ and examples/.

usage: docs_pages.py FOLDER           writes the pages there
       docs_pages.py --check HTML     links and images of the site must be there

Every page gets a name of its own, so that links between them are found; pictures go to one folder, with their folder in their
name. The page of an example ends with its commands in Python, its scenes and programs.
"""
import re
import shutil
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")
CODE = {".toml": "toml", ".cpp": "cpp", ".py": "py"}
MOST_LINES = 200  # of a scene or program on a page


def pages():
    """Source files of pages, in the order of the guide."""
    return [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), *sorted((ROOT / "docs/theory").glob("*.md")),
            *sorted((ROOT / "examples").glob("*/README.md")), ROOT / "benchmarks/README.md", ROOT / "CHANGELOG.md"]


def page_name(file):
    relative = file.relative_to(ROOT)
    if relative == Path("README.md"):
        return "README.md"
    return "-".join(relative.parts[:-1] + ((relative.stem,) if relative.stem != "README" else ())) + ".md"


def identifier(file):
    return "page-" + page_name(file)[:-3].lower()


def links_of(text, file, known, folder):
    """The text with links to other pages and pictures as the site has them; links to other files become words."""

    def replaced(found):
        image, words, target = found.groups()
        if re.match(r"[a-z]+:|#", target):
            return found.group(0)
        path = (file.parent / target.split("#")[0]).resolve()
        if path.is_dir():
            path = path / "README.md"
        if image and path.exists():
            name = "-".join(path.relative_to(ROOT).parts)
            shutil.copy(path, folder / "images" / name)
            return f"![{words}]({name})"
        return f"[{words}](@ref {identifier(path)})" if path in known else words

    return LINK.sub(replaced, text)


def in_python(text):
    """The commands of an example as calls of the Python package; those with options that it does not have are left out."""
    calls = []
    for found in re.finditer(r"\bbatten (run|deform|sequence|stress) (\S+\.toml)((?: --(?:out|set) \S+)*) *(?:#.*)?$", text, re.MULTILINE):
        verb, scene, options = found.groups()
        out = re.search(r"--out (\S+)", options)
        values = re.findall(r"--set (\S+)=(\S+)", options)
        if out and not (values and verb == "sequence"):
            more = f", values={{{', '.join(f'{chr(34)}{name}{chr(34)}: {value}' for name, value in values)}}}" if values else ""
            call = f'batten.{verb}("{scene}", "{out.group(1)}"{more})'
            for name in re.findall(r"\$(\w+)", scene):  # of a loop of the shell
                words = re.findall(rf"for {name} in ([^;]+); do", text[:found.start()])[-1].split()
                named = call.replace(f"${name}", f"{{{name}}}").replace('("', '(f"').replace(', "', ', f"')
                call = f"for {name} in {words}:\n    {named}"
            calls += call.split("\n")
    return ["## In Python", "", "```{.py}", "import batten", "", *calls, "```", ""] if calls else []


def lesson_code(file):
    """The same in Python; scenes and programs of an example."""
    parts = in_python(file.read_text(encoding="utf-8"))
    for source in sorted(file.parent.iterdir()):
        lines = source.read_text(encoding="utf-8").splitlines() if source.suffix in CODE else []
        if lines and len(lines) <= MOST_LINES:
            parts += [f"## {source.name}", "", f"```{{.{CODE[source.suffix]}}}", *lines, "```", ""]
    return "\n".join(parts)


def write(folder):
    (folder / "images").mkdir(parents=True)
    shutil.copy(ROOT / "cmake/packages/batten-studio.svg", folder / "logo.svg")
    known = set(pages())
    for file in pages():
        text = file.read_text(encoding="utf-8")
        if file.parent.parent.name == "examples":
            text += "\n\n" + lesson_code(file)
        text = links_of(text, file, known, folder)
        title, _, rest = text.partition("\n")
        if file != ROOT / "README.md":
            title = f"{title.replace('`', '')} {{#{identifier(file)}}}"
        (folder / page_name(file)).write_text(title + "\n" + rest, encoding="utf-8")


def check(html):
    """Every image and every local link of the guide's pages leads to a file."""
    missing = set()
    files = [*html.glob("page-*.html"), html / "index.html"]
    for file in files:
        text = file.read_text(encoding="utf-8")
        for target in re.findall(r'(?:src|href)="([^"#:]+)(?:#[^"]*)?"', text):
            if not (html / target).exists():
                missing.add(f"{file.name}: {target}")
    print(f"{len(files)} pages, {len(list(html.glob('*.html')))} with the headers'")
    for one in sorted(missing):
        print("missing:", one)
    return 1 if missing or len(files) < 40 else 0


if __name__ == "__main__":
    if sys.argv[1] == "--check":
        sys.exit(check(Path(sys.argv[2])))
    write(Path(sys.argv[1]))
