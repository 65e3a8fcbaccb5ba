#include "batten/analysis/models/shell_ties.h"

#include <algorithm>

#include "batten/analysis/models/line_rotation.h"
#include "batten/analysis/models/line_sides.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

void tie_rotations(const std::string& name, const JoinEdge& a, const JoinEdge& b,
                   const Points& shape, ConstraintSet& set) {
  const LineRotation of_a(a, shape), of_b(b, shape);
  if (!a.embedded() && !b.embedded()) {
    for (int k = 0; k < a.count(); ++k) {
      CoupledEntries row;
      of_a.at_vertex(k, 1, row);
      of_b.at_vertex(k, -1, row);
      add_summed(name, row, 0, set);
    }
    for (int k = 0; k + 1 < a.count(); ++k) {
      CoupledEntries row;
      of_a.in_middle(k, 1, row);
      of_b.in_middle(k, -1, row);
      add_summed(name, row, 0, set);
    }
    return;
  }
  LineSides::over_hats(a, b, [&](const std::vector<HatPoint>& hat, double weight) {
    CoupledEntries row;
    for (const HatPoint& p : hat) {
      of_a.at_fraction(p.f, p.weight / weight, row);
      of_b.at_fraction(p.f, -p.weight / weight, row);
    }
    add_summed(name, row, 0, set);
  });
}

}  // namespace

ConstraintSet shell_ties(const ModelLayout& model, const Points& shape,
                         const std::vector<std::string>& hinges) {
  for (const std::string& hinge : hinges)
    if (model.model_line(hinge).sides.size() < 2)
      throw InputError("the hinge '" + hinge + "' is a rim: it has one region, expected two");
  ConstraintSet set(static_cast<int>(shape.rows()), ConstraintSet::Kind::Coupled);
  LineSides sides(model);
  for (const JoinLine& line : model.shared_lines()) {
    add_line_ties(sides.regions(), sides.numbers(), line, set);
    if (std::find(hinges.begin(), hinges.end(), line.name) != hinges.end()) continue;
    const JoinEdge a = sides(line.sides[0]), b = sides(line.sides[1]);
    tie_rotations("joined line " + line.name, a, b, shape, set);
  }
  return set;
}

}  // namespace batten
