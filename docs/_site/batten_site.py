# SPDX-License-Identifier: MPL-2.0
"""Extension of Sphinx for the site: citations [Key2000], files of examples, help texts of the program."""
import importlib.util
import os
import re
import subprocess
from pathlib import Path

from docutils import nodes
from docutils.parsers.rst import Directive
from pybtex.plugin import register_plugin
from pybtex.style.formatting.unsrt import Style
from pybtex.style.labels import BaseLabelStyle
from pygments.lexers.special import TextLexer
from sphinx.addnodes import pending_xref
from sphinx.transforms import SphinxTransform

ROOT = Path(__file__).resolve().parent.parent.parent
CITATION = re.compile(r"\[([A-Z][A-Za-z]+\d{4}[a-z]?)\]")
LANGUAGES = {".toml": "toml", ".cpp": "cpp", ".py": "python", ".txt": "cmake"}
MOST_LINES = 200  # of a scene or program on the page of its example


class KeyLabels(BaseLabelStyle):
    def format_labels(self, entries):
        return [entry.key for entry in entries]


class BattenStyle(Style):
    default_label_style = KeyLabels


register_plugin("pybtex.style.formatting", "batten", BattenStyle)


class Citations(SphinxTransform):
    """Turns [Celniker1991] in running text into a link to the bibliography."""

    default_priority = 5

    def apply(self, **kwargs):
        for text in list(self.document.findall(nodes.Text)):
            if isinstance(text.parent, (nodes.literal, nodes.literal_block, nodes.reference, nodes.raw, nodes.title)):
                continue
            words = text.astext()
            parts, end = [], 0
            for found in CITATION.finditer(words):
                link = pending_xref("", nodes.inline("", found[0]), refdoc=self.env.docname, refdomain="cite", reftype="p",
                                    reftarget=found[1], refwarn=True)
                parts += [nodes.Text(words[end:found.start()]), link]
                end = found.end()
            if parts:
                text.parent.replace(text, [*parts, nodes.Text(words[end:])])


def add_files(app, docname, source):
    """Appends the scenes and programs of an example to its page."""
    file = ROOT / f"{docname}.md"
    if file.parent.parent.name != "examples":
        return
    parts = []
    for code in sorted(file.parent.iterdir()):
        if code.suffix in LANGUAGES and (code.suffix != ".txt" or code.name == "CMakeLists.txt"):
            if len(code.read_text(encoding="utf-8").splitlines()) <= MOST_LINES:
                parts.append(f"```{{literalinclude}} {code.name}\n:language: {LANGUAGES[code.suffix]}\n:caption: {code.name}\n```\n")
    if parts:
        source[0] += "\n\n## Files\n\n" + "\n".join(parts)


def add_python(app, docname, source):
    """Inserts the docstrings of the Python package, if it was built."""
    if docname != "docs/reference/python":
        return
    text = ":::{note}\nThis copy of the documents was built without the Python package; use `help(batten)` instead.\n:::"
    if importlib.util.find_spec("batten"):
        import batten

        functions = [name for name in batten.__all__ if not isinstance(getattr(batten, name), type)]
        errors = [name for name in batten.__all__ if name not in functions and issubclass(getattr(batten, name), Exception)]
        classes = [name for name in batten.__all__ if name not in functions + errors]
        parts = []
        for title, names, kind in (("Functions", functions, "function"), ("Classes", classes, "class"), ("Exceptions", errors, "exception")):
            parts.append(f"## {title}\n\n```{{eval-rst}}")
            parts += [f".. auto{kind}:: batten.{name}" + ("\n   :members:" if kind == "class" else "") + "\n" for name in names]
            parts.append("```\n")
        text = "\n".join(parts)
    source[0] = source[0].replace("```{batten-api}\n```", text)


class Help(Directive):
    """The help texts of the program and of its commands, each in a section."""

    def run(self):
        program = os.environ.get("BATTEN_PROGRAM", "")
        if not Path(program).is_file():
            words = "This copy of the documents was built without the program; run batten COMMAND --help instead."
            return [nodes.note("", nodes.paragraph("", words))]

        def help_of(*words):
            return subprocess.run([program, *words, "--help"], capture_output=True, text=True, check=True).stdout

        overview = help_of()
        found = [nodes.literal_block(overview, overview, language="text")]
        for command in re.findall(r"^  ([a-z][a-z-]*)  ", overview, re.MULTILINE):
            text = help_of(command)
            section = nodes.section(ids=[f"batten-{command}"], names=[f"batten-{command}"])
            section += [nodes.title("", "", nodes.literal("", f"batten {command}")), nodes.literal_block(text, text, language="text")]
            found.append(section)
        return found


def join_scripts(app, exception):
    """Debian 12 ships furo.js as a module that imports gumshoe; browsers do not load modules from a folder, so join the two."""
    scripts = Path(app.outdir) / "_static/scripts"
    furo = scripts / "furo.js"
    if exception or not furo.is_file():
        return
    text = furo.read_text(encoding="utf-8")
    if text.startswith("import Gumshoe from"):
        furo.write_text((scripts / "gumshoe-patched.js").read_text(encoding="utf-8") + text.partition("\n")[2], encoding="utf-8")


def setup(app):
    app.add_transform(Citations)
    app.connect("source-read", add_files)
    app.connect("source-read", add_python)
    app.connect("build-finished", join_scripts)
    app.add_lexer("csv", TextLexer)
    app.add_directive("batten-help", Help)
    return {"parallel_read_safe": True}
