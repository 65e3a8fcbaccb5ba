# SPDX-License-Identifier: MPL-2.0
"""Runs deform scenes and prints how much the edges of their meshes change their length, inside and outside of features, and
how the features rotate and change their shape.

    edge_changes.py FEATURES SCENE…     features: those of the scene FEATURES

The last line is one JSON object: the numbers of examples 20 to 22."""

import json
import os
import re
import subprocess
import sys
import tempfile

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

PROGRAM = os.path.join(os.environ["BATTEN_BUILD"], "bin", "batten")


def deformed(scene):
    """Points before and after, feature of each vertex (below 0: none), edges, and names of features."""
    with open(scene) as file:
        text = file.read()
    folder = os.path.dirname(os.path.abspath(scene))
    text = re.sub(r'(?m)^mesh = "', f'mesh = "{folder}/', re.sub(r"(?ms)^\[\[picture\]\].*?(?=^\[|\Z)", "", text), count=1)
    output = '[output]\nvtp = "edges.vtp"\n'
    text = text.replace("[output]\n", output) if "[output]\n" in text else text + output
    with tempfile.TemporaryDirectory() as out:
        path = os.path.join(out, "scene.toml")
        with open(path, "w") as file:
            file.write(text)
        subprocess.run([PROGRAM, "deform", path, "--out", out], check=True, stdout=subprocess.DEVNULL)
        reader = vtk.vtkXMLPolyDataReader()
        reader.SetFileName(os.path.join(out, "edges.vtp"))
        reader.Update()
        data = reader.GetOutput()
    after = vtk_to_numpy(data.GetPoints().GetData()).astype(float)
    before = after - vtk_to_numpy(data.GetPointData().GetArray("Displacement"))
    edges = set()
    for k in range(data.GetNumberOfPolys()):
        cell = data.GetCell(k).GetPointIds()
        corners = [cell.GetId(i) for i in range(cell.GetNumberOfIds())]
        edges.update(tuple(sorted(pair)) for pair in zip(corners, corners[1:] + corners[:1]))
    feature = data.GetPointData().GetArray("Feature")
    names = data.GetFieldData().GetAbstractArray("Feature_names")
    names = [names.GetValue(i) for i in range(names.GetNumberOfValues())] if names else []
    return before, after, vtk_to_numpy(feature) if feature else None, np.array(sorted(edges)).T, names


def fitted_similarity(before, after):
    """Rotation in degrees, and largest residual over the size, of the best similarity transform."""
    p, q = before - before.mean(0), after - after.mean(0)
    u, s, v = np.linalg.svd(q.T @ p)
    sign = np.diag([1, 1, np.linalg.det(u @ v)])
    rotation = u @ sign @ v
    scale = (s * np.diag(sign)).sum() / (p ** 2).sum()
    residual = np.linalg.norm(q - scale * p @ rotation.T, axis=1).max() / np.linalg.norm(np.ptp(before, axis=0))
    return np.degrees(np.arccos(np.clip((np.trace(rotation) - 1) / 2, -1, 1))), residual


def main():
    results, feature = [], None
    for scene in sys.argv[1:]:
        before, after, own, (a, b), own_names = deformed(scene)
        if feature is None:
            feature, names = own, own_names
        change = np.abs(np.linalg.norm(after[a] - after[b], axis=1) / np.linalg.norm(before[a] - before[b], axis=1) - 1)
        inside = (feature[a] == feature[b]) & (feature[a] >= 0)
        row = {"name": os.path.basename(scene).removesuffix(".toml"), "inside": float(change[inside].max()),
               "outside": float(change[~inside].max()), "outside_mean": float(change[~inside].mean()),
               "all": float(change.max()), "all_mean": float(change.mean()), "features": []}
        for k, name in enumerate(names):
            rotation, error = fitted_similarity(before[feature == k], after[feature == k])
            row["features"].append({"name": name, "rotation": float(rotation), "error": float(error)})
        print(row)
        results.append(row)
    print(json.dumps({"results": results}))


if __name__ == "__main__":
    main()
