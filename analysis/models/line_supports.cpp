#include "batten/analysis/models/line_supports.h"

#include "batten/analysis/models/line_rotation.h"
#include "batten/analysis/models/line_sides.h"
#include "batten/core/errors.h"

namespace batten {
namespace {

// One line of the model on its first side.
class SupportedLine {
 public:
  SupportedLine(const JoinEdge& side, const Points& shape, const LineSupport& support,
                ConstraintSet& set)
      : side_(side), rotation_(side, shape), support_(support), set_(set) {}

  void hold(const Vec3& direction) {
    const double value = direction.dot(support_.displacement);
    const auto add = [&](const RowEntries& entries, double right) {
      CoupledEntries row;
      for (const auto& e : entries) row.push_back({e.dof, e.coefficient * direction});
      add_summed(support_.name, row, right, set_);
    };
    if (!side_.embedded()) {
      for (int k = 0; k < side_.count(); ++k) {
        RowEntries place, slope;
        side_.add_position(k, 1, place);
        side_.add_along(k, 1, slope);
        add(place, value);
        add(slope, 0);
      }
      return;
    }
    LineSides::over_hats(side_, side_, [&](const std::vector<HatPoint>& hat, double weight) {
      RowEntries row;
      for (const HatPoint& p : hat) side_.add_at(p.f, 0, 0, p.weight / weight, row);
      add(row, value);
    });
  }

  void hold_rotation() {
    if (!side_.embedded()) {
      for (int k = 0; k < side_.count(); ++k)
        add([&](CoupledEntries& row) { rotation_.at_vertex(k, 1, row); });
      for (int k = 0; k + 1 < side_.count(); ++k)
        add([&](CoupledEntries& row) { rotation_.in_middle(k, 1, row); });
      return;
    }
    LineSides::over_hats(side_, side_, [&](const std::vector<HatPoint>& hat, double weight) {
      add([&](CoupledEntries& row) {
        for (const HatPoint& p : hat) rotation_.at_fraction(p.f, p.weight / weight, row);
      });
    });
  }

 private:
  template <class Fill>
  void add(const Fill& fill) {
    CoupledEntries row;
    fill(row);
    add_summed(support_.name, row, 0, set_);
  }

  const JoinEdge& side_;
  LineRotation rotation_;
  const LineSupport& support_;
  ConstraintSet& set_;
};

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

void add_support(const ModelLayout& model, const Points& shape, const LineSupport& support,
                 ConstraintSet& set) {
  const std::string who = "support '" + support.name + "' ";
  if (support.directions.empty() && !support.rotation)
    throw InputError(who + "holds nothing: expected directions or the rotation");
  LineSides sides(model);
  const JoinEdge side = sides(model.model_line(support.line));
  SupportedLine held(side, shape, support, set);
  for (const Vec3& direction : support.directions) {
    if (!direction.allFinite() || direction.isZero(0))
      throw InputError(who + "has a direction of length zero");
    held.hold(direction.normalized());
  }
  if (support.rotation) held.hold_rotation();
}

}  // namespace batten
