#include "batten/analysis/models/line_supports.h"

#include "batten/analysis/models/line_rotation.h"
#include "batten/analysis/models/line_sides.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

void constrain_edge_aligned(const JoinEdge& side, const Points& shape, const LineSupport& support,
                            const std::vector<Vec3>& directions, ConstraintSet& set) {
  for (const Vec3& direction : directions)
    for (int k = 0; k < side.count(); ++k) {
      ConstraintEntries position, slope;
      side.add_position(k, 1, position);
      side.add_along(k, 1, slope);
      add_summed(support.name, along(direction, position), direction.dot(support.displacement),
                 set);
      add_summed(support.name, along(direction, slope), 0, set);
    }
  if (!support.rotation) return;
  const LineRotation rotation(side, shape);
  for (int k = 0; k < side.count(); ++k) {
    CoupledEntries row;
    rotation.at_vertex(k, 1, row);
    add_summed(support.name, row, 0, set);
  }
  for (int k = 0; k + 1 < side.count(); ++k) {
    CoupledEntries row;
    rotation.at_edge_midpoint(k, 1, row);
    add_summed(support.name, row, 0, set);
  }
}

template <class Stiffness>
void constrain_by_springs(const JoinEdge& side, const Points& shape, const LineSupport& support,
                          const std::vector<Vec3>& directions, const Stiffness& stiffness,
                          ShellSprings& springs) {
  const LineRotation rotation(side, shape);
  bool any = false;
  for_each_line_point(side, side, [&](double f, double dl) {
    if (support.box && !support.box->contains(point_on_line(side, shape, f))) return;
    any = true;
    const SpringStiffness k = stiffness(f);
    ConstraintEntries position;
    side.add_at(f, 0, 0, 1, position);
    for (const Vec3& direction : directions)
      springs.add(support.name, along(direction, position), k.displacement * dl,
                  direction.dot(support.displacement));
    if (!support.rotation) return;
    CoupledEntries row;
    rotation.at_fraction(f, 1, row);
    springs.add(support.name, row, k.rotation * dl, 0);
  });
  if (!any)
    throw InputError("support '" + support.name + "' has a box that holds nothing of the line");
}

const std::vector<Vec3> kAll = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};

}  // namespace

LineSupport LineSupport::clamped(const std::string& line) {
  return {"clamped " + line, line, kAll, Vec3::Zero(), true};
}

LineSupport LineSupport::pinned(const std::string& line) {
  return {"pinned " + line, line, kAll, Vec3::Zero(), false};
}

LineSupport LineSupport::symmetric(const std::string& line, const Vec3& normal) {
  return {"symmetric " + line, line, {normal}, Vec3::Zero(), true};
}

void add_support(const ModelLayout& model, const Points& shape,
                 const std::vector<ShellSection>& sections, const LineSupport& support,
                 ShellTies& ties) {
  if (support.directions.empty() && !support.rotation)
    throw InputError("support '" + support.name +
                     "' holds nothing: expected directions or the rotation");
  const std::vector<Vec3> directions = support.directions.empty()
                                           ? std::vector<Vec3>{}
                                           : unit_directions(support.name, support.directions);
  LineSides sides(model);
  const ModelLine& line = model.model_line(support.line);
  const JoinEdge side = sides(line);
  if (!side.embedded() && !support.box) {
    constrain_edge_aligned(side, shape, support, directions, ties.constraints);
    return;
  }
  const int r = line.sides[0].region;
  const Surface surface = model.surface(shape);
  constrain_by_springs(
      side, shape, support, directions,
      [&](double f) {
        return SpringStiffness(surface, sections[sections.size() == 1 ? 0 : r],
                               model.first_triangle(r) + side.where(f).triangle);
      },
      ties.springs);
}

}  // namespace batten
