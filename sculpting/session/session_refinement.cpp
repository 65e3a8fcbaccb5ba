#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/errors.h"
#include "batten/core/largest_share.h"
#include "batten/fem/curvature_jumps.h"
#include "batten/sculpting/session/session_data.h"

namespace batten {

namespace {

// Triangles that a refinement halves.
std::vector<char> marks(const Refinement& refinement, const ModelLayout& layout,
                        const Surface& surface, const std::vector<double>& jumps) {
  const ParametricMesh& mesh = *layout.mesh();
  std::vector<char> marked(static_cast<size_t>(mesh.triangle_count()), 0);
  const auto longest = [&](int t) {
    double length = 0;
    const auto& v = mesh.triangles()[t];
    for (int i = 0; i < 3; ++i) {
      const Vec3 a = surface.dofs().row(surface.dof_map().vertex(v[i])),
                 b = surface.dofs().row(surface.dof_map().vertex(v[(i + 1) % 3]));
      length = std::max(length, (a - b).norm());
    }
    return length;
  };
  const double smallest = refinement.smallest;
  const auto mark = [&](int t) {
    if (longest(t) > 2 * smallest) marked[t] = 1;
  };
  if (const auto* brush = std::get_if<Refinement::Brush>(&refinement.where)) {
    if (brush->strokes.empty()) throw InputError("a refinement by brush without strokes");
    for (const auto& stroke : brush->strokes) {
      if (!stroke.at.allFinite() || !(stroke.radius > 0) || !std::isfinite(stroke.radius))
        throw InputError("a refinement stroke needs a place and a radius above 0");
      for (int t = 0; t < mesh.triangle_count(); ++t) {
        double nearest = std::numeric_limits<double>::infinity();
        for (const Vec3& L : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1), Vec3(.5, .5, 0),
                              Vec3(0, .5, .5), Vec3(.5, 0, .5), Vec3(1. / 3, 1. / 3, 1. / 3)})
          nearest = std::min(nearest, (surface.position({t, L}) - stroke.at).norm());
        if (nearest < stroke.radius) mark(t);
      }
    }
    return marked;
  }
  const double share = std::get<Refinement::Jumps>(refinement.where).share;
  if (!(share > 0 && share <= 1))
    throw InputError("a refinement of the share " + number(share) +
                     " of the jumps: expected above 0, at most 1");
  for (const int t : largest_share(jumps, share)) mark(t);
  return marked;
}

}  // namespace

RefinementReport SculptingSession::Data::refine(const Refinement& refinement) {
  RefinementReport report;
  report.triangles_before = layout().mesh()->triangle_count();
  Refinement wanted = refinement;
  if (!(wanted.smallest >= 0) || !std::isfinite(wanted.smallest))
    throw InputError("a smallest edge of " + number(wanted.smallest) + ": expected 0 or more");
  if (wanted.smallest == 0) wanted.smallest = size() / 2000;
  const Surface surface = this->surface();
  std::vector<double> jumps;
  if (std::holds_alternative<Refinement::Jumps>(wanted.where)) {
    // In the units of the whole model: a region's own count (S/s_r)².
    for (int r = 0; r < layout().region_count(); ++r) {
      const VecX own = curvature_jumps(made(r).surface);
      const double scale = layout().domain_scale().size() > 0
                               ? layout().domain_scale()[layout().first_triangle(r)]
                               : 1;
      for (long t = 0; t < own.size(); ++t) jumps.push_back(own[t] / scale);
    }
  }
  const std::vector<char> marked = marks(wanted, layout(), surface, jumps);
  read_values();
  report.energy_before = report.energy_carried = report.energy_settled =
      elastic_energy(now.shape.x);
  report.triangles = report.triangles_before;
  ModelLayout layout = this->layout();
  if (!layout.refine(marked)) return report;
  if (layout.mesh()->triangle_count() > wanted.most_triangles)
    throw InputError("the refinement would make " +
                     std::to_string(layout.mesh()->triangle_count()) + " triangles, more than " +
                     std::to_string(wanted.most_triangles));
  report.triangles = layout.mesh()->triangle_count();
  const CarriedOver carried = move_to(std::move(layout));
  report.max_displacement = carried.max_displacement / size();
  report.energy_settled = elastic_energy(now.shape.x);
  report.energy_carried =
      elastic_energy(carried.dofs - system().parts->ones * system().origin().transpose());
  return report;
}

}  // namespace batten
