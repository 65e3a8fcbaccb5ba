#include <algorithm>

#include "batten/core/errors.h"
#include "batten/sculpting/session/session_data.h"

namespace batten {

namespace {

bool same_rows(const ConstraintSet& a, const ConstraintSet& b) {
  const auto same = [](const auto& p, const auto& q) {
    return p.value == q.value && std::equal(p.entries.begin(), p.entries.end(), q.entries.begin(),
                                            q.entries.end(), [](const auto& x, const auto& y) {
                                              return x.dof == y.dof &&
                                                     x.coefficient == y.coefficient;
                                            });
  };
  return std::equal(a.constraints().begin(), a.constraints().end(), b.constraints().begin(),
                    b.constraints().end(), same) &&
         std::equal(a.coupled_constraints().begin(), a.coupled_constraints().end(),
                    b.coupled_constraints().begin(), b.coupled_constraints().end(), same);
}

}  // namespace

// The shape under the rows that bends least from a rest shape, while no load acts. Absolute.
Points SessionData::deformed_from(
    std::shared_ptr<const detail::RestConfiguration> rest) {
  std::vector<double> unloaded = values;
  for (const int p : system().load_parameter) unloaded[p] = 0;
  engine.set_rest_shape(system(), std::move(rest));
  engine.prepare_matrix(system(), unloaded);
  Points x = now.shape.x;
  engine.solve_preview(system(), unloaded, x, options.max_iterations, options.tolerance, false);
  return absolute(x);
}

// Makes the rest shape: where there is none yet, and `anew` also where rows have changed.
void SessionData::update_rest_shape(bool anew) {
  const auto last = system().rest;
  if (!options.rest || (last && !anew)) return;
  ConstraintSet rows = engine.all_rows(system(), values);
  if (last && same_rows(last->rows, rows)) return;
  const VecX& ones = system().parts->ones;
  const Vec3 origin = system().origin();
  const Points bent = deformed_from(nullptr);
  Points near(0, 3);
  if (last && last->first.rows() > 0)
    near = deformed_from(std::make_shared<const detail::RestConfiguration>(
        detail::RestConfiguration{last->first, {}, ConstraintSet(0)}));
  const ConstraintSet absolute_rows = rows.translated(ones, -origin);
  Points dofs = options.rest({layout(), absolute_rows, bent, near, progress});
  if (dofs.rows() > 0) {
    if (dofs.rows() != system().dofs() || !dofs.allFinite())
      throw InputError("a rest shape of " + std::to_string(dofs.rows()) +
                       " dofs, or one that is not finite: expected " +
                       std::to_string(system().dofs()));
    dofs -= ones * origin.transpose();
  }
  Points first = last && last->first.rows() > 0 ? last->first : dofs;
  engine.set_rest_shape(
      system(), std::make_shared<const detail::RestConfiguration>(
                    detail::RestConfiguration{std::move(dofs), std::move(first), std::move(rows)}));
}

}  // namespace batten
