// SPDX-License-Identifier: MPL-2.0
// Sessions with faces that continue given surfaces.
#include <cmath>

#include "batten/sculpting/session/sculpting_session.h"
#include "batten/skinning/surfaces/build_model.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/given_surfaces.h"

using namespace batten;
using namespace batten_test;

TEST_CASE("the given tangent planes hold while a patch is sculpted", "[sculpting][session]") {
  for (const int sides : {1, 4}) {
    CAPTURE(sides);
    const Hole hole = hole_in(given_sphere(), sides);
    ModelBuildOptions build;
    build.model.neighbours = hole.neighbours;
    build.model.neighbour_tolerance = 1e-3;
    const BuiltModel built = build_model(hole.lines, build);
    SculptingSession session(*built.model.layout, {});
    const auto height = [&] {
      const std::vector<SkinnedRegion> regions = session.regions();
      const Surface& surface = regions[0].surface;
      double sum = 0;
      for (int t = 0; t < surface.mesh().triangle_count(); ++t)
        sum += surface.position({t, Vec3::Constant(1.0 / 3)}).norm();
      return sum / surface.mesh().triangle_count();
    };
    session.solve_to_equilibrium();
    const double before = height();
    for (const JoinPlan& plan : session.layout().join_plans()) {
      const std::vector<SkinnedRegion> now = session.regions();
      CHECK(measure_join({&now[0]}, plan.join_line).max_deg < 0.1);
    }
    session.add(Load{"push", Load::Pressure{}}, {{.name = "push", .value = 40}});
    session.solve_to_equilibrium();
    CAPTURE(before, height());
    CHECK(std::abs(height() - before) > 1e-3);
    const std::vector<SkinnedRegion> made = session.regions();
    CHECK(session.layout().join_plans().size() == static_cast<size_t>(sides));
    for (const JoinPlan& plan : session.layout().join_plans()) {
      CHECK_FALSE(plan.rejected());
      CHECK(measure_join({&made[0]}, plan.join_line).max_deg < 0.3);
    }
    CHECK(session.residual() < 1e-10);
  }
}
