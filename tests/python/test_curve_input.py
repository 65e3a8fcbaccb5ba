# SPDX-License-Identifier: MPL-2.0
"""Curves as people have them: polygons of drawings stay polygons, and corners are where one expects them."""

import json
import unittest

from properties import PropertyTests, batten, np, run_program


def ring(radii, turn=0.3):
    """Points at equal angles around the origin with these radii."""
    t = turn + 2 * np.pi * np.arange(len(radii)) / len(radii)
    return np.column_stack([radii * np.cos(t), radii * np.sin(t)])


def polygon_area(points):
    x, y = points.T
    return 0.5 * abs(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))


def gear(teeth):
    """Four points a tooth, whose flanks are inclined."""
    t = 2 * np.pi / teeth * (np.repeat(np.arange(teeth), 4) + np.tile([0, 0.18, 0.5, 0.68], teeth))
    r = np.tile([20, 24, 24, 20], teeth)
    return np.column_stack([r * np.cos(t), r * np.sin(t)])


def dxf(points):
    """A closed LWPOLYLINE in millimetres."""
    head = ["0", "SECTION", "2", "HEADER", "9", "$INSUNITS", "70", "4", "0", "ENDSEC", "0", "SECTION", "2", "ENTITIES"]
    entity = ["0", "LWPOLYLINE", "8", "cut", "90", str(len(points)), "70", "1"]
    for x, y in points:
        entity += ["10", repr(float(x)), "20", repr(float(y))]
    return "\n".join(head + entity + ["0", "ENDSEC", "0", "EOF", ""])


def svg(points):
    """A closed path of straight lines on a page in millimetres."""
    path = "M " + " L ".join(f"{x!r},{y!r}" for x, y in (points + 50).tolist()) + " Z"
    return ('<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" viewBox="0 0 100 100">'
            f'<path id="cut" d="{path}"/></svg>')


def toml_points(points):
    return json.dumps([[float(c) for c in p] + [0.0] * (3 - len(p)) for p in points])


