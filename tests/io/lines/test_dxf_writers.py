#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""DXF files of two independent writers, FreeCAD and GDAL, with random curves that are known by construction.

    tests/io/lines/test_dxf_writers.py BATTEN [--files 200] [--seed 1] [--keep FOLDER]

`batten convert` writes the curves of each drawing to a STEP file, which OpenCASCADE reads. The total length must be that
of the curves drawn, and points of these curves must lie on the curves read. FreeCAD writes millimetres with six digits;
GDAL's files are in inches. A writer that is not installed is skipped.
"""
import argparse
import math
import pathlib
import random
import subprocess
import sys
import tempfile

sys.path += ["/usr/lib/freecad-python3/lib", "/usr/lib/freecad/lib"]
try:
    import FreeCAD
    import Import
    import Part
    from FreeCAD import Vector
except ImportError:
    FreeCAD = None
try:
    from osgeo import ogr
    ogr.UseExceptions()
except ImportError:
    ogr = None


def placement(random_numbers):
    """A random motion in the plane z = 0."""
    angle = random_numbers.uniform(0, 360)
    return FreeCAD.Placement(Vector(random_numbers.uniform(-200, 200), random_numbers.uniform(-200, 200), 0),
                             FreeCAD.Rotation(Vector(0, 0, 1), angle))


def polyline_points(random_numbers, count):
    points = [Vector(random_numbers.uniform(-50, 50), random_numbers.uniform(-50, 50), 0) for _ in range(count)]
    return [p for i, p in enumerate(points) if i == 0 or (p - points[i - 1]).Length > 1]


def random_edge(random_numbers):
    kind = random_numbers.choice(["line", "arc", "circle", "ellipse", "elliptic arc", "spline", "spline 2"])
    a, b = random_numbers.uniform(5, 40), random_numbers.uniform(0.2, 0.9)
    start = random_numbers.uniform(0, 2 * math.pi)
    end = start + random_numbers.uniform(0.3, 5.5)
    origin = Vector(0, 0, 0)
    if kind == "line":
        return Part.makeLine(origin, Vector(a, 10 * b, 0))
    if kind == "arc":
        return Part.Circle(origin, Vector(0, 0, 1), a).toShape(start, end)
    if kind == "circle":
        return Part.Circle(origin, Vector(0, 0, 1), a).toShape()
    if kind == "ellipse":
        return Part.Ellipse(origin, a, a * b).toShape()
    if kind == "elliptic arc":
        return Part.Ellipse(origin, a, a * b).toShape(start, end)
    spline = Part.BSplineCurve()
    points = polyline_points(random_numbers, random_numbers.randint(4, 9))
    if kind == "spline":
        spline.interpolate(points)
    else:
        spline.buildFromPoles(points, False, 2)
    return spline.toShape()


def freecad_drawing(random_numbers, file):
    """Random edges, written by FreeCAD as entities of AutoCAD 14."""
    edges = []
    for _ in range(random_numbers.randint(1, 6)):
        edge = random_edge(random_numbers)
        edge.Placement = placement(random_numbers)
        edges.append(edge)
    try:
        Import.writeDXFShape(Part.makeCompound(edges), str(file), 14, False)
    except SystemError:
        pass  # FreeCAD 0.20 writes the file and then reports an error that it does not name
    return edges


def gdal_drawing(random_numbers, file):
    """Open and closed polylines on layers, and insertions of a block, by GDAL."""
    source = ogr.GetDriverByName("DXF").CreateDataSource(str(file))
    blocks, entities = source.CreateLayer("blocks"), source.CreateLayer("entities")
    edges = []

    def add(layer, points, closed, fields, z):
        geometry = ogr.Geometry(ogr.wkbLineString25D if z else ogr.wkbLineString)
        for p in points + points[:1] * closed:
            geometry.AddPoint(*p) if z else geometry.AddPoint_2D(p.x, p.y)
        feature = ogr.Feature(layer.GetLayerDefn())
        for key, value in fields.items():
            feature.SetField(key, value)
        feature.SetGeometry(geometry)
        layer.CreateFeature(feature)

    def edges_of(points, closed, matrix=FreeCAD.Matrix()):
        shape = Part.makePolygon(points + points[:1] * closed)
        return shape.transformGeometry(matrix).Edges

    with_block = random_numbers.random() < 0.5
    block = polyline_points(random_numbers, random_numbers.randint(3, 6))
    if with_block:
        add(blocks, block, True, {"Block": "part"}, False)
    for number in range(random_numbers.randint(1, 5)):
        if with_block and random_numbers.random() < 0.5:
            x, y, angle, scale = (random_numbers.uniform(-100, 100), random_numbers.uniform(-100, 100),
                                  random_numbers.uniform(0, 360), random_numbers.uniform(0.2, 3))
            feature = ogr.Feature(entities.GetLayerDefn())
            feature.SetField("BlockName", "part")
            feature.SetField("BlockAngle", angle)
            feature.SetFieldDoubleList(feature.GetFieldIndex("BlockScale"), [scale, scale, scale])
            feature.SetGeometry(ogr.CreateGeometryFromWkt(f"POINT ({x} {y})"))
            entities.CreateFeature(feature)
            matrix = FreeCAD.Matrix()
            matrix.scale(scale, scale, scale)
            matrix.rotateZ(math.radians(angle))
            matrix.move(Vector(x, y, 0))
            edges += edges_of(block, True, matrix)
            continue
        points = polyline_points(random_numbers, random_numbers.randint(2, 12))
        z = random_numbers.random() < 0.3
        if z:
            points = [p + Vector(0, 0, random_numbers.uniform(-20, 20)) for p in points]
        closed = len(points) > 2 and random_numbers.random() < 0.5
        add(entities, points, closed, {"Layer": f"layer {number}"}, z)
        edges += edges_of(points, closed)
    del blocks, entities, source
    return edges


def check(program, file, edges, unit, tolerance):
    """What is wrong with the curves read from a drawing; empty if nothing is. `unit`: millimetres."""
    step = file.with_suffix(".step")
    run = subprocess.run([program, "convert", str(file), str(step)], capture_output=True, text=True)
    if run.returncode != 0:
        return f"exit code {run.returncode}: {run.stderr}"
    read = Part.Shape()
    read.read(str(step))
    drawn, got = unit * sum(e.Length for e in edges), sum(e.Length for e in read.Edges)
    size = read.BoundBox.DiagonalLength + read.BoundBox.Center.Length
    if abs(got - drawn) > tolerance * (drawn + size):
        return f"length {got}, expected {drawn}"
    for edge in edges:
        for point in edge.discretize(Number=7):
            distance = Part.Vertex(unit * point).distToShape(read)[0]
            if distance > tolerance * size:
                return f"{point} of a {edge.Curve.TypeId} is {distance} away"
    return ""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--files", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=pathlib.Path, help="folder of drawings that are read wrongly")
    arguments = parser.parse_args()
    writers = {"FreeCAD": (freecad_drawing, 1, 2e-5)} if FreeCAD else {}
    if FreeCAD and ogr:
        writers["GDAL"] = (gdal_drawing, 25.4, 1e-7)
    if "GDAL" not in writers:
        print("skipped: the drawings of GDAL" + ("" if FreeCAD else " and FreeCAD") + ", which is not installed")
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        for name, (write, unit, tolerance) in writers.items():
            for number in range(arguments.files // len(writers)):
                random_numbers = random.Random(f"{name} {arguments.seed} {number}")
                file = pathlib.Path(folder) / f"{name}_{number}.dxf"
                edges = write(random_numbers, file)
                fault = check(arguments.program, file, edges, unit, tolerance)
                if fault:
                    wrong += 1
                    print(f"{file.name}: {fault}")
                    if arguments.keep:
                        arguments.keep.mkdir(parents=True, exist_ok=True)
                        (arguments.keep / file.name).write_bytes(file.read_bytes())
                file.unlink()
            print(f"{name}: {arguments.files // len(writers)} drawings")
    print(f"{wrong} of {arguments.files} drawings read wrongly" if writers else "skipped")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
