#include "batten/apps/commands/make_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "batten/apps/commands/line_files.h"
#include "batten/apps/commands/make_session.h"
#include "batten/constraints/shape/shape_constraints.h"
#include "batten/fem/triangle_locator.h"

namespace batten {
namespace {

/// A mesh vertex of the surface nearest to a point in space.
int nearest_vertex(const Surface& surface, const Vec3& at) {
  int nearest = 0;
  double distance = std::numeric_limits<double>::infinity();
  for (int v = 0; v < surface.mesh().vertex_count(); ++v) {
    if (surface.trim() && !surface.trim()->loops().contains(surface.mesh().vertices()[v])) continue;
    const Vec3 x = surface.dofs().row(surface.dof_map().vertex(v));
    if ((x - at).norm() < distance) {
      distance = (x - at).norm();
      nearest = v;
    }
  }
  return nearest;
}

struct HeldNormal {
  int vertex;
  Vec3 normal;
};

std::vector<HeldNormal> add_constraints(const Scene& scene, const Surface& unloaded,
                                        ConstraintSet& set) {
  using Type = SceneConstraint::Type;
  ShapeConstraints shape(unloaded.mesh(), unloaded.kind(), set);
  std::vector<HeldNormal> normals;
  const std::vector<std::string> taken = set.names();
  for (const SceneConstraint& c : scene.constraints) {
    if (std::find(taken.begin(), taken.end(), c.name) != taken.end())
      throw InputError(scene.at(c.place) + "found the constraint name '" + c.name +
                       "', expected another one: a line or corner has it");
    if (c.type == Type::Point) {
      shape.point(c.name, unloaded.closest_point(c.at).where, c.goal);
      continue;
    }
    const int vertex = nearest_vertex(unloaded, c.at);
    if (c.type == Type::Normal) {
      shape.normal(c.name, vertex, c.goal);
      normals.push_back({vertex, c.goal.normalized()});
    } else {
      shape.tangent(c.name, vertex, c.along, c.goal);
    }
  }
  return normals;
}

/// Degrees between the surface's normal at the vertex and the held one, either sign.
double deviation(const Surface& surface, const HeldNormal& held) {
  const DofMap& dofs = surface.dof_map();
  const Vec3 x_u = surface.dofs().row(dofs.vertex(held.vertex, 1));
  const Vec3 x_v = surface.dofs().row(dofs.vertex(held.vertex, 2));
  const Vec3 normal = x_u.cross(x_v).normalized();
  return std::atan2(normal.cross(held.normal).norm(), std::abs(normal.dot(held.normal))) * 180 /
         std::numbers::pi;
}

}  // namespace

RegionLayout lay_out(const Scene& scene, const std::vector<CharacterLine>& lines,
                     const Progress& progress) {
  try {
    return RegionLayout(scene.name, lines, scene.skin.options, progress);
  } catch (const InputError& e) {
    throw InputError(scene.at({}) + e.what());
  }
}

MadeShape make_shape(const RegionLayout& layout, const Scene& scene, const Progress& progress) {
  if (scene.needs_session()) {
    std::optional<Surface> unloaded_surface;
    SculptingSession session = make_session(layout, scene, progress, &unloaded_surface);
    const Answer answer = session.settle();
    return shape_of(session, scene, *unloaded_surface, answer);
  }
  const bool corners = scene.skin.hold == SceneSkin::Hold::Corners;
  ConstraintSet set = corners ? layout.corner_constraints() : layout.line_constraints();
  SculptOptions options;
  options.material = scene.skin.material;
  options.units = scene.skin.units;

  SculptResult plain = sculpt(layout, set, {}, options, progress);
  const Surface unloaded = layout.region(plain.dofs).surface;
  if (scene.loads.empty() && scene.constraints.empty())
    return {layout.region(plain.dofs), unloaded, std::move(plain), 0};

  const std::vector<HeldNormal> normals = add_constraints(scene, unloaded, set);
  std::vector<Load> loads;
  for (const SceneLoad& load : scene.loads) loads.push_back(load.load(spring_points(scene, load)));
  MadeShape made{layout.region(plain.dofs), unloaded,
                 sculpt(layout, set, loads, options, progress)};
  made.region = layout.region(made.sculpt.dofs);
  for (const HeldNormal& held : normals) {
    const double degrees = deviation(made.region.surface, held);
    if (!(degrees <= made.max_normal_constraint_deg)) made.max_normal_constraint_deg = degrees;
  }
  return made;
}

bool halve_at_gaps(RegionLayout& layout, const SkinnedRegion& region, double target) {
  const Surface& surface = region.surface;
  const TriangleLocator locator(surface.mesh());
  std::vector<char> marked(static_cast<size_t>(surface.mesh().triangle_count()), 0);
  constexpr int samples = 20;
  for (const EmbeddedLine& line : region.embedded) {
    // The ends too: points may have been left out there, and a closed line comes around.
    std::vector<double> ends = line.points;
    ends.insert(ends.begin(), line.image.start());
    ends.push_back(line.image.end());
    for (size_t i = 0; i + 1 < ends.size(); ++i) {
      const double from = ends[i], to = ends[i + 1];
      std::vector<int> triangles;
      double gap = 0;
      for (int k = 0; k <= samples; ++k) {
        const double t = from + (to - from) * k / samples;
        const Vec3 uv = line.image.evaluate(t);
        const Location where = locator.locate({uv.x(), uv.y()});
        gap = std::max(gap, (surface.position(where) - line.fitted.evaluate(t)).norm());
        triangles.push_back(where.triangle);
      }
      if (gap <= target) continue;
      for (const int t : triangles) marked[static_cast<size_t>(t)] = 1;
    }
  }
  return layout.refine(marked);
}

MadeShape make_refined_shape(RegionLayout& layout, const Scene& scene, const Progress& progress) {
  constexpr int most_rounds = 8;
  const bool held = scene.skin.hold == SceneSkin::Hold::Lines;
  for (int round = 0;; ++round) {
    MadeShape made = make_shape(layout, scene, progress);
    if (!held || round == most_rounds) return made;
    double gap = 0;
    for (const EmbeddedLine& line : layout.embedded())
      gap = std::max(gap, line_gap(made.region.surface, line));
    if (gap <= kMostGap * layout.tolerance()) return made;
    const double target = 0.5 * layout.tolerance();
    if (!(scene.needs_session() ? halve_at_gaps(layout, made.region, target)
                                : layout.refine(made.region.surface, target)))
      return made;
  }
}

}  // namespace batten
