# SPDX-License-Identifier: MPL-2.0
"""A figure, 1.75 m tall: the smoothed boundary of a set of small cubes, posed by a skeleton. It faces x; z is up. Examples 24
to 27 use it."""

import math
import struct

CUBE = 0.07  # m
HIP, KNEE, ANKLE = 0.84, 0.46, 0.10
SHOULDER, ELBOW, NECK = 1.33, 1.02, 1.42
SIDE = {"left": 1, "right": -1}


def cubes():
    def block(xs, ys, zs):
        return {(x, y, z) for x in range(*xs) for y in range(*ys) for z in range(*zs)}

    inside = block((-1, 1), (-3, 3), (12, 20))  # trunk
    inside |= block((-1, 1), (-1, 1), (20, 21)) | block((-2, 2), (-2, 2), (21, 25))  # neck, head
    for y in (1, -3):  # legs and feet
        inside |= block((-1, 1), (y, y + 2), (0, 12)) | block((1, 3), (y, y + 2), (0, 1))
    for y in (4, -6):  # arms, hanging
        inside |= block((-1, 1), (y, y + 2), (10, 20))
    return inside | block((-1, 1), (-6, 6), (18, 20))  # shoulders


def surface(inside):
    """The boundary faces of the cubes, counter-clockwise seen from outside."""
    numbers, points, faces = {}, [], []

    def number(p):
        if p not in numbers:
            numbers[p] = len(points)
            points.append([c * CUBE for c in p])
        return numbers[p]

    for cube in sorted(inside):
        for axis in range(3):
            for side in (0, 1):
                beside = list(cube)
                beside[axis] += 2 * side - 1
                if tuple(beside) in inside:
                    continue
                a, b = (axis + 1) % 3, (axis + 2) % 3
                loop = [(0, 0), (1, 0), (1, 1), (0, 1)]
                face = []
                for i, j in loop if side else reversed(loop):
                    corner = list(cube)
                    corner[axis] += side
                    corner[a] += i
                    corner[b] += j
                    face.append(number(tuple(corner)))
                faces.append(face)
    return points, faces


def smoothed(points, faces, passes=14):
    """Smooths the corners. Every other pass has the opposite sign, so that limbs keep their width."""
    beside = [set() for _ in points]
    for f in faces:
        for k in range(4):
            beside[f[k]].add(f[k - 1])
            beside[f[k - 1]].add(f[k])
    for k in range(passes):
        step = 0.55 if k % 2 == 0 else -0.45
        points = [
            [p[c] + step * (sum(points[n][c] for n in sorted(around)) / len(around) - p[c]) for c in range(3)]
            for p, around in zip(points, beside)
        ]
    return points


def figure():
    """Node positions of the upright figure, and the faces."""
    points, faces = surface(cubes())
    points = smoothed(points, faces)
    low = 0.015  # height of the flat soles, m
    for p in points:
        p[2] = max(p[2], low) - low
        if p[2] > 0.8:  # widens the chest
            p[0] *= 1 + 0.5 * math.exp(-(((p[2] - 1.2) / 0.2) ** 2)) * (abs(p[1]) < 0.24)
    return points, faces


def ramp(t):
    t = min(1.0, max(0.0, t))
    return t * t * (3 - 2 * t)


def turned(p, centre, degrees):
    """Rotates p about an axis along y through the centre. A positive angle moves points below the centre forward."""
    a = math.radians(degrees)
    x, z = p[0] - centre[0], p[2] - centre[2]
    return [centre[0] + x * math.cos(a) - z * math.sin(a), p[1], centre[2] + x * math.sin(a) + z * math.cos(a)]


def mixed(p, q, w):
    return [a + w * (b - a) for a, b in zip(p, q)]


