# SPDX-License-Identifier: MPL-2.0
"""The stubs match the module: every name, and every argument with its order, kind and default."""

import ast
import inspect
import os
import subprocess
import sys
import unittest

from properties import PropertyTests, batten, example


def arguments_of(function):
    """(name, keyword only, has a default) of each argument of a parsed function."""
    a = function.args
    early = [None] * (len(a.args) - len(a.defaults)) + a.defaults
    return [(x.arg, False, d is not None) for x, d in zip(a.args, early) if x.arg != "self"] + \
        [(x.arg, True, d is not None) for x, d in zip(a.kwonlyargs, a.kw_defaults)] + \
        ([(a.kwarg.arg, False, False)] if a.kwarg else [])


def signature_of(function):
    """(name, keyword only, has a default) of each argument as inspect reads them, or None."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return None
    if any(p.kind == p.VAR_POSITIONAL for p in parameters):  # of a class without constructor
        return None
    return [(p.name, p.kind == p.KEYWORD_ONLY, p.default is not p.empty) for p in parameters if p.name != "self"]


def members_of_module(owner, names):
    found = {}
    for name in names:
        thing = getattr(owner, name)
        if isinstance(thing, property):
            found[name] = "property"
        elif callable(thing):
            found[name] = signature_of(thing) or []
    return found


def members_of_stub(body):
    found = {}
    for node in body:
        if isinstance(node, ast.FunctionDef):
            decorators = [d.id for d in node.decorator_list if isinstance(d, ast.Name)]
            found[node.name] = "property" if "property" in decorators else arguments_of(node)
    return found


class Stubs(PropertyTests):
    def setUp(self):
        super().setUp()
        folder = os.path.dirname(batten.__file__)
        self.assertTrue(os.path.exists(os.path.join(folder, "py.typed")))
        with open(os.path.join(folder, "_batten.pyi")) as stub:
            self.body = ast.parse(stub.read()).body
        self.classes = {node.name: node for node in self.body if isinstance(node, ast.ClassDef)}

    def test_functions(self):
        names = [n for n in dir(batten._batten) if not n.startswith("_") and
                 not isinstance(getattr(batten._batten, n), type)]
        self.assertEqual(members_of_stub(self.body), members_of_module(batten._batten, names))

    def test_classes(self):
        classes = {n: c for n, c in vars(batten._batten).items() if isinstance(c, type)}
        self.assertEqual(set(self.classes), set(classes))
        for name, cls in classes.items():
            if issubclass(cls, Exception):
                self.assertEqual([base.id for base in self.classes[name].bases],
                                 [base.__name__ for base in cls.__bases__])
                continue
            special = {"__contains__", "__getitem__", "__iter__", "__len__", "__setitem__"}
            names = [n for n in vars(cls) if not n.startswith("_") or n in special]
            if cls.__init__ is not object.__init__ and signature_of(cls.__init__) is not None:
                names.append("__init__")
            self.assertEqual(members_of_stub(self.classes[name].body), members_of_module(cls, names), name)

    def test_mypy_accepts_the_stubs_and_the_example(self):
        if subprocess.run([sys.executable, "-m", "mypy", "--version"], capture_output=True).returncode:
            self.skipTest("mypy is not there")
        done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir", self.folder,
                               os.path.join(os.path.dirname(batten.__file__), "_batten.pyi"), example("31-python", "glass.py")],
                              env={**os.environ, "MYPYPATH": os.path.dirname(os.path.dirname(batten.__file__))},
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_everything_public_is_in_the_package_and_has_words(self):
        public = {n for n in dir(batten._batten) if not n.startswith("_")}
        self.assertEqual(public, set(batten.__all__))
        for name in public:
            self.assertTrue(getattr(batten, name).__doc__, name)


if __name__ == "__main__":
    unittest.main()
