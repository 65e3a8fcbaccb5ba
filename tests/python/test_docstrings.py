# SPDX-License-Identifier: MPL-2.0
"""The examples in the docstrings run and print what they state; every class and function has one."""

import doctest
import inspect
import os
import unittest
from importlib import import_module

from properties import SOURCE, PropertyTests, batten

# Conversions that need packages which are not installed everywhere.
NEEDS = {"to_meshio": "meshio", "to_vtk": "vtkmodules"}
# Without an example, or with members without words.
EXEMPT = {"FeatureRegions", "Hole", "Mesh", "MeshEdit", "Move", "OnPlane", "measure_hole", "read_mesh", "stress"}


def documented():
    """(name, docstring) of the public classes, their methods and properties, and of the functions."""
    for name in batten.__all__:
        thing = getattr(batten, name)
        yield name, thing.__doc__
        if isinstance(thing, type) and not issubclass(thing, Exception):
            for part, value in vars(thing).items():
                if not part.startswith("_") or part == "__init__":
                    yield f"{name}.{part}", inspect.getdoc(value)


def examples_of(docstring):
    return doctest.DocTestParser().get_examples(docstring or "")


def installed(module):
    try:
        import_module(module)
    except ImportError:
        return False
    return True


class Docstrings(PropertyTests):
    maxDiff = None

    def failures(self, name, docstring, names):
        """Messages about the examples of a docstring that fail. Adds the names that they define to `names`."""
        words = []
        test = doctest.DocTestParser().get_doctest(docstring, names, name, None, 0)
        runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
        runner.run(test, out=words.append, clear_globs=False)
        names.update(test.globs)
        return "".join(words)

    def new_names(self):
        """The objects that the docstring of the package defines."""
        names = {}
        self.assertEqual(self.failures("batten", batten.__doc__, names), "")
        return names

    def setUp(self):
        super().setUp()
        before = os.getcwd()
        os.chdir(self.folder)
        self.addCleanup(os.chdir, before)
        os.symlink(os.path.join(SOURCE, "examples"), "examples")

    def test_examples(self):
        for name, docstring in documented():
            if not examples_of(docstring) or not installed(NEEDS.get(name.split(".")[-1], "os")):
                continue
            with self.subTest(name):
                self.assertEqual(self.failures(name, docstring, self.new_names()), "")

    def test_a_wrong_example_is_found(self):
        self.assertIn("Expected", self.failures("wrong", ">>> batten.Session(model)['beta']\n2.0", self.new_names()))

    def test_all_have_words_and_most_an_example(self):
        for name, docstring in documented():
            if name.split(".")[0] in EXEMPT:
                continue
            self.assertTrue(docstring, name)
            thing = getattr(batten, name, None)
            if not thing or (isinstance(thing, type) and issubclass(thing, Exception)):
                continue
            self.assertTrue(examples_of(docstring), name)


class Signatures(PropertyTests):
    def test_functions_have_signatures(self):
        for name, _ in documented():
            thing = batten
            for part in name.split("."):
                thing = getattr(thing, part)
            if callable(thing) and not isinstance(thing, type) and not name.endswith("__init__"):
                self.assertNotIn("args", inspect.signature(thing).parameters, name)
        self.assertEqual(list(inspect.signature(batten.fit).parameters)[:2], ["points", "tolerance"])

    def test_unknown_keywords_are_named(self):
        with self.assertRaisesRegex(TypeError, r"skin\(\) .*'fit_tolerence'.*did you mean 'fit_tolerance'\?"):
            batten.skin({}, fit_tolerence=1)
        with self.assertRaisesRegex(TypeError, r"^Session\(\) .*'value'.*did you mean 'values'\?"):
            batten.Session("no.toml", value={})
        with self.assertRaisesRegex(TypeError, r"expected path, curves, unit"):
            batten.write_curves("rim.csv", {}, something=1)
        # The errors of others stay as they are.
        with self.assertRaisesRegex(TypeError, "incompatible function arguments"):
            batten.skin(3, name="x")

        def stop(stage, fraction):
            raise TypeError("by the caller")
        with self.assertRaisesRegex(TypeError, "by the caller"):
            batten.skin({"rim": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0]]}, progress=stop)


if __name__ == "__main__":
    unittest.main()
