#include "batten/analysis/models/line_supports.h"

#include "batten/analysis/models/line_rotation.h"
#include "batten/analysis/models/line_sides.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

void hold_run(const JoinEdge& side, const Points& shape, const LineSupport& support,
              const std::vector<Vec3>& directions, ConstraintSet& set) {
  for (const Vec3& direction : directions)
    for (int k = 0; k < side.count(); ++k) {
      RowEntries place, slope;
      side.add_position(k, 1, place);
      side.add_along(k, 1, slope);
      add_summed(support.name, along(direction, place), direction.dot(support.displacement), set);
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
    rotation.in_middle(k, 1, row);
    add_summed(support.name, row, 0, set);
  }
}

template <class Stiffness>
void hold_embedded(const JoinEdge& side, const Points& shape, const LineSupport& support,
                   const std::vector<Vec3>& directions, const Stiffness& stiffness,
                   LineSprings& springs) {
  const LineRotation rotation(side, shape);
  over_line(side, side, [&](double f, double dl) {
    const SpringStiffness k = stiffness(f);
    RowEntries place;
    side.add_at(f, 0, 0, 1, place);
    for (const Vec3& direction : directions)
      springs.add(support.name, along(direction, place), k.displacement * dl,
                  direction.dot(support.displacement));
    if (!support.rotation) return;
    CoupledEntries row;
    rotation.at_fraction(f, 1, row);
    springs.add(support.name, row, k.rotation * dl, 0);
  });
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
  const std::string who = "support '" + support.name + "' ";
  if (support.directions.empty() && !support.rotation)
    throw InputError(who + "holds nothing: expected directions or the rotation");
  std::vector<Vec3> directions;
  for (const Vec3& direction : support.directions) {
    if (!direction.allFinite() || direction.isZero(0))
      throw InputError(who + "has a direction of length zero");
    directions.push_back(direction.normalized());
  }
  LineSides sides(model);
  const ModelLine& line = model.model_line(support.line);
  const JoinEdge side = sides(line);
  if (!side.embedded()) {
    hold_run(side, shape, support, directions, ties.rows);
    return;
  }
  const int r = line.sides[0].region;
  const Surface surface = model.surface(shape);
  hold_embedded(
      side, shape, support, directions,
      [&](double f) {
        return SpringStiffness(side, surface, sections[sections.size() == 1 ? 0 : r],
                               model.first_triangle(r), f);
      },
      ties.springs);
}

}  // namespace batten
