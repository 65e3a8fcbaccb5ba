#include "batten/analysis/models/shell_ties.h"

#include <algorithm>
#include <map>

#include "batten/core/errors.h"
#include "batten/skinning/model/join_edge.h"

namespace batten {
namespace {

using CoupledEntries = std::vector<ConstraintSet::CoupledEntry>;

// The rotation about a line as a form of the displacement's dofs, of one side.
class Rotations {
 public:
  Rotations(const JoinEdge& side, const Points& shape) : side_(side), shape_(shape) {}

  void at_vertex(int k, double factor, CoupledEntries& row) const {
    RowEntries across, along;
    side_.add_across(k, 1, across);
    side_.add_along(k, 1, along);
    add(across, along, factor, row);
  }
  void in_middle(int k, double factor, CoupledEntries& row) const {
    RowEntries across, along;
    side_.add_across_middle(k, 1, across);
    side_.add_along_middle(k, 1, along);
    add(across, along, factor, row);
  }
  void at_fraction(double f, double factor, CoupledEntries& row) const {
    RowEntries across, along;
    side_.add_at(f, 1, 0, 0, across);
    side_.add_at(f, 0, 1, 0, along);
    add(across, along, factor, row);
  }

 private:
  Vec3 of_shape(const RowEntries& entries) const {
    Vec3 sum = Vec3::Zero();
    for (const auto& e : entries) sum += e.coefficient * shape_.row(e.dof).transpose();
    return sum;
  }
  void add(const RowEntries& across, const RowEntries& along, double factor,
           CoupledEntries& row) const {
    const Vec3 y = of_shape(across), x_t = of_shape(along);
    const double speed = x_t.norm();
    const Vec3 tau = x_t / speed, n = y.cross(x_t).normalized();
    const double a = y.dot(tau.cross(n)), b = y.dot(tau);
    if (!n.allFinite() || !(std::abs(a) > 1e-9 * y.norm()))
      throw InputError("the surface has no normal along a line that regions share");
    for (const auto& e : across) row.push_back({e.dof, -factor * e.coefficient / a * n});
    for (const auto& e : along)
      row.push_back({e.dof, factor * e.coefficient * b / (speed * a) * n});
  }

  const JoinEdge& side_;
  const Points& shape_;
};

void add_row(const std::string& name, const CoupledEntries& entries, ConstraintSet& set) {
  std::map<int, Vec3> sum;
  for (const auto& e : entries) sum.try_emplace(e.dof, Vec3::Zero()).first->second += e.coefficient;
  CoupledEntries row;
  for (const auto& [dof, coefficient] : sum) row.push_back({dof, coefficient});
  set.add_coupled(name, std::move(row), 0);
}

void tie_rotations(const std::string& name, const JoinEdge& a, const JoinEdge& b,
                   const Points& shape, ConstraintSet& set) {
  const Rotations of_a(a, shape), of_b(b, shape);
  if (!a.embedded() && !b.embedded()) {
    for (int k = 0; k < a.count(); ++k) {
      CoupledEntries row;
      of_a.at_vertex(k, 1, row);
      of_b.at_vertex(k, -1, row);
      add_row(name, row, set);
    }
    for (int k = 0; k + 1 < a.count(); ++k) {
      CoupledEntries row;
      of_a.in_middle(k, 1, row);
      of_b.in_middle(k, -1, row);
      add_row(name, row, set);
    }
    return;
  }
  for (const auto& hat : hats(tie_stations(a, b), a.closed(), {true, true})) {
    CoupledEntries row;
    double weight = 0;
    for (const HatPoint& p : hat) weight += p.weight;
    for (const HatPoint& p : hat) {
      of_a.at_fraction(p.f, p.weight / weight, row);
      of_b.at_fraction(p.f, -p.weight / weight, row);
    }
    add_row(name, row, set);
  }
}

}  // namespace

ConstraintSet shell_ties(const ModelLayout& model, const Points& shape,
                         const std::vector<std::string>& hinges) {
  std::vector<const RegionLayout*> regions;
  std::vector<RegionNumbers> numbers;
  for (int r = 0; r < model.region_count(); ++r) {
    regions.push_back(&model.region(r));
    numbers.push_back(model.numbers(r));
  }
  for (const std::string& hinge : hinges)
    if (model.model_line(hinge).sides.size() < 2)
      throw InputError("the hinge '" + hinge + "' is a rim: it has one region, expected two");
  ConstraintSet set(static_cast<int>(shape.rows()), ConstraintSet::Kind::Coupled);
  JoinEdges sides(regions, numbers);
  for (const JoinLine& line : model.shared_lines()) {
    add_line_ties(regions, numbers, line, set);
    if (std::find(hinges.begin(), hinges.end(), line.name) != hinges.end()) continue;
    const JoinEdge a = sides(line.sides[0]), b = sides(line.sides[1]);
    tie_rotations("joined line " + line.name, a, b, shape, set);
  }
  return set;
}

}  // namespace batten
