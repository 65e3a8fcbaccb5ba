// SPDX-License-Identifier: MPL-2.0
// Curves shared by regions of a model: the sides of a curve, and constraints and springs along it,
// in the dofs of the whole model.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "batten/analysis/shell_section.h"
#include "batten/constraints/constraint_set.h"
#include "batten/elements/c1_triangle.h"
#include "batten/elements/quadrature.h"
#include "batten/skinning/model/join_edge.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {

// Creates the sides of curves of a model (JoinEdge) with their dofs. The returned sides refer to
// data of this object and must not outlive it.
class LineSides {
 public:
  explicit LineSides(const ModelLayout& model)
      : regions_(layouts(model)),
        dof_offsets_(all_numbers(model)),
        sides_(regions_, dof_offsets_) {}

  // The side of a curve that belongs to one region.
  JoinEdge operator()(const JoinSide& side) { return sides_(side); }
  // The first side of a curve.
  JoinEdge operator()(const ModelLine& line) {
    const LineSide& first = line.sides[0];
    return sides_({first.region, first.embedded, first.index, true});
  }
  const std::vector<const RegionLayout*>& regions() const { return regions_; }
  const std::vector<DofOffsets>& dof_offsets() const { return dof_offsets_; }

 private:
  static std::vector<const RegionLayout*> layouts(const ModelLayout& model) {
    std::vector<const RegionLayout*> regions;
    for (const auto& region : model.regions()) regions.push_back(region.get());
    return regions;
  }
  static std::vector<DofOffsets> all_numbers(const ModelLayout& model) {
    std::vector<DofOffsets> dof_offsets;
    for (int r = 0; r < model.region_count(); ++r) dof_offsets.push_back(model.dof_offsets(r));
    return dof_offsets;
  }

  std::vector<const RegionLayout*> regions_;
  std::vector<DofOffsets> dof_offsets_;
  JoinEdgeFactory sides_;
};

// Shape functions at a location of the model, as coefficients of its dofs.
inline ConstraintEntries shape_functions_at(const ModelLayout& model, const Location& where) {
  const ParametricMesh& mesh = *model.mesh();
  const Tabulation N = C1Triangle(model.element(), mesh.shape(where.triangle)).evaluate(where.L);
  const auto dofs = DofMap(mesh).triangle(mesh, where.triangle);
  ConstraintEntries entries;
  for (int m = 0; m < 12; ++m) entries.push_back({dofs[m], N(m, kW)});
  return entries;
}

// Value of a linear form of the dofs.
inline Vec3 value_of(const ConstraintEntries& entries, const Points& dofs) {
  Vec3 sum = Vec3::Zero();
  for (const auto& e : entries) sum += e.coefficient * dofs.row(e.dof).transpose();
  return sum;
}

// Point of the surface at a fraction f in [0, 1] of a curve.
inline Vec3 point_on_line(const JoinEdge& side, const Points& shape, double f) {
  ConstraintEntries entries;
  side.add_at(f, 0, 0, 1, entries);
  return value_of(entries, shape);
}

// Calls visit(f, dl) at points along a whole curve: eight between neighbouring stations of either
// side. dl: the length that each point represents. (Points at which embedded curves are constrained
// do not include the corners, which are points of other curves.)
template <class Visit>
void for_each_line_point(const JoinEdge& a, const JoinEdge& b, const Visit& visit) {
  std::vector<double> at = a.stations();
  const std::vector<double> more = b.stations();
  at.insert(at.end(), more.begin(), more.end());
  at.insert(at.end(), {0.0, 1.0});
  std::sort(at.begin(), at.end());
  constexpr int points = 4;
  static const SegmentRule rule = gauss_legendre(points);
  constexpr double kMinLength = 1e-12;
  for (size_t i = 0; i + 1 < at.size(); ++i) {
    if (at[i + 1] - at[i] < kMinLength) continue;
    for (int half = 0; half < 2; ++half) {
      const double from = lerp(at[i], at[i + 1], 0.5 * half), width = 0.5 * (at[i + 1] - at[i]);
      for (int p = 0; p < points; ++p) {
        const double f = from + width * rule.s[p];
        visit(f, rule.weights[p] * width * a.span() * a.slope(f).norm());
      }
    }
  }
}

// Penalty stiffness per length for springs along a curve, from the section and the local edge
// length.
struct SpringStiffness {
  double displacement, rotation, edge;

  SpringStiffness(const Surface& model, const ShellSection& section, int triangle) {
    constexpr double alpha = 1000;
    const double area = model.mesh().shape(triangle).area *
                        model.jet({triangle, Vec3::Constant(1.0 / 3)}).area_vector().norm();
    edge = std::sqrt(2 * area);
    displacement = alpha * section.membrane_stiffness() / edge;
    rotation = alpha * section.bending_stiffness() / edge;
  }
};

// Rotation of a shell about a curve, as a linear form of the dofs of one side.

using CoupledEntries = std::vector<ConstraintSet::CoupledEntry>;

// The rotation ω of shell_ties.h as a linear form of the displacement dofs. Each function adds
// factor · ω to the coefficients `row`.
class LineRotation {
 public:
  LineRotation(const JoinEdge& side, const Points& shape) : side_(side), shape_(shape) {}

  void at_vertex(int k, double factor, CoupledEntries& row) const;
  // At the midpoint of the k-th edge.
  void at_edge_midpoint(int k, double factor, CoupledEntries& row) const;
  void at_fraction(double f, double factor, CoupledEntries& row) const;

 private:
  void add(const ConstraintEntries& across, const ConstraintEntries& along, double factor,
           CoupledEntries& row) const;
  const JoinEdge& side_;
  const Points& shape_;
};

// Component of a position along a direction, as coefficients of the dofs.
inline CoupledEntries along(const Vec3& direction, const ConstraintEntries& position) {
  CoupledEntries row;
  for (const auto& e : position) row.push_back({e.dof, e.coefficient * direction});
  return row;
}

// Normalises the directions of a support. Throws InputError if there are none or one has zero
// length.
std::vector<Vec3> unit_directions(const std::string& support, const std::vector<Vec3>& directions);

// Adds a coupled constraint whose entries may contain a dof more than once.
void add_summed(const std::string& name, const CoupledEntries& entries, double value,
                ConstraintSet& set);

}  // namespace batten
