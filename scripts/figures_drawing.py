# SPDX-License-Identifier: MPL-2.0
"""Pictures for scripts/figures that are composed of several, drawn from Python or FreeCAD, or plotted."""

import math
import os
import re
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image, ImageChops, ImageDraw, ImageFont

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FONT = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"
# The colours of io/pictures/canvas.h.
TEXT, LINE, BODY, FEATURE = (36, 41, 51), (212, 48, 23), (147, 176, 204), (237, 158, 56)
VIEW = {"azimuth": -35, "elevation": 28}
CARD = (640, 420)


def batten():
    import batten as module

    return module


def example(path):
    return os.path.join(ROOT, "examples", path)


def copy(source, target):
    """Copies a picture; a PNG is compressed better."""
    if source.endswith(".png"):
        Image.open(source).save(target, optimize=True)
    else:
        with open(source, "rb") as data, open(target, "wb") as out:
            out.write(data.read())


def label(picture, text, size, x, y, anchor="mm", colour=TEXT):
    ImageDraw.Draw(picture).text((x, y), text, fill=colour, font=ImageFont.truetype(FONT, size), anchor=anchor)


def sheet(files, captions, columns, width=1600):
    """The pictures in rows, each with a caption below it."""
    pictures = [f if isinstance(f, Image.Image) else Image.open(f).convert("RGB") for f in files]
    gap, row = 6, 46
    cell = (width - gap * (columns - 1)) // columns
    height = round(max(p.height * cell / p.width for p in pictures))
    rows = -(-len(pictures) // columns)
    result = Image.new("RGB", (width, rows * (height + row)), "white")
    for k, (picture, caption) in enumerate(zip(pictures, captions)):
        x, y = (k % columns) * (cell + gap), (k // columns) * (height + row)
        picture = picture.resize((cell, round(picture.height * cell / picture.width)), Image.LANCZOS)
        result.paste(picture, (x, y))
        label(result, caption, 26 if columns < 4 else 23, x + cell / 2, y + height + row / 2)
    return result


def picture(model, size, **look):
    """The picture of a model, in memory."""
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "picture.png")
        model.picture(file, width=size[0], height=size[1], **look)
        return Image.open(file).convert("RGB")


class Camera:
    """The camera that the program chooses for the points of a surface."""

    def __init__(self, points, size, azimuth, elevation):
        a, e = math.radians(azimuth), math.radians(elevation)
        self.right = np.array([math.cos(a), math.sin(a), 0])
        self.towards = np.array([math.sin(a) * math.cos(e), -math.cos(a) * math.cos(e), math.sin(e)])
        self.up = np.cross(self.towards, self.right)
        self.size = size
        seen = points @ np.array([self.right, self.up]).T
        self.middle = (seen.min(0) + seen.max(0)) / 2
        self.pixel = max((seen.max(0) - seen.min(0)) / (0.88 * np.array(size)))

    def __call__(self, points):
        seen = (points @ np.array([self.right, self.up]).T - self.middle) / self.pixel
        return np.c_[self.size[0] / 2 + seen[:, 0], self.size[1] / 2 - seen[:, 1]]


def background(shaded):
    """The empty picture: the colours of its left edge."""
    edge = np.asarray(shaded)[:, :1]
    return Image.fromarray(np.repeat(edge, shaded.width, axis=1))


def with_curves(base, camera, curves, fractions=None):
    """`base` with curves, each drawn up to a fraction of its length."""
    factor = 3
    ink = Image.new("L", (base.width * factor, base.height * factor))
    draw = ImageDraw.Draw(ink)
    width = round(factor * 4.2 * (base.width / 1600 * base.height / 1000) ** 0.35)
    for k, points in enumerate(curves):
        fraction = 1 if fractions is None else fractions[k]
        count = round(fraction * (len(points) - 1))
        if count < 1:
            continue
        chain = [tuple(p) for p in camera(points[: count + 1]) * factor]
        draw.line(chain, fill=255, width=width, joint="curve")
        for x, y in (chain[0], chain[-1]):
            draw.ellipse([x - width / 2, y - width / 2, x + width / 2, y + width / 2], fill=255)
    mask = ink.resize(base.size, Image.LANCZOS)
    return Image.composite(Image.new("RGB", base.size, LINE), base, mask)


def curves_of(model):
    return [model.curve(name, 200) for name in model.curves]


# Pictures of models.


def half_cylinder(target, _):
    with open(example("16-classics/cylinder.toml"), encoding="utf-8") as file:
        text = file.read()
    models = [batten().parse(f'{text}\n[skin]\nfair = "{fair}"\n') for fair in ("bending", "auto")]
    look = {"azimuth": -60, "elevation": 30, "zebra": 24}
    sheet([picture(m, (800, 500), **look) for m in models],
          ('least bending energy: fair = "bending"', "default: the half cylinder"), 2).save(target, optimize=True)


def mouse_fair(target, _):
    with open(example("09-mouse/scene.toml"), encoding="utf-8") as file:
        text = file.read()
    models = [batten().parse(f'{text}\n[skin]\nfair = "{fair}"\n') for fair in ("bending", "variation")]
    sheet([picture(m, (800, 560), azimuth=150, elevation=32, zebra=30) for m in models],
          ("least bending energy", "least variation of curvature"), 2).save(target, optimize=True)


def head(target, runner):
    before, after = (Image.open(runner(f"batten deform examples/22-head/{name}.toml --out {{out}}", f"{name}.png"))
                     .convert("RGB") for name in ("kept", "free"))
    half = before.width // 2
    height = before.height - 50  # without the captions
    parts = [before.crop((0, 0, half, height)), after.crop((half, 0, 2 * half, height)),
             before.crop((half, 0, 2 * half, height))]
    sheet(parts, ("input", "without features", "organs as features"), 3).save(target, optimize=True)


def card_surface(target, _):
    """The curves of the mouse on the left; the surface that they define on the right."""
    model = batten().load(example("09-mouse/scene.toml"))
    shaded = picture(model, CARD, **VIEW)
    camera = Camera(np.asarray(model.points), CARD, **VIEW)
    open_side = with_curves(background(shaded), camera, curves_of(model))
    x, y = np.meshgrid(np.arange(CARD[0]), np.arange(CARD[1]))
    mask = np.clip((x - 0.40 * CARD[0] - 0.35 * (y - CARD[1] / 2)) / 130 + 0.5, 0, 1)
    Image.composite(shaded, open_side, Image.fromarray((255 * mask).astype(np.uint8))).save(target, optimize=True)


def card_sculpt(target, _):
    """Four values of one pressure between the same curves."""
    session = batten().Session(example("08-goblet/scene.toml"))
    result = Image.new("RGB", CARD, "white")
    width = CARD[0] // 4
    for k, value in enumerate((0, 450, 650, 900)):
        session["wine"] = value
        session.solve()
        shaded = picture(session.model(), (3 * width, 3 * CARD[1]), azimuth=20, elevation=14)
        result.paste(shaded.resize((width, CARD[1]), Image.LANCZOS), (k * width, 0))
    result.save(target, optimize=True)


def card_morph(target, runner):
    """The panel before the edit above the panel after it."""
    both = Image.open(runner("batten deform examples/11-panel/edit.toml --out {out}", "panel.png")).convert("RGB")
    half, scale = both.width // 2, 0.46
    result = background(both.crop((4, 0, 44, both.height - 70))).resize(CARD)
    for k in range(2):
        part = both.crop((k * half + 4, 0, (k + 1) * half - 4, both.height - 70))
        part = part.resize((round(part.width * scale), round(part.height * scale)), Image.LANCZOS)
        drawn = ImageChops.difference(part, background(part)).convert("L").point(lambda v: min(255, 12 * v))
        result.paste(part, ((0, CARD[0] - part.width)[k], (-55, CARD[1] - part.height + 45)[k]), drawn)
    result.save(target, optimize=True)


FREECAD = """
import os
import FreeCAD, FreeCADGui, Part
from PySide2 import QtCore


def draw():
    try:
        view = FreeCAD.ParamGet("User parameter:BaseApp/Preferences/View")
        view.SetBool("Gradient", False)
        view.SetBool("Simple", True)
        view.SetUnsigned("BackgroundColor", 0xf1f3f5ff)
        FreeCAD.newDocument("mouse")
        Part.insert({step!r}, "mouse")
        for thing in FreeCAD.ActiveDocument.Objects:
            thing.ViewObject.Deviation = 0.02
        view = FreeCADGui.ActiveDocument.ActiveView
        view.setCameraType("Orthographic")
        up, side = FreeCAD.Rotation(FreeCAD.Vector(0, 0, 1), {azimuth}), FreeCAD.Rotation(FreeCAD.Vector(1, 0, 0), 90 - {elevation})
        view.setCameraOrientation((up * side).Q)
        view.fitAll()
        height = view.getCameraNode().height
        height.setValue(0.62 * height.getValue())
        FreeCADGui.updateGui()
        view.saveImage({image!r}, 1600, 1000, "Current")
    finally:
        os._exit(0)


QtCore.QTimer.singleShot(3000, draw)
"""


def freecad_view(runner):
    step = runner("batten run examples/09-mouse/scene.toml --out {out}", "mouse.step")
    image = os.path.join(os.path.dirname(step), "step_in_freecad.png")
    macro = os.path.join(os.path.dirname(step), "show_step.py")
    with open(macro, "w", encoding="utf-8") as file:
        file.write(FREECAD.format(step=step, image=image, **VIEW))
    with tempfile.TemporaryDirectory() as home:  # own settings
        environment = dict(os.environ, QTWEBENGINE_DISABLE_SANDBOX="1", FREECAD_USER_HOME=home)
        subprocess.run(["freecad", macro], env=environment, capture_output=True, timeout=180, check=False)
    return Image.open(image).convert("RGB")


def freecad(target, runner):
    freecad_view(runner).save(target, optimize=True)


# The moving picture.


class Film:
    size = (800, 500)

    def __init__(self):
        self.frames = []

    def add(self, shown, caption, count=1):
        frame = shown.convert("RGB").resize(self.size, Image.LANCZOS)
        label(frame, caption, 19, 20, self.size[1] - 22, "lm")
        self.frames += [frame] * count

    def fade(self, one, other, caption, count):
        one, other = (p.resize(self.size, Image.LANCZOS) for p in (one, other))
        for k in range(count):
            self.add(Image.blend(one, other, (k + 1) / (count + 1)), caption)

    def save(self, target, rate=12):
        frames = [frame.quantize(200, method=Image.Quantize.MEDIANCUT, kmeans=1, dither=Image.Dither.NONE)
                  for frame in self.frames]
        frames[0].save(target, save_all=True, append_images=frames[1:], duration=round(1000 / rate), loop=0,
                       optimize=False, disposal=1)


class Still:
    """Pictures of changing models with the camera of one model."""

    def __init__(self, model, size):
        self.size = size
        self.camera = Camera(np.asarray(model.points), size, **VIEW)

    def __call__(self, model, **look):
        large = tuple(2 * side for side in self.size)
        shown = picture(model, large, **VIEW, **look)
        own = Camera(np.asarray(model.points), large, **VIEW)
        # A point at pixel p of the result is at pixel scale · p + shift of the large picture.
        scale = self.camera.pixel / own.pixel
        shift = [side / 2 - scale * out / 2 + sign * (middle - moved) / own.pixel
                 for side, out, sign, middle, moved in zip(large, self.size, (1, -1), self.camera.middle, own.middle)]
        return shown.transform(self.size, Image.Transform.AFFINE, (scale, 0, shift[0], 0, scale, shift[1]),
                               Image.Resampling.BICUBIC)


def tour(target, runner):
    """Curves, the surface, a drag, zebra stripes, stress, and the STEP file in FreeCAD."""
    film = Film()
    model = batten().load(example("09-mouse/scene.toml"))
    session = batten().Session(model)
    session.add_pressure("palm", min=-500, max=500)
    still = Still(model, film.size)
    camera, shaded = still.camera, still(model)
    empty, curves = background(shaded), curves_of(model)
    for k in range(15):
        parts = [min(1, max(0, (k + 1) / 15 * (len(curves) + 2) / 3 - c / 3)) for c in range(len(curves))]
        film.add(with_curves(empty, camera, curves, parts), "nine curves, in any order")
    wire = with_curves(empty, camera, curves)
    film.add(wire, "nine curves, in any order", 3)
    film.fade(wire, shaded, "eleven faces, joined smoothly or at creases", 6)
    film.add(shaded, "eleven faces, joined smoothly or at creases", 8)

    def drag(values, caption, **look):
        for value in values:
            session["palm"] = value
            session.solve()
            shown = still(session.model(), **look)
            film.add(shown, caption)
        return shown

    swing = [210 * (1 - math.cos(math.pi * k / 9)) for k in range(1, 10)]
    fuller = drag(swing, "drag a pressure: the curves stay")
    film.add(fuller, "drag a pressure: the curves stay", 3)
    drag(swing[-2::-2], "drag a pressure: the curves stay")
    session["palm"] = 0
    session.solve()
    striped = still(session.model(), zebra=30)
    film.fade(shaded, striped, "zebra stripes", 3)
    film.add(striped, "zebra stripes", 4)
    drag([40, 80, 120, 120, 80, 40], "zebra stripes", zebra=30)
    film.add(striped, "zebra stripes", 4)
    stress = Image.open(runner("batten stress examples/09-mouse/scene.toml --out {out}", "mouse_drop.png")).convert("RGB")
    film.fade(striped, stress, "", 3)
    film.add(stress, "", 14)
    step = freecad_view(runner)
    film.fade(stress, step, "", 3)
    film.add(step, "the STEP file in FreeCAD", 18)
    film.save(target)


# Plots.


def axes(width=8, height=5):
    """Axes in the style of the pictures."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    plt.rcParams.update({
        "font.family": "DejaVu Sans", "font.size": 12, "axes.spines.top": False, "axes.spines.right": False,
        "axes.edgecolor": "#5b6472", "axes.labelcolor": "#242933", "text.color": "#242933", "xtick.color": "#242933",
        "ytick.color": "#242933", "axes.grid": True, "grid.color": "#e2e6eb", "axes.axisbelow": True,
        "savefig.facecolor": "white"})
    figure, result = plt.subplots(figsize=(width, height), dpi=160)
    return figure, result


COLOURS = ("#2f6aa8", "#d43017", "#2c8f6b", "#8a5fb0")


def pressure_height(target, _):
    """The diameter of the bowl of example 06 at half its height against its pressure."""
    session = batten().Session(example("06-goblet-bowl/scene.toml"))
    values, widths = range(-100, 281, 20), []
    for value in values:
        session["swell"] = value
        session.solve()
        points = np.asarray(session.points)
        middle = (points[:, 2].min() + points[:, 2].max()) / 2
        near = np.abs(points[:, 2] - middle) < 0.08 * middle
        line = np.polyfit(points[near, 2] - middle, np.hypot(points[near, 0], points[near, 1]), 1)
        widths.append(2 * line[1])
    figure, plot = axes()
    plot.plot(values, widths, "o-", color=COLOURS[0], lw=2)
    plot.set_xlabel("pressure (key `swell`)")
    plot.set_ylabel("diameter of the bowl at half its height [mm]")
    figure.tight_layout()
    figure.savefig(target)


def validation(target, _):
    """True errors of the published shells against the accuracy that was requested."""
    sys.path.insert(0, os.path.join(ROOT, "benchmarks"))
    import published_cases
    import section_cases  # noqa: F401, adds its own cases

    accuracies = (0.1, 0.03, 0.01, 0.003, 0.001)
    figure, plot = axes(8, 5.5)
    for name, _, reference, _, _, function in published_cases.CASES:
        found = [function(accuracy) for accuracy in accuracies]
        if found[0][1] is None:  # frequencies and buckling factors have no estimate
            continue
        errors = [max(abs(value / reference - 1), 1e-6) for value, _ in found]
        singular = "LE6" in name
        plot.plot(accuracies, errors, "o-", ms=4, lw=1.5 if singular else 1, color=COLOURS[1] if singular else COLOURS[0],
                  alpha=1 if singular else 0.45)
        if singular:
            plot.annotate("skew plate with singular corners", (accuracies[1], errors[1]), (0, 8), textcoords="offset points",
                          color=COLOURS[1], ha="center")
    plot.plot(accuracies, accuracies, "--", color="#242933", lw=1)
    plot.annotate("requested", (accuracies[0], accuracies[0]), (40, -34), textcoords="offset points", ha="center")
    plot.set_xscale("log")
    plot.set_yscale("log")
    plot.invert_xaxis()
    plot.set_xlabel("requested accuracy")
    plot.set_ylabel("true relative error")
    figure.tight_layout()
    figure.savefig(target)


# What is compared, and where benchmarks/README.md gives the factor.
SPEEDS = (
    ("assembly of HCT elements", "GetFEM", r"With constant coefficients, Batten is (\d+) \(HCT\)"),
    ("clamped plate, complete", "GetFEM", r"the measured factors are ([\d.]+),"),
    ("solve of a drag", "CHOLMOD", r"\| 2.5 times as fast as CHOLMOD there \| ([\d.]+)"),
    ("stress analysis of a roof", "CalculiX S6", r"measured: ([\d.]+) on the roof"),
    ("edit of a mesh", "CGAL", r"CGAL thus takes ([\d.]+) and"),
)


def speed(target, _):
    with open(os.path.join(ROOT, "benchmarks", "README.md"), encoding="utf-8") as file:
        text = re.sub(r"<!--.*?-->", "", " ".join(file.read().split()))
    factors = [float(re.search(pattern, text).group(1)) for *_, pattern in SPEEDS]
    figure, plot = axes(8, 3.6)
    places = np.arange(len(SPEEDS))[::-1]
    plot.barh(places, factors, color=COLOURS[0], height=0.6)
    for place, factor, (_, peer, _) in zip(places, factors, SPEEDS):
        plot.text(factor * 1.06, place, f"{factor:g} × {peer}", va="center")
    plot.set_yticks(places, [name for name, *_ in SPEEDS])
    plot.set_xscale("log")
    plot.set_xlim(1, 200)
    plot.set_xticks([1, 2, 5, 10, 20, 50, 100], ["1", "2", "5", "10", "20", "50", "100"])
    plot.grid(axis="y", visible=False)
    plot.set_xlabel("times as fast as the peer, on one thread")
    figure.tight_layout()
    figure.savefig(target)
