// SPDX-License-Identifier: MPL-2.0
// Formats continuity reports. Does not use OpenCASCADE, so that programs that load it as a plug-in
// can format reports without it.
#include <algorithm>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/io/cad/continuity_report.h"

namespace batten {
namespace {

double number_of(const EdgeContinuity& edge) {
  using Kind = EdgeContinuity::Kind;
  return edge.kind == Kind::Crease    ? edge.gap
         : edge.kind == Kind::Tangent ? edge.angle_deg
                                      : edge.relative_jump;
}

}  // namespace

int ContinuityReport::count(EdgeContinuity::Kind kind) const {
  return static_cast<int>(std::count_if(inner.begin(), inner.end(),
                                        [&](const auto& edge) { return edge.kind == kind; }));
}

const EdgeContinuity* ContinuityReport::worst(EdgeContinuity::Kind kind) const {
  const EdgeContinuity* found = nullptr;
  for (const auto& edge : inner)
    if (edge.kind == kind && (!found || number_of(edge) > number_of(*found))) found = &edge;
  return found;
}

double ContinuityReport::max_smooth_deg() const {
  double largest = 0;
  for (const auto& edge : inner)
    if (edge.kind != EdgeContinuity::Kind::Crease) largest = std::max(largest, edge.angle_deg);
  return largest;
}

std::string continuity_text(const ContinuityReport& r, const ContinuityOptions& options,
                            const std::string& unit) {
  using Kind = EdgeContinuity::Kind;
  const auto many = [](int count, const std::string& one) {
    return std::to_string(count) + " " + one + (count == 1 ? "" : "s");
  };
  const auto where = [&](const EdgeContinuity& edge) {
    return " (edge " + std::to_string(edge.edge) + ", faces " + std::to_string(edge.faces[0]) +
           " and " + std::to_string(edge.faces[1]) + ", near " + format_point(edge.at) + ")";
  };
  std::string text =
      "  " + many(r.edges, "edge") + ": " + many(r.free_edges, "free edge") + ", " +
      many(r.count(Kind::Crease), "crease") + ", " + std::to_string(r.count(Kind::Tangent)) +
      " tangent (G1), " + std::to_string(r.count(Kind::Curvature)) + " curvature-continuous (G2)" +
      (r.non_manifold_edges
           ? ", " + std::to_string(r.non_manifold_edges) + " with three faces or more"
           : "") +
      (r.unmeasured ? ", " + std::to_string(r.unmeasured) + " not measurable" : "") + "\n";
  const EdgeContinuity* gap = nullptr;
  for (const auto& edge : r.inner)
    if (!gap || edge.gap > gap->gap) gap = &edge;
  if (gap) text += "  largest gap " + format_number(gap->gap) + " " + unit + where(*gap) + "\n";
  if (const auto* edge = r.worst(Kind::Tangent))
    text += "  tangent edges meet within " + format_number(edge->angle_deg) +
            " degrees, G1 limit " + format_number(options.angle_deg) + where(*edge) + "\n";
  const EdgeContinuity* nearly = nullptr;  // crease that was probably meant to be smooth
  for (const auto& edge : r.inner)
    if (edge.kind == Kind::Crease && edge.angle_deg < 3 &&
        (!nearly || edge.angle_deg > nearly->angle_deg))
      nearly = &edge;
  if (nearly)
    text += "  nearly tangent: up to " + format_number(nearly->angle_deg) + " degrees" +
            where(*nearly) + "\n";
  const EdgeContinuity* jump = nullptr;
  for (const auto& edge : r.inner)
    if (edge.kind == Kind::Tangent && (!jump || edge.relative_jump > jump->relative_jump))
      jump = &edge;
  if (jump)
    text += "  largest curvature jump across a tangent edge " +
            format_number(jump->curvature_jump) + " / " + unit + where(*jump) + "\n";
  if (!r.slivers.empty())
    text += "  " + many(isize(r.slivers), "sliver") + ": face " + std::to_string(r.slivers[0]) +
            (r.slivers.size() > 1 ? " and others" : "") + "\n";
  return text;
}

}  // namespace batten
