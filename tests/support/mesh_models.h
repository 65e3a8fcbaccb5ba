// Own sheet-metal models as shell elements, for tests, benchmarks and examples of mesh deformers.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "batten/mesh/shell_mesh.h"

namespace batten_test {

using namespace batten;

/// Vertices or faces of a model under one name.
struct NamedSet {
  std::string name;
  std::vector<int> items;
};

/// Quads, conforming, all wound the same way, and what belongs to them.
struct MeshModel {
  ShellMesh shells;
  std::vector<Vec2> flat;          // of each vertex: where it was in the flat sheet
  std::vector<NamedSet> features;  // vertices of each form: rim, flange, wall, floor
  std::vector<NamedSet> rims;      // of each form: the edge of the hole or of the cavity, in order
  std::vector<NamedSet> lines;     // character lines, vertices in order
  std::vector<NamedSet> parts;     // faces: "sheet" and each form; every face in one of them
  std::vector<int> fixed, handle;  // vertices that a deformation would hold and move

  /// Vertices whose place in the flat sheet is wanted.
  std::vector<int> where(const std::function<bool(const Vec2&)>& wanted) const;
};

/// A sheet of columns × rows of cells. A cell is plain or holds one form in its middle: a hole, a
/// hole with a flange, a cavity, a boss, a bead.
struct SheetLayout {
  struct Span {
    double length;
    int elements;
  };
  /// One of the closed curves that a form is swept along, from inside out: `offset` away from the
  /// form's core, `height` over the sheet. On different radii the wall slopes, on one it is
  /// upright.
  struct Ring {
    double offset, height;
  };
  struct Form {
    std::string name;
    int column, row;
    std::vector<Ring> profile;  // the last one lies in the sheet: height 0
    bool floor = false;         // closed inside of the first ring
    Vec2 core = Vec2::Zero();   // half sides of a rectangle; 0, 0: the rings are circles
  };
  std::vector<Span> columns, rows;
  std::vector<Form> forms;
  /// Where the sheet's point (u, v) is; empty: flat. Forms are put on it as they are, in its
  /// tangent plane, and blended with it between their outline and the border of their cell. It may
  /// have creases along borders of cells.
  std::function<Vec3(double u, double v)> shape;
  int margin = 1;            // rows of plain quads between a cell's border and the O-grid inside
  std::vector<int> creases;  // lines along the lower borders of these rows of cells
};

/// Profiles of forms, cut in elements of at most `h`.
std::vector<SheetLayout::Ring> plain_hole(double radius);
/// Turned down by `depth`, with a fillet.
std::vector<SheetLayout::Ring> flanged_hole(double radius, double depth, double fillet, double h);
/// A floor `depth` under the sheet (a boss where it is negative) and a wall that runs out by `run`.
std::vector<SheetLayout::Ring> pocket(double outline, double depth, double run, double h);

/// Vertices on circles are there to rounding. Features, rims and parts are filled in, and lines.
MeshModel make_sheet(const SheetLayout& layout);

/// A square plate with a large hole in the middle and four small ones, 300 × 300, 2,784 vertices.
/// Fixed: the left border; handle: the right one.
MeshModel plate_with_holes();

/// A crowned panel with two sharp lines along it and a recess for a handle between them,
/// 1000 × 600, 2,982 vertices. Fixed: the lower border; handle: a patch at the upper right.
MeshModel door_panel();

/// The front of a car, bent round, with 3 × 7 long cavities, 1120 × 270, 3,200 vertices.
/// Fixed: the left border; handle: the right one.
MeshModel grill();

/// A flat sheet with 4 × 4 round cavities, 400 × 400, 3,009 vertices. Fixed: the left border;
/// handle: the right one.
MeshModel sheet_with_cavities();

/// A softly curved sheet, 400 × 400, with 4 × 4 flanged holes: as near to `vertices` as whole
/// numbers of elements come, within 6 % from 3,000 on. Fixed: strips along the left and right
/// borders; handle: a patch in the middle.
MeshModel holed_panel(int vertices);

/// The outer skin of something like a car, 600 × 400 mm, 5,437 vertices: four round holes, a slot
/// and an opening, all flanged, a bead, a character line. Fixed: the left border; handle: the right
/// one.
MeshModel panel();

}  // namespace batten_test