def legs_for(hip, ankle):
    """Angles in degrees of thigh and shin for given hip and ankle positions, with the knee in front (inverse kinematics)."""
    x, z = ankle[0] - hip[0], hip[1] - ankle[1]
    thigh, shin = HIP - KNEE, KNEE - ANKLE
    reach = min(math.hypot(x, z), 0.9999 * (thigh + shin))
    at_hip = math.acos((thigh**2 + reach**2 - shin**2) / (2 * thigh * reach))
    at_ankle = math.acos((shin**2 + reach**2 - thigh**2) / (2 * shin * reach))
    towards = math.atan2(x, z)
    return math.degrees(towards + at_hip), math.degrees(towards - at_ankle)


def posed(points, pose):
    """Node positions in a pose. Keys of `pose`, angles in degrees: "hip": (x, z) of the pelvis; "lean" of the trunk; "nod" of
    the head; for "left" and "right": "ankle": (x, z), "foot": toes up, "arm" and "elbow": forward."""
    hip_x, hip_z = pose["hip"]
    up = hip_z - HIP
    placed = []
    for p in points:
        body = turned([p[0] + hip_x, p[1], p[2] + up], (hip_x, 0, hip_z), -pose.get("lean", 0) * ramp((p[2] - HIP) / 0.2))
        centre = turned([hip_x, 0, NECK + up], (hip_x, 0, hip_z), -pose.get("lean", 0))
        q = mixed(body, turned(body, centre, -pose.get("nod", 0)), ramp((p[2] - NECK + 0.03) / 0.1))
        side = "left" if p[1] > 0 else "right"
        limb = pose[side]
        if abs(p[1]) > 0.24 and p[2] > 0.6:  # the arm
            lean = pose.get("lean", 0)
            joint = turned([hip_x, 0, SHOULDER + up], (hip_x, 0, hip_z), -lean)
            straight = turned([p[0] + hip_x, p[1], p[2] + up], (hip_x, 0, hip_z), -lean)
            elbow = turned([hip_x, 0, ELBOW + up], (hip_x, 0, hip_z), -lean)
            bent = mixed(straight, turned(straight, elbow, limb["elbow"]), ramp((ELBOW + 0.07 - p[2]) / 0.14))
            q = mixed(body, turned(bent, joint, limb["arm"]), ramp((abs(p[1]) - 0.2) / 0.1))
        elif p[2] < HIP + 0.06:  # the leg
            thigh, shin = legs_for((hip_x, hip_z), limb["ankle"])
            at_rest = [p[0] + hip_x, p[1], p[2] + up]
            upper = turned(at_rest, (hip_x, 0, hip_z), thigh)
            knee = turned([hip_x, 0, KNEE + up], (hip_x, 0, hip_z), thigh)
            lower = turned([p[0] + knee[0], p[1], p[2] - KNEE + knee[2]], knee, shin)
            ankle = (limb["ankle"][0], 0, limb["ankle"][1])
            foot = turned([p[0] + ankle[0], p[1], p[2] - ANKLE + ankle[2]], ankle, limb["foot"])
            q = mixed(q, upper, ramp((HIP + 0.06 - p[2]) / 0.12))
            q = mixed(q, lower, ramp((KNEE + 0.08 - p[2]) / 0.16))
            q = mixed(q, foot, ramp((ANKLE + 0.03 - p[2]) / 0.06))
        placed.append(q)
    return placed


def write_obj(file, points, faces):
    with open(file, "w") as out:
        for p in points:
            out.write("v " + " ".join(f"{c + 0.0:.5f}" for c in p) + "\n")
        for f in faces:
            out.write("f " + " ".join(str(v + 1) for v in f) + "\n")


def write_cache(file, frames):
    """Writes a point cache (PC2): single precision, first frame number 0."""
    with open(file, "wb") as out:
        out.write(struct.pack("<12siiffi", b"POINTCACHE2\0", 1, len(frames[0]), 0, 1, len(frames)))
        for frame in frames:
            for p in frame:
                out.write(struct.pack("<3f", *(round(c, 5) + 0.0 for c in p)))
