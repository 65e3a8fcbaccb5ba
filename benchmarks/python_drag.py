# SPDX-License-Identifier: MPL-2.0
"""The drag of bench_python: SCENE EVENTS WARM.

Prints the median seconds per event and the sum of all coordinates.
"""

import statistics
import sys
import time

import batten

scene, events, warm = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
batten.set_threads(1)
session = batten.Session(scene)
times = []
for k in range(-warm, events):
    # C++ semantics of %: the result has the sign of k.
    a, b, c = (abs(k) % n * (1 if k >= 0 else -1) for n in (7, 5, 11))
    start = time.process_time()
    session["pin.x"] = 0.43 + 1e-4 * a
    session["pin.y"] = 0.57 + 1e-4 * b
    session["pin.z"] = 0.12 + 1e-3 * c
    session.update()
    points = session.points
    if k >= 0:
        times.append(time.process_time() - start)
total = 0.0
for x in points.ravel().tolist():
    total += x
print(repr(statistics.median(times)), repr(total))