class CurveInput(PropertyTests):
    def written(self, name, text):
        with open(self.file(name), "w", encoding="utf-8") as file:
            file.write(text)
        return self.file(name)

    def area(self, name, text):
        return batten.load(self.written(name, text)).area

    def scene(self, curves, head=""):
        return f'unit = "mm"\n{head}\n{curves}\n[mesh]\nedge_length = 5\n'

    def outline(self, points, more=""):
        closed = np.vstack([points, points[:1]])
        return f'[[curve]]\nname = "rim"\npoints = {toml_points(closed)}\n{more}\n'

    def assertRelative(self, value, expected, tolerance):
        self.assertLess(abs(value / expected - 1), tolerance, f"{value} instead of {expected}")

    def test_polygons_of_drawings_are_exact(self):
        for sides in (3, 5, 6, 8, 12, 14, 16, 24):
            points = ring(np.full(sides, 30.0))
            for name, text in (("p.dxf", dxf(points)), ("p.svg", svg(points))):
                with self.subTest(sides=sides, file=name):
                    self.assertRelative(self.area(name, text), polygon_area(points), 1e-6)

    def test_polygons_of_cad_files_are_exact(self):
        points = ring(np.full(8, 30.0))
        for name in ("p.step", "p.igs"):
            with self.subTest(file=name):
                self.assertEqual(run_program("convert", self.written("p.dxf", dxf(points)), self.file(name)), 0)
                self.assertRelative(batten.load(self.file(name)).area, polygon_area(points), 1e-6)

    def test_irregular_outlines_of_drawings_are_exact(self):
        random_numbers = np.random.default_rng(5)
        for sides in (7, 13, 19, 33):
            points = ring(random_numbers.uniform(15, 40, sides))
            with self.subTest(sides=sides):
                self.assertRelative(self.area("p.dxf", dxf(points)), polygon_area(points), 1e-6)

    def test_a_polyline_that_samples_a_curve_is_smooth_unless_it_is_to_have_corners(self):
        points = ring(np.full(150, 30.0))
        file = self.written("p.dxf", dxf(points))
        report = batten.run(file, self.file("out"))
        self.assertRelative(batten.load(file).area, np.pi * 30**2, 1e-4)
        self.assertIn("a polyline of 150 segments", " ".join(report["curves_read"]))
        kept = self.written("s.toml", self.scene('[[curves]]\nfile = "p.dxf"\ncorners = "all"\n'))
        self.assertRelative(batten.load(kept).area, polygon_area(points), 1e-6)

    def test_a_coarse_polyline_is_smoothed_on_request(self):
        points = ring(np.full(16, 30.0))
        self.written("p.dxf", dxf(points))
        for key in ('points = "measured"', 'corners = "none"'):
            for table in ('[[curves]]\nfile = "p.dxf"\n', '[[curve]]\nname = "rim"\nfile = "p.dxf"\n'):
                with self.subTest(key=key, table=table):
                    scene = self.written("s.toml", self.scene(table + key + "\n"))
                    self.assertRelative(batten.load(scene).area, np.pi * 30**2, 3e-4)

    def test_numbers_of_corners_for_files(self):
        points = ring(np.full(16, 30.0))
        self.written("p.dxf", dxf(points))
        half = self.written("s.toml", self.scene('[[curves]]\nfile = "p.dxf"\ncorners = [1, 5, 9, 13]\n'))
        area = batten.load(half).area
        self.assertTrue(polygon_area(points) < area < np.pi * 30**2 * 1.001)
        with self.assertRaisesRegex(batten.InputError, "corner"):
            batten.load(self.written("s.toml", self.scene('[[curves]]\nfile = "p.dxf"\ncorners = [40]\n')))

    def test_typed_stars_and_gears_have_corners(self):
        outlines = {f"star {n} {inner}": ring(np.tile([30, 30 * inner], n))
                    for n in (4, 5, 6, 8, 12, 20) for inner in (0.4, 0.55, 0.75)}
        # The turns inside of these are so small that their sides are arcs.
        for name in ("star 4 0.55", "star 4 0.75", "star 5 0.75"):
            del outlines[name]
        outlines |= {f"gear {n}": gear(n) for n in (6, 12, 30)}
        for name, points in outlines.items():
            with self.subTest(name):
                self.assertRelative(self.area("s.toml", self.scene(self.outline(points))), polygon_area(points), 1e-6)

    def test_an_open_zigzag_has_corners(self):
        zigzag = np.array([[0, 0], [10, 8], [20, 0], [30, 8], [40, 0], [50, 8], [60, 0]], float)
        closing = f'[[curve]]\nname = "back"\npoints = [[60, 0, 0], [60, 40, 0], [0, 40, 0], [0, 0, 0]]\ncorners = "all"\n'
        curves = f'[[curve]]\nname = "zigzag"\npoints = {toml_points(zigzag)}\n' + closing
        self.assertRelative(self.area("s.toml", self.scene(curves)), 60 * 40 - 3 * 0.5 * 20 * 8, 1e-6)

    def test_few_points_of_circles_and_noses_are_smooth(self):
        for count, tolerance in ((8, 2e-3), (9, 1e-3), (12, 5e-4)):
            points = ring(np.full(count, 30.0))
            self.assertRelative(self.area("s.toml", self.scene(self.outline(points))), np.pi * 30**2, tolerance)

    def test_a_stated_corner_angle_applies_to_every_point(self):
        points = ring(np.full(12, 30.0))  # turns by 30 degrees
        smooth, sharp = (self.area("s.toml", self.scene(self.outline(points), f"corner_angle = {angle}"))
                         for angle in (31, 29))
        self.assertRelative(smooth, np.pi * 30**2, 5e-4)
        self.assertRelative(sharp, polygon_area(points), 1e-6)

    def test_a_chine_is_a_crease(self):
        """Stations of three points each, through which a longitudinal curve runs."""
        x = np.linspace(0, 420, 8)
        beam = np.array([5.7, 12.6, 17.2, 19.9, 19.2, 16.8, 12.9, 7.4])
        keel = np.column_stack([x, 0 * x, 3e-5 * (x - 200) ** 2])
        chine = np.column_stack([x, beam, keel[:, 2] + 2.8])
        sheer = np.column_stack([x, beam + 5, chine[:, 2] + 13])
        rows = [("keel", keel), ("edge", chine), ("sheer", sheer)]
        rows += [(f"station {i + 1}", np.array([keel[i], chine[i], sheer[i]])) for i in range(8)]
        text = "\n\n".join(name + "\n" + "\n".join(",".join(map(repr, p)) for p in points.tolist()) for name, points in rows)
        model = batten.load(self.written("hull.csv", text + "\n"))
        self.assertEqual(len(model.faces), 14)
        between = [edge for edge in model.edges if edge.name.startswith("edge")]
        self.assertEqual([edge.continuity for edge in between], ["G0"] * 7)
        # The stations stay polylines: the plates beside the chine are flat across.
        for i in range(8):
            corners, points = [keel[i], chine[i], sheer[i]], model.curve(f"station {i + 1}")
            off = np.min([self.distances(points, a, b) for a, b in zip(corners, corners[1:])], axis=0)
            self.assertLess(off.max(), 1e-6 * 420)

    @staticmethod
    def distances(points, a, b):
        t = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        return np.linalg.norm(points - a - t[:, None] * (b - a), axis=1)


if __name__ == "__main__":
    unittest.main()
