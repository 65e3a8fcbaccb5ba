#!/usr/bin/env python3
# SPDX-License-Identifier: MPL-2.0
"""Writes wall.obj: a wall of 500 x 260 mm, quads of 5 mm, with the letters H, U, T raised by 15 mm.

    python3 make_wall.py > wall.obj
"""

COLUMNS, ROWS, PITCH, HEIGHT, LEVELS = 100, 52, 5.0, 15.0, 3
STROKES = {  # boxes in grid cells: first column, first row, number of columns, number of rows
    "H": [(0, 0, 6, 28), (14, 0, 6, 28), (0, 11, 20, 6)],
    "U": [(0, 0, 6, 28), (14, 0, 6, 28), (0, 0, 20, 6)],
    "T": [(7, 0, 6, 28), (0, 22, 20, 6)],
}
PLACES = {"H": 12, "U": 40, "T": 68}
FIRST_ROW = 12


def raised():
    cells = set()
    for letter, boxes in STROKES.items():
        for column, row, columns, rows in boxes:
            for i in range(columns):
                for j in range(rows):
                    cells.add((PLACES[letter] + column + i, FIRST_ROW + row + j))
    return cells


def main():
    up = raised()
    numbers, lines, faces = {}, [], []

    def vertex(i, j, level):
        key = (i, j, level)
        if key not in numbers:
            numbers[key] = len(numbers) + 1
            lines.append(f"v {i * PITCH:g} {j * PITCH:g} {level * HEIGHT / LEVELS:g}")
        return numbers[key]

    for j in range(ROWS):
        for i in range(COLUMNS):
            level = LEVELS if (i, j) in up else 0
            corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
            faces.append([vertex(*c, level) for c in corners])
            if level == 0:
                continue
            # The side walls of a letter.
            beside = [(i, j - 1), (i + 1, j), (i, j + 1), (i - 1, j)]
            for k in range(4):
                if beside[k] in up:
                    continue
                a, b = corners[k], corners[(k + 1) % 4]
                for l in range(LEVELS):
                    faces.append([vertex(*a, l), vertex(*b, l), vertex(*b, l + 1), vertex(*a, l + 1)])
    print("# A wall with three raised letters, millimetres (make_wall.py).")
    print("\n".join(lines))
    for face in faces:
        print("f", *face)


main()
