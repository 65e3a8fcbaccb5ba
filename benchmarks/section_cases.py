# SPDX-License-Identifier: MPL-2.0
"""Cases of laminates, temperatures, stiffeners, foundations, shear buckling and cylinders under external pressure, added to the
table of published_cases."""

import math

import numpy as np
from scipy.integrate import solve_bvp

import batten
from published_cases import RIM, STEEL, STEEL_D, case, displacement, fixed_in_plane, held, outline, rounded
from validation import analyse, arc, stress

# Laminates: a plate of 100 × 80 mm under a sinusoidal pressure, Navier's solutions of classical lamination theory.

A, B, PRESSURE = 100, 80, 0.01
E1, E2, NU12, G12, PLY = 140e3, 10e3, 0.3, 5e3, 0.125
CARBON = f"young = [{E1}, {E2}]\npoisson = {NU12}\nshear_modulus = {G12}\nmaterial_direction = [1, 0, 0]\n"


def layered(angles, ply=PLY):
    """A, B, D of a laminate, with the angles from the bottom to the top."""
    nu21 = NU12 * E2 / E1
    Q = np.array([[E1, NU12 * E2, 0], [NU12 * E2, E2, 0], [0, 0, G12 * (1 - NU12 * nu21)]]) / (1 - NU12 * nu21)
    total, integrals = len(angles) * ply, [np.zeros((3, 3)) for _ in range(3)]
    for k, angle in enumerate(angles):
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        T = np.array([[c * c, s * s, c * s], [s * s, c * c, -c * s], [-2 * c * s, 2 * c * s, c * c - s * s]])
        low, high = k * ply - total / 2, (k + 1) * ply - total / 2
        for power in range(3):
            integrals[power] += (high ** (power + 1) - low ** (power + 1)) / (power + 1) * T.T @ Q @ T
    return integrals


def navier(angles, angle_ply):
    a, b, d = layered(angles)
    x, y = math.pi / A, math.pi / B
    stiffness = np.zeros((3, 3))
    stiffness[0, 0] = a[0, 0] * x * x + a[2, 2] * y * y
    stiffness[0, 1] = (a[0, 1] + a[2, 2]) * x * y
    stiffness[1, 1] = a[2, 2] * x * x + a[1, 1] * y * y
    stiffness[2, 2] = d[0, 0] * x ** 4 + 2 * (d[0, 1] + 2 * d[2, 2]) * x * x * y * y + d[1, 1] * y ** 4
    stiffness[0, 2] = -(3 * b[0, 2] * x * x * y + b[1, 2] * y ** 3) if angle_ply else -b[0, 0] * x ** 3
    stiffness[1, 2] = -(b[0, 2] * x ** 3 + 3 * b[1, 2] * x * y * y) if angle_ply else -b[1, 1] * y ** 3
    full = np.triu(stiffness) + np.triu(stiffness, 1).T
    return np.linalg.solve(full, [0, 0, PRESSURE])[2]


def laminated_plate(angles, angle_ply, accuracy):
    """Simply supported; in the plane, the edges slide across (cross-ply) or along (angle-ply)."""
    model = outline([[0, 0, 0], [A, 0, 0], [A, B, 0], [0, B, 0]], ["south", "east", "north", "west"], unit="mm")
    across = {"south": 1, "north": 1, "east": 0, "west": 0}
    supports = [held(name, 2, axis if angle_ply else 1 - axis) for name, axis in across.items()]
    result = analyse(model, supports=supports, loads=[{"traction": [0, 0, f"{PRESSURE} * sin(pi * x / {A}) * sin(pi * y / {B})"]}],
                           settings=CARBON + f'layup = "[{"/".join(str(a) for a in angles)}]"\nply_thickness = {PLY}', accuracy=accuracy)
    one = result.load_case()
    return result.at([A / 2, B / 2, 0]).displacement[2], one.max_displacement_error / one.max_displacement


