#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/dorfler_marking.h"
#include "batten/core/errors.h"
#include "batten/fem/residual_indicator.h"
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
  const double fraction = std::get<Refinement::JumpIndicator>(refinement.where).fraction;
  if (!(fraction > 0 && fraction <= 1))
    throw InputError("a refinement of the share " + format_number(fraction) +
                     " of the jumps: expected above 0, at most 1");
  for (const int t : dorfler_marking(jumps, fraction)) mark(t);
  return marked;
}

}  // namespace

RefinementReport SessionData::refine(const Refinement& refinement) {
  RefinementReport report;
  report.triangles_before = layout().mesh()->triangle_count();
  Refinement wanted = refinement;
  if (!(wanted.smallest >= 0) || !std::isfinite(wanted.smallest))
    throw InputError("a smallest edge of " + format_number(wanted.smallest) +
                     ": expected 0 or more");
  if (wanted.smallest == 0) wanted.smallest = size() / 2000;
  const Surface surface = this->surface();
  std::vector<double> jumps;
  if (std::holds_alternative<Refinement::JumpIndicator>(wanted.where)) {
    // In the units of the whole model: a region's own count (S/s_r)².
    for (int r = 0; r < layout().region_count(); ++r) {
      const VecX own = residual_indicator(skinned_region(r).surface);
      const double scale = layout().domain_scale().size() > 0
                               ? layout().domain_scale()[layout().first_triangle(r)]
                               : 1;
      for (long t = 0; t < own.size(); ++t) jumps.push_back(own[t] / scale);
    }
  }
  const std::vector<char> marked = marks(wanted, layout(), surface, jumps);
  read_values();
  report.energy_before = report.energy_transferred = report.energy_at_equilibrium =
      elastic_energy(now.shape.x);
  report.triangles = report.triangles_before;
  ModelLayout layout = this->layout();
  if (!layout.refine(marked)) return report;
  if (layout.mesh()->triangle_count() > wanted.max_triangles)
    throw InputError("the refinement would make " +
                     std::to_string(layout.mesh()->triangle_count()) + " triangles, more than " +
                     std::to_string(wanted.max_triangles));
  report.triangles = layout.mesh()->triangle_count();
  const SurfaceTransfer transferred = change_layout(std::move(layout));
  report.max_displacement = transferred.max_displacement / size();
  report.energy_at_equilibrium = elastic_energy(now.shape.x);
  report.energy_transferred =
      elastic_energy(transferred.dofs - system().parts->ones * system().origin().transpose());
  return report;
}

}  // namespace batten
