#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Draws several decks of this example one below the other, including all elements that are not shells. Needs python3-vtk9 and
an X server.

    xvfb-run -a /usr/bin/python3 draw.py picture.png title deck.bdf [title deck.bdf ...]
"""

import re
import sys

import vtk

COLOURS = {"shells": (0.62, 0.68, 0.76), "solids": (0.85, 0.62, 0.3), "rigid": (0.8, 0.15, 0.15), "mean": (0.05, 0.6, 0.2)}


def number(text):
    return float(re.sub(r"(?<=[0-9.])([+-])", r"e\1", text.strip()))


def read(name):
    """Reads the nodes and the fields of all cards: eight columns wide, or sixteen for wide-format nodes."""
    nodes, cards = {}, []
    lines = open(name).read().splitlines()
    for k, line in enumerate(lines):
        if line.startswith("GRID*"):
            nodes[int(line[8:24])] = [number(line[40:56]), number(line[56:72]), number(lines[k + 1][8:24])]
        elif line.startswith("GRID"):
            nodes[int(line[8:16])] = [number(line[24 + 8 * c : 32 + 8 * c]) for c in range(3)]
        elif line.startswith("+") and cards:
            cards[-1] += [line[c : c + 8].strip() for c in range(8, 72, 8)]
        elif line[:1].isalpha():
            cards.append([line[c : c + 8].strip() for c in range(0, 72, 8)])
    return nodes, cards


def actors(name):
    nodes, cards = read(name)
    place = {n: k for k, n in enumerate(nodes)}
    points = vtk.vtkPoints()
    for p in nodes.values():
        points.InsertNextPoint(p)
    grids = {kind: vtk.vtkUnstructuredGrid() for kind in COLOURS}
    for grid in grids.values():
        grid.SetPoints(points)

    def cell(kind, shape, ids):
        grids[kind].InsertNextCell(shape, len(ids), [place[int(i)] for i in ids])

    spheres = vtk.vtkAppendPolyData()
    for card in cards:
        if card[0] == "CQUAD4":
            cell("shells", vtk.VTK_QUAD, card[3:7])
        elif card[0] == "CHEXA":
            cell("solids", vtk.VTK_HEXAHEDRON, card[3:11])
        elif card[0] in ("CBAR", "CBUSH"):
            cell("rigid", vtk.VTK_LINE, card[3:5])
        elif card[0] in ("RBE2", "RBE3"):
            first = card[2] if card[0] == "RBE2" else card[3]
            for other in filter(None, card[4:] if card[0] == "RBE2" else card[7:]):
                cell("rigid" if card[0] == "RBE2" else "mean", vtk.VTK_LINE, [first, other])
        elif card[0] == "CONM2":
            sphere = vtk.vtkSphereSource()
            sphere.SetCenter(nodes[int(card[2])])
            sphere.SetRadius(4)
            sphere.SetThetaResolution(24)
            sphere.SetPhiResolution(24)
            spheres.AddInputConnection(sphere.GetOutputPort())
    made = []
    for kind, data in [*grids.items(), ("rigid", spheres)]:
        mapper = vtk.vtkDataSetMapper() if data is not spheres else vtk.vtkPolyDataMapper()
        if data is spheres:
            mapper.SetInputConnection(spheres.GetOutputPort())
        else:
            mapper.SetInputData(data)
        actor = vtk.vtkActor()
        actor.SetMapper(mapper)
        actor.GetProperty().SetColor(COLOURS[kind])
        actor.GetProperty().SetLineWidth(3 if kind in ("rigid", "mean") else 1)
        if kind == "solids":
            actor.GetProperty().EdgeVisibilityOn()
            actor.GetProperty().SetEdgeColor(0.25, 0.28, 0.33)
        if kind == "shells":
            edges = vtk.vtkExtractEdges()
            edges.SetInputData(data)
            lines = vtk.vtkPolyDataMapper()
            lines.SetInputConnection(edges.GetOutputPort())
            drawn = vtk.vtkActor()
            drawn.SetMapper(lines)
            drawn.GetProperty().SetColor(0.35, 0.38, 0.43)
            drawn.GetProperty().LightingOff()
            made.append(drawn)
        if kind == "shells":
            actor.GetProperty().SetOpacity(0.6)
        made.append(actor)
    return made


def main():
    vtk.vtkMapper.SetResolveCoincidentTopologyToPolygonOffset()
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetAlphaBitPlanes(1)
    decks = list(zip(sys.argv[2::2], sys.argv[3::2]))
    window.SetSize(1300, 430 * len(decks))
    camera = None
    for k, (title, deck) in enumerate(decks):
        view = vtk.vtkRenderer()
        view.SetBackground(1, 1, 1)
        view.SetUseDepthPeeling(1)
        view.SetUseFXAA(1)
        view.SetViewport(0, 1 - (k + 1) / len(decks), 1, 1 - k / len(decks))
        for actor in actors(deck):
            view.AddActor(actor)
        text = vtk.vtkTextActor()
        text.SetInput(title)
        text.SetPosition(165, 395)
        text.GetTextProperty().SetFontSize(20)
        text.GetTextProperty().SetColor(0.1, 0.1, 0.15)
        view.AddViewProp(text)
        if camera is None:
            camera = view.GetActiveCamera()
            camera.ParallelProjectionOn()
            camera.SetFocalPoint(132, 58, 3)
            camera.SetPosition(130 - 170, 58 - 480, 3 - 210)
            camera.SetViewUp(0, 0, 1)
            camera.SetParallelScale(72)
        else:
            view.SetActiveCamera(camera)
        view.ResetCameraClippingRange()
        window.AddRenderer(view)
    window.Render()
    image = vtk.vtkWindowToImageFilter()
    image.SetInput(window)
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(sys.argv[1])
    writer.SetInputConnection(image.GetOutputPort())
    writer.Write()


main()