for angles, angle_ply, conditions in (((0, 90, 90, 0), False, "S2"), ((0, 90), False, "S2"), ((45, -45), True, "S3")):
    case(f"laminate [{'/'.join(str(a) for a in angles)}], simply supported ({conditions}), sinusoidal pressure: deflection", "mm",
         navier(angles, angle_ply), "Jones1999")(lambda accuracy, angles=angles, angle_ply=angle_ply:
                                                 laminated_plate(angles, angle_ply, accuracy))

# Cylinders of two plies under internal pressure, clamped at both ends.

RADIUS, LENGTH, THICK_PLY = 100, 100, 0.5


def clamped_cylinder(angles):
    """Deflection in the middle: the axially symmetric equations as a boundary value problem, direction 1 along the axis."""
    a, b, d = layered(angles, THICK_PLY)
    mixed = np.block([[a[np.ix_([0, 2], [0, 2])], b[np.ix_([0, 2], [0])]], [b[np.ix_([0], [0, 2])], d[:1, :1]]])

    def equations(x, y, p):
        u, v, w, slope, moment, force = y
        hoop = w / RADIUS
        right = np.array([p[0] - a[0, 1] * hoop, p[1] - a[2, 1] * hoop, moment - b[0, 1] * hoop])
        du, dv, curvature = np.linalg.solve(mixed, right)  # u', v', -w''
        around = a[1, 0] * du + a[1, 2] * dv + a[1, 1] * hoop + b[1, 0] * curvature
        return np.array([du, dv, slope, -curvature, force, around / RADIUS - PRESSURE])

    def ends(left, right, p):
        return np.concatenate([left[:4], right[:4]])

    x = np.linspace(0, LENGTH, 401)
    solution = solve_bvp(equations, ends, x, np.zeros((6, x.size)), p=[0.0, 0.0], tol=1e-8, max_nodes=100000)
    assert solution.success, solution.message
    return solution.sol(LENGTH / 2)[2]


def cylinder_of_plies(angles, accuracy):
    low, high = (arc([0, 0, z], [RADIUS, 0, 0], [0, RADIUS, 0], 0, 360, 193) for z in (0, LENGTH))
    model = batten.skin({"low": low, "high": high}, fit_tolerance=1e-4, unit="mm", edge_length=10,
                        settings='[[face]]\nname = "wall"\nloops = [["low"], ["high"]]\nannulus = true')
    outwards = 1 if model.normals[0] @ (model.points[0] * [1, 1, 0]) > 0 else -1
    plies = "/".join(str(outwards * angle) for angle in angles[::outwards])  # from the inside to the outside
    result = analyse(model, loads=[{"pressure": outwards * PRESSURE}], supports=["low", "high"], accuracy=accuracy,
                           settings=CARBON.replace("[1, 0, 0]", "[0, 0, 1]") + f'layup = "[{plies}]"\nply_thickness = {THICK_PLY}')
    one = result.load_case()
    direction = np.array([math.cos(0.7), math.sin(0.7), 0])
    return result.at(RADIUS * direction + [0, 0, LENGTH / 2]).displacement @ direction, one.max_displacement_error / one.max_displacement


for angles in ((90, 0), (45, -45)):
    case(f"cylinder of plies [{'/'.join(str(a) for a in angles)}], L/R = 1, clamped, internal pressure: radial displacement", "mm",
         clamped_cylinder(angles), "Jones1999")(lambda accuracy, angles=angles: cylinder_of_plies(angles, accuracy))

# Temperatures.


@case("strip of two metals, heated: deflection of the end", "mm",
      3 * 8e-6 * 100 * 4 * 40 ** 2 / (12 + 1.5 * (1 + 2)), "Timoshenko1925")
