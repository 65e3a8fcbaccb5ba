// SPDX-License-Identifier: MPL-2.0
#include "batten/benchmarks/step_cross_check.h"

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "batten/fem/surface_projector.h"

namespace batten::bench {
namespace {

namespace fs = std::filesystem;

/// The pcurve of a curve on the boundary of the face; null if it is not part of it.
std::optional<HermiteCurve> boundary_line(const SkinnedRegion& region, const std::string& name) {
  for (const auto& loop : region.boundary)
    for (const BoundarySegment& piece : loop) {
      const auto i = static_cast<size_t>(piece.index);
      const bool aligned_line = piece.kind == BoundarySegment::Kind::EdgeAligned;
      if ((aligned_line ? region.edge_aligned.at(i).line.name : region.embedded.at(i).line.name) ==
          name)
        return boundary_curve(region, piece);
    }
  return std::nullopt;
}

void write_position(std::ofstream& out, const std::string& name, const Vec3& p) {
  out << '"' << name << "\"," << p.x() << ',' << p.y() << ',' << p.z();
}

double degrees_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b))) * 180 / std::numbers::pi;
}

}  // namespace

std::vector<std::vector<Vec3>> points_of(const std::vector<const SkinnedRegion*>& regions,
                                         int count) {
  int triangles = 0;
  for (const SkinnedRegion* region : regions) triangles += region->surface.mesh().triangle_count();
  const int n = std::max(2, static_cast<int>(std::ceil(std::sqrt(2.0 * count / triangles))));
  std::vector<std::vector<Vec3>> points;
  for (const SkinnedRegion* region : regions) {
    const Surface& s = region->surface;
    points.emplace_back();
    for (int t = 0; t < s.mesh().triangle_count(); ++t)
      for (int i = 0; i < n; ++i)
        for (int j = 0; i + j < n; ++j) {
          const double a = (i + 0.31) / n, b = (j + 0.28) / n;
          const Vec3 L(a, b, 1 - a - b);
          if (s.trim() && !s.trim()->loops().contains(s.mesh().shape(t).point(L))) continue;
          points.back().push_back(s.position({t, L}));
        }
  }
  return points;
}

StepCrossCheck::StepCrossCheck(const std::vector<const SkinnedRegion*>& regions,
                               const std::vector<StepJoin>& joins, int count,
                               const fs::path& folder)
    : points_(folder / "points.csv"),
      joins_(folder / "joins.csv"),
      results_file_(folder / "step.json") {
  std::ofstream of_points(points_), of_joins(joins_);
  of_points.precision(17);
  of_joins.precision(17);
  const auto points = points_of(regions, count);
  std::map<std::string, const SkinnedRegion*> by_name;
  for (size_t r = 0; r < regions.size(); ++r) {
    by_name[regions[r]->name] = regions[r];
    for (const Vec3& p : points[r]) {
      write_position(of_points, regions[r]->name, p);
      of_points << '\n';
    }
  }
  for (const StepJoin& join : joins) {
    const SkinnedRegion* one = by_name.at(join.regions[0]);
    const auto curve = boundary_line(*one, join.line);
    if (!curve || join.regions[1].empty()) continue;
    const SkinnedRegion* other = by_name.at(join.regions[1]);
    const SurfaceProjector onto_one(one->surface), onto_other(other->surface);
    constexpr int pieces = 400;
    for (int k = 0; k <= pieces; ++k) {
      const double t = curve->start() + (curve->end() - curve->start()) * k / pieces;
      const Vec3 p =
          k < pieces ? curve->evaluate(t) : curve->evaluate({curve->segment_count() - 1, 1.0});
      const Vec3 a = one->surface.jet(onto_one.nearest(p).where).normal(),
                 b = other->surface.jet(onto_other.nearest(p).where).normal();
      write_position(of_joins, join.line, p);
      of_joins << ',' << degrees_between(a, b) << '\n';
    }
  }
}

std::optional<StepCrossCheck::Result> StepCrossCheck::seen(const fs::path& file) const {
  const std::string command = "/usr/bin/python3 " BATTEN_BENCH_CROSS_CHECK_PY " '" + file.string() +
                              "' '" + points_.string() + "' '" + joins_.string() + "' > '" +
                              results_file_.string() + "'";
  if (std::system(command.c_str()) != 0) return std::nullopt;
  std::ifstream in(results_file_);
  const auto json = nlohmann::json::parse(in, nullptr, false);
  if (json.is_discarded()) return std::nullopt;
  Result seen;
  seen.faces = json.at("faces");
  seen.points = json.at("points");
  seen.distance = json.at("distance");
  seen.joins = json.at("joins");
  seen.positions = json.at("places");
  seen.above = json.at("above");
  seen.degrees = json.at("degrees");
  seen.beyond = json.at("beyond");
  return seen;
}

}  // namespace batten::bench
