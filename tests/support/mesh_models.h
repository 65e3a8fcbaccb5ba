// SPDX-License-Identifier: MPL-2.0
// Synthetic sheet-metal models of shell elements, for tests, benchmarks and examples of mesh
// deformers.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "batten/mesh/shell_mesh.h"

namespace batten_test {

using namespace batten;

/// A named set of vertices or faces of a model.
struct NamedSet {
  std::string name;
  std::vector<int> items;
};

/// Conforming quads with consistent winding, and their sets.
struct MeshModel {
  ShellMesh shells;
  std::vector<Vec2> flat;          // of each vertex: position in the flat sheet
  std::vector<NamedSet> features;  // vertices of each form: boundary, flange, wall, floor
  std::vector<NamedSet> rims;      // of each form: the edge of the hole or of the cavity, in order
  std::vector<NamedSet> lines;     // feature curves, vertices in order
  std::vector<NamedSet> parts;     // a partition of the faces: "sheet" and each form
  std::vector<int> fixed, handle;  // vertices that an edit fixes and moves

  /// Vertices whose position in the flat sheet is requested.
  std::vector<int> where(const std::function<bool(const Vec2&)>& wanted) const;
};

/// A sheet of columns × rows of cells. A cell is plain or contains one form in its middle: a hole,
/// a hole with a flange, a cavity, a boss, a bead.
struct SheetLayout {
  struct Span {
    double length;
    int elements;
  };
  /// One of the closed curves along which a form is swept, from inside to outside: `offset` from
  /// the form's core, `height` above the sheet. Different radii give a sloped wall, equal radii a
  /// vertical one.
  struct Ring {
    double offset, height;
  };
  struct Form {
    std::string name;
    int column, row;
    std::vector<Ring> profile;  // the last one is in the sheet: height 0
    bool floor = false;         // closed inside the first ring
    Vec2 core = Vec2::Zero();   // half sides of a rectangle; 0, 0: the rings are circles
  };
  std::vector<Span> columns, rows;
  std::vector<Form> forms;
  /// Position of the sheet's point (u, v); empty: flat. Forms are placed undeformed in its tangent
  /// plane, and blended with the sheet between their outline and the border of their cell. It may
  /// have creases along borders of cells.
  std::function<Vec3(double u, double v)> shape;
  int margin = 1;            // rows of plain quads between a cell's border and the O-grid inside
  std::vector<int> creases;  // curves along the lower borders of these rows of cells
};

/// Profiles of forms, divided into elements of at most `h`.
std::vector<SheetLayout::Ring> plain_hole(double radius);
/// Flange of length `depth` downwards, with a fillet.
std::vector<SheetLayout::Ring> flanged_hole(double radius, double depth, double fillet, double h);
/// A floor `depth` below the sheet (negative: a boss) and a wall with the horizontal extent `run`.
std::vector<SheetLayout::Ring> pocket(double outline, double depth, double run, double h);

/// Vertices on circles are exact to rounding. Fills in features, boundaries, parts and curves.
MeshModel make_sheet(const SheetLayout& layout);

/// A square plate with a large hole in the middle and four small ones, 300 × 300, 2,784 vertices.
/// Fixed: the left border; handle: the right one.
MeshModel plate_with_holes();

/// A crowned panel with two feature curves along it and a recess for a door handle between them,
/// 1000 × 600, 2,982 vertices. Fixed: the lower border; handle: a patch at the upper right.
MeshModel door_panel();

/// The curved front of a car with 3 × 7 long cavities, 1120 × 270, 3,200 vertices. Fixed: the left
/// border; handle: the right one.
MeshModel grill();

/// A flat sheet with 4 × 4 round cavities, 400 × 400, 3,009 vertices. Fixed: the left border;
/// handle: the right one.
MeshModel sheet_with_cavities();

/// A slightly curved sheet, 400 × 400, with 4 × 4 flanged holes. The number of vertices
/// approximates `vertices` within 6 % from 3,000 on. Fixed: strips along the left and right
/// borders; handle: a patch in the middle.
MeshModel holed_panel(int vertices);

/// An outer panel of a car, 600 × 400 mm, 5,437 vertices: four round holes, a slot and an opening,
/// all flanged, a bead, a feature curve. Fixed: the left border; handle: the right one.
MeshModel panel();

}  // namespace batten_test