def bimetal(accuracy):
    """Equal thicknesses of 0.5, E ratio 1/2: κ = 6 Δα T (1 + m)²/(h (3 (1 + m)² + (1 + mn)(m² + 1/(mn))), w = κ x²/2."""
    model = outline([[0, 0, 0], [40, 0, 0], [40, 10, 0], [0, 10, 0]], unit="mm")
    brass, steel = ('{ name = "%s", young = %g, poisson = 0.3, expansion = %g }' % one for one in (("brass", 1e5, 19e-6), ("steel", 2e5, 11e-6)))
    plies = ['{ material = "brass", thickness = 0.5 }', '{ material = "steel", thickness = 0.5 }']
    result = analyse(model, accuracy=accuracy, loads=[{"temperature": 100}],
                           settings=f"materials = [{brass}, {steel}]\nplies = [{', '.join(plies)}]",
                           supports=[{"point": [0, 0, 0]}, {"point": [0, 10, 0], "directions": [[1, 0, 0], [0, 0, 1]]},
                                     {"curve": "side 4", "type": "prescribed", "directions": [[1, 0, 0]], "rotation": True}])
    # The curvature across the strip moves its corners, too.
    middle, end = (result.at([x, 5, 0]).displacement[2] for x in (0, 40))
    return abs(end - middle), None


