// Lines of a model as its regions have them, on the numbers of the whole model. Internal.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>
#include <string>

#include "batten/analysis/shell_section.h"
#include "batten/elements/c1_triangle.h"
#include "batten/elements/quadrature.h"
#include "batten/skinning/model/join_edge.h"
#include "batten/skinning/model/model_layout.h"
#include "batten/constraints/constraint_set.h"

namespace batten {

// Keeps what JoinEdge needs of a model; the sides it returns live no longer.
class LineSides {
 public:
  explicit LineSides(const ModelLayout& model)
      : regions_(layouts(model)),
        dof_offsets_(all_numbers(model)),
        sides_(regions_, dof_offsets_) {}

  JoinEdge operator()(const JoinSide& side) { return sides_(side); }
  // The first side of a line.
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

// The functions of the triangle that holds a place of the model, there.
inline ConstraintEntries shape_functions_at(const ModelLayout& model, const Location& where) {
  const ParametricMesh& mesh = *model.mesh();
  const Tabulation N = C1Triangle(model.element(), mesh.shape(where.triangle)).evaluate(where.L);
  const auto dofs = DofMap(mesh).triangle(mesh, where.triangle);
  ConstraintEntries entries;
  for (int m = 0; m < 12; ++m) entries.push_back({dofs[m], N(m, kW)});
  return entries;
}

// The place of the surface at a fraction of a line.
inline Vec3 point_on_line(const JoinEdge& side, const Points& shape, double f) {
  ConstraintEntries entries;
  side.add_at(f, 0, 0, 1, entries);
  Vec3 x = Vec3::Zero();
  for (const auto& e : entries) x += e.coefficient * shape.row(e.dof).transpose();
  return x;
}

// Calls visit(f, dl) at points of a line, dl being the length that each stands for: eight between
// stations of either side, from end to end. (Points where a line is held do not reach its corners,
// which are points of other lines.)
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

// Stiffness per length of the stiff springs of a line, of the section and the edge length there.
struct SpringStiffness {
  double displacement, rotation, edge;

  SpringStiffness(const Surface& model, const ShellSection& section, int triangle) {
    constexpr double alpha = 1000;
    const double area = model.mesh().shape(triangle).area *
                        model.jet({triangle, Vec3::Constant(1.0 / 3)}).area_vector().norm();
    const double t = section.thickness;
    edge = std::sqrt(2 * area);
    displacement = alpha * section.material.Q(0, 0) * t / edge;
    rotation = displacement * t * t / 12;
  }
};


// The rotation of a shell about a line, as rows on the dofs of one side. Internal.

using CoupledEntries = std::vector<ConstraintSet::CoupledEntry>;

// ω of shell_ties.h, a form of the displacement's dofs; each function adds factor · ω to a row.
class LineRotation {
 public:
  LineRotation(const JoinEdge& side, const Points& shape) : side_(side), shape_(shape) {}

  void at_vertex(int k, double factor, CoupledEntries& row) const;
  void at_edge_midpoint(int k, double factor, CoupledEntries& row) const;  // of the k-th edge
  void at_fraction(double f, double factor, CoupledEntries& row) const;

 private:
  Vec3 evaluate(const ConstraintEntries& entries) const;
  void add(const ConstraintEntries& across, const ConstraintEntries& along, double factor,
           CoupledEntries& row) const;
  const JoinEdge& side_;
  const Points& shape_;
};

// The part of a place along a direction, as a row.
inline CoupledEntries along(const Vec3& direction, const ConstraintEntries& position) {
  CoupledEntries row;
  for (const auto& e : position) row.push_back({e.dof, e.coefficient * direction});
  return row;
}

// Directions of a support at length 1. Throws InputError: none, or one of length zero.
std::vector<Vec3> unit_directions(const std::string& support, const std::vector<Vec3>& directions);

// Adds a row whose entries may name a dof more than once.
void add_summed(const std::string& name, const CoupledEntries& entries, double value,
                ConstraintSet& set);

}  // namespace batten
