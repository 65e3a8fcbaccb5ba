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
  for (int k = 0; k < a.count(); ++k) {
    CoupledEntries row;
    of_a.at_vertex(k, 1, row);
    of_b.at_vertex(k, -1, row);
    add_summed(name, row, 0, set);
  }
  for (int k = 0; k + 1 < a.count(); ++k) {
    CoupledEntries row;
    of_a.at_edge_midpoint(k, 1, row);
    of_b.at_edge_midpoint(k, -1, row);
    add_summed(name, row, 0, set);
  }
}

// stiffness(f): of the stiffer side.
template <class Stiffness>
void add_springs(const std::string& name, const JoinEdge& a, const JoinEdge& b, const Points& shape,
                 bool hinge, const Stiffness& stiffness, ShellSprings& springs) {
  const LineRotation of_a(a, shape), of_b(b, shape);
  for_each_line_point(a, b, [&](double f, double dl) {
    const SpringStiffness k = stiffness(f);
    ConstraintEntries apart;
    a.add_at(f, 0, 0, 1, apart);
    b.add_at(f, 0, 0, -1, apart);
    for (int c = 0; c < 3; ++c)
      springs.add(name, along(Vec3::Unit(c), apart), k.displacement * dl, 0);
    if (hinge) return;
    CoupledEntries row;
    of_a.at_fraction(f, 1, row);
    of_b.at_fraction(f, -1, row);
    springs.add(name, row, k.rotation * dl, 0);
  });
}

}  // namespace

ShellTies shell_ties(const ModelLayout& model, const Points& shape,
                     const std::vector<ShellSection>& sections,
                     const std::vector<std::string>& hinges) {
  for (const std::string& hinge : hinges)
    if (model.model_line(hinge).sides.size() < 2)
      throw InputError("the hinge '" + hinge + "' is a rim: it has one region, expected two");
  const int count = static_cast<int>(shape.rows());
  ShellTies ties{ConstraintSet(count, ConstraintSet::Kind::Coupled), ShellSprings(count)};
  LineSides sides(model);
  const Surface surface = model.surface(shape);
  for (const JoinLine& line : model.shared_lines()) {
    const std::string name = "joined line " + line.name;
    const bool hinge = std::find(hinges.begin(), hinges.end(), line.name) != hinges.end();
    const JoinEdge a = sides(line.sides[0]), b = sides(line.sides[1]);
    if (!a.embedded() && !b.embedded()) {
      add_line_ties(sides.regions(), sides.dof_offsets(), line, ties.constraints);
      if (!hinge) tie_rotations(name, a, b, shape, ties.constraints);
      continue;
    }
    const auto of_side = [&](int s, const JoinEdge& side, double f) {
      const int r = line.sides[s].region;
      return SpringStiffness(surface, sections[sections.size() == 1 ? 0 : r],
                             model.first_triangle(r) + side.where(f).triangle);
    };
    add_springs(
        name, a, b, shape, hinge,
        [&](double f) {
          SpringStiffness k = of_side(0, a, f);
          const SpringStiffness other = of_side(1, b, f);
          k.displacement = std::max(k.displacement, other.displacement);
          k.rotation = std::max(k.rotation, other.rotation);
          return k;
        },
        ties.springs);
  }
  return ties;
}

}  // namespace batten