@case("square plate, simply supported, heated on one side: deflection in the middle", "m", 0.0736713 * 1.3 * 12e-6 * 50 / 0.01, "Timoshenko1959")
def heated_plate(accuracy):
    model = outline([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    result = analyse(model, accuracy=accuracy, material="steel", thickness=0.01, loads=[{"temperature_difference": 50}],
                           supports=[held(f"side {k + 1}", 2) for k in range(4)] + fixed_in_plane([0.5, 0.5, 0], [0.6, 0.5, 0]))
    one = result.load_case()
    return abs(result.at([0.5, 0.5, 0]).displacement[2]), one.max_displacement_error / one.max_displacement


# Plates: supports at points, foundation, shear buckling, clamped vibration, rotating disc.


@case("square plate on four corners, pressure: deflection in the middle", "m", 0.02551 * 1000 / STEEL_D, "Timoshenko1959")
def corner_plate(accuracy):
    model = outline([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    return displacement(model, [0.5, 0.5, 0], 2, accuracy, **STEEL, loads=[{"traction": [0, 0, 1000]}],
                        supports=[{"point": corners[0]}, {"point": corners[1], "directions": [[0, 1, 0], [0, 0, 1]]}] +
                                 [{"point": corner, "directions": [[0, 0, 1]]} for corner in corners[2:]])


FOUNDATION = 4 * math.pi ** 4 * STEEL_D  # of a plate of 1 m: halves the deflection of the first term


def founded():
    odd = np.arange(1, 200, 2)
    m, n = np.meshgrid(odd, odd)
    terms = 16 * 1000 / math.pi ** 2 / (m * n) * np.sin(m * math.pi / 2) * np.sin(n * math.pi / 2)
    return np.sum(terms / (math.pi ** 4 * STEEL_D * (m * m + n * n) ** 2 + FOUNDATION))


@case("square plate on an elastic foundation, simply supported, pressure: deflection", "m", founded(), "Timoshenko1959")
def foundation(accuracy):
    model = outline([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    return displacement(model, [0.5, 0.5, 0], 2, accuracy, **STEEL, loads=[{"traction": [0, 0, 1000]}],
                        supports=[held(f"side {k + 1}", 2) for k in range(4)] + fixed_in_plane([0.5, 0.5, 0], [0.6, 0.5, 0]) +
                                 [{"foundation": FOUNDATION}])


@case("square plate, simply supported, shear along its edges: buckling factor", "", 9.3246 * math.pi ** 2 * STEEL_D / 1e4, "Timoshenko1961")
def shear_buckling(accuracy):
    model = outline([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], ["south", "east", "north", "west"], edge_length=1 / 16)
    loads = [{"curve": curve, "force": force} for curve, force in
             (("south", [-1e4, 0, 0]), ("north", [1e4, 0, 0]), ("east", [0, 1e4, 0]), ("west", [0, -1e4, 0]))]
    supports = [held(curve, 2) for curve in ("south", "east", "north", "west")] + [
        {"point": [0, 0, 0], "directions": [[1, 0, 0], [0, 1, 0]]}, {"point": [1, 0, 0], "directions": [[0, 1, 0]]}]
    return stress(model, **STEEL, loads=loads, supports=supports, buckling=1).load_case().buckling_factors[0], None


@case("clamped square plate: first frequency", "Hz", 35.985 / (2 * math.pi) * math.sqrt(STEEL_D / 78.5), "Leissa1969")
def clamped_square(accuracy):
    model = outline([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    return stress(model, **STEEL, density=7850, modes=1, supports=[f"side {k + 1}" for k in range(4)]).frequencies[0], None


@case("clamped disc: first frequency", "Hz", 10.2158 / (2 * math.pi) * math.sqrt(STEEL_D / 78.5), "Leissa1969")
def disc_frequency(accuracy):
    return stress(rounded(1), **STEEL, density=7850, modes=1, supports=RIM).frequencies[0], None


@case("rotating disc: stress in the middle", "MPa", 3.3 / 8 * 7850 * 100 ** 2 * 1e-6, "Timoshenko1951")
def rotating_disc(accuracy):
    result = stress(rounded(1), **STEEL, density=7850, accuracy=accuracy, loads=[{"angular_velocity": 100, "axis": [0, 0, 1]}],
                    supports=fixed_in_plane([-0.5, 0, 0], [0.5, 0, 0]) + [{"point": point, "directions": [[0, 0, 1]]} for point in
                                                                         ([0.5, 0, 0], [-0.5, 0.3, 0], [-0.3, -0.5, 0])])
    one = result.load_case()
    return 1e-6 * result.at([0, 0, 0]).von_mises_middle, one.stress_spread / one.max_von_mises


# Shells: hyperbolic paraboloid, cylinders under pressure.


@case("hyperbolic paraboloid, t/L = 1e-3, clamped on one side, weight: deflection", "m", 6.3941e-3, "Bathe2000")
def hyperbolic_paraboloid(accuracy):
    s = np.linspace(-0.5, 0.5, 41)[:, None]
    sides = {"west": (-0.5 + 0 * s, s), "east": (0.5 + 0 * s, s), "south": (s, -0.5 + 0 * s), "north": (s, 0.5 + 0 * s)}
    model = batten.skin({name: np.hstack([x, y, x * x - y * y]) for name, (x, y) in sides.items()}, unit="m", fit_tolerance=1e-7)
    return displacement(model, [0.5, 0, 0.25], 2, accuracy, -1, young=2e11, poisson=0.3, thickness=1e-3, supports=["west"],
                        loads=[{"traction": [0, 0, -8]}])


def external_pressure(ratio, t=0.01, E=210e9):
    """Von Mises' formula for lateral pressure on a cylinder of radius 1 m with simply supported ends."""
    wave = math.pi / ratio
    return min(E * t / (n * n - 1) * (wave ** 4 / (n * n + wave ** 2) ** 2 + t * t / (12 * 0.91) * (n * n - 1 + wave ** 2) ** 2)
               for n in range(2, 20))


def pressed_cylinder(ratio):
    """Half of the circumference between planes of symmetry, which contains modes of any number of waves."""
    low, high = (arc([0, 0, z], [1, 0, 0], [0, 1, 0], 0, 180, 97) for z in (0, ratio / 2))
    model = batten.skin({"end": low, "b": [low[-1], high[-1]], "middle": high[::-1], "a": [high[0], low[0]]}, unit="m", fit_tolerance=1e-5,
                        edge_length=0.08)
    inwards = -1 if model.normals[0] @ (model.points[0] * [1, 1, 0]) > 0 else 1
    result = stress(model, young=210e9, poisson=0.3, thickness=0.01, buckling=1, loads=[{"pressure": inwards * 1e5}],
                    supports=[held("end", 0, 1), {"curve": "middle", "type": "symmetric", "normal": [0, 0, 1]},
                              {"curve": "a", "type": "symmetric", "normal": [0, 1, 0]}, {"curve": "b", "type": "symmetric", "normal": [0, 1, 0]}])
    return result.load_case().buckling_factors[0], None


for ratio in (2, 10):
    case(f"cylinder, L/R = {ratio}, simply supported, external pressure: buckling factor", "", external_pressure(ratio) / 1e5,
         "Windenburg1934")(lambda accuracy, ratio=ratio: pressed_cylinder(ratio))


@case("cylinder under internal pressure: largest stress, at its clamped end", "MPa",
      6 / 0.01 ** 2 * 1e5 / (2 * math.sqrt(3 * 0.91) / 0.01) * math.sqrt(1 - 0.3 + 0.09) * 1e-6, "Timoshenko1959")
def edge_stress(accuracy):
    low, high = (arc([0, 0, z], [1, 0, 0], [0, 1, 0], 0, 90) for z in (0, 1))
    model = batten.skin({"end": low, "gy": [low[-1], high[-1]], "high": high[::-1], "gx": [high[0], low[0]]}, unit="m", fit_tolerance=1e-6)
    one = stress(model, young=210e9, poisson=0.3, thickness=0.01, accuracy=accuracy, loads=[{"pressure": 1e5}],
                 supports=["end", {"curve": "gx", "type": "symmetric", "normal": [0, 1, 0]},
                           {"curve": "gy", "type": "symmetric", "normal": [1, 0, 0]}]).load_case()
    return 1e-6 * one.max_von_mises, one.stress_spread / one.max_von_mises


# A stiffener: a narrow plate with a flat bar on one side is a beam.

BREADTH, SHEET, RIB, HEIGHT, SPAN = 30, 2, 3, 20, 400
AXIS = RIB * HEIGHT * (SHEET + HEIGHT) / 2 / (BREADTH * SHEET + RIB * HEIGHT)
SECOND_MOMENT = (BREADTH * SHEET ** 3 + RIB * HEIGHT ** 3) / 12 + BREADTH * SHEET * AXIS ** 2 + RIB * HEIGHT * ((SHEET + HEIGHT) / 2 - AXIS) ** 2


@case("cantilever plate with a rib on one side, force at its tip: deflection", "mm", 10 * SPAN ** 3 / (3 * 210e3 * SECOND_MOMENT), "Timoshenko1955")
def ribbed_cantilever(accuracy):
    half = BREADTH / 2
    model = batten.skin({"south": [[0, -half, 0], [SPAN, -half, 0]], "tip": [[SPAN, -half, 0], [SPAN, half, 0]],
                         "north": [[SPAN, half, 0], [0, half, 0]], "root": [[0, half, 0], [0, -half, 0]],
                         "rib": [[0, 0, 0], [SPAN, 0, 0]]}, inner=["rib"], unit="mm")
    result = analyse(model, accuracy=accuracy, thickness=SHEET, supports=["root"], loads=[{"curve": "tip", "force": [0, 0, 10 / BREADTH]}],
                           settings=f'young = 210e3\npoisson = 0\nstiffeners = [{{ curve = "rib", rectangle = [{RIB}, {HEIGHT}] }}]')
    one = result.load_case()
    return result.at([SPAN, 0, 0]).displacement[2], one.max_displacement_error / one.max_displacement


@case("plate 800 × 600 × 4 with a flat bar 4 × 30, simply supported, traction: deflection", "mm", 0.2800, "CalculiX", target=0.02)
def stiffened_panel(accuracy):
    """The reference is CalculiX with eight-node shells (S8R), also for the web of the bar."""
    curves = {"south 1": [[0, 0, 0], [400, 0, 0]], "south 2": [[400, 0, 0], [800, 0, 0]], "east": [[800, 0, 0], [800, 600, 0]],
              "north 2": [[800, 600, 0], [400, 600, 0]], "north 1": [[400, 600, 0], [0, 600, 0]], "west": [[0, 600, 0], [0, 0, 0]],
              "rib": [[400, 0, 0], [400, 600, 0]]}
    model = batten.skin(curves, unit="mm")
    supports = [held("south 1", 1, 2), held("south 2", 1, 2), held("north 1", 2), held("north 2", 2), held("east", 2), held("west", 0, 2)]
    result = analyse(model, material="steel", thickness=4, accuracy=accuracy, supports=supports, loads=[{"traction": [0, 0, -0.002]}],
                           settings='stiffeners = [{ curve = "rib", rectangle = [4, 30] }]')
    one = result.load_case()
    return one.max_displacement, one.max_displacement_error / one.max_displacement
