// SPDX-License-Identifier: MPL-2.0
#include "expected.h"

#if BATTEN_BENCH_EXPECTED

#include <unistd.h>

#include <fstream>
#include <set>

#include "batten/tests/support/skin_command.h"
#include "occ_filling.h"
#include "occ_loft.h"

namespace batten::bench {
namespace {

using batten_test::ExpectedShape;
using batten_test::SkinnedCurves;

/// Result of a peer for one shape.
struct Peer {
  bool applies = false, done = false;
  double max = 0, seconds = 0;  // distance as a fraction of the size

  void measure(const std::vector<Vec3>& points, const ExpectedShape& shape) {
    for (const Vec3& p : points) max = std::max(max, shape.distance(p) / shape.size());
  }
  std::vector<std::string> columns() const {
    if (!applies) return {"", ""};
    return {done ? text("%.1e", max) : "fails", text("%.2f", seconds)};
  }
};

/// The boundary loops of a face, and the other curves on it.
struct FaceCurves {
  std::vector<std::vector<HermiteCurve>> loops;
  std::vector<HermiteCurve> inner;
};
FaceCurves curves_of(const SkinnedRegion& region) {
  FaceCurves curves;
  std::set<std::pair<BoundarySegment::Kind, int>> bounding;
  for (const auto& loop : region.boundary) {
    curves.loops.emplace_back();
    for (const BoundarySegment& piece : loop) {
      curves.loops.back().push_back(boundary_curve(region, piece));
      bounding.emplace(piece.kind, piece.index);
    }
  }
  for (int i = 0; i < static_cast<int>(region.edge_aligned.size()); ++i)
    if (!bounding.contains({BoundarySegment::Kind::EdgeAligned, i}))
      curves.inner.push_back(region.edge_aligned[static_cast<size_t>(i)].fitted);
  for (int i = 0; i < static_cast<int>(region.embedded.size()); ++i)
    if (!bounding.contains({BoundarySegment::Kind::Embedded, i}))
      curves.inner.push_back(region.embedded[static_cast<size_t>(i)].fitted);
  return curves;
}

/// One filling per face. It fails if one of them fails.
Peer filled(const SkinnedCurves& result, const ExpectedShape& shape) {
  Peer peer;
  if (occ_version().empty() || !result.made) return peer;
  peer.applies = peer.done = true;
  for (const ModelRegion& region : result.made->model.regions) {
    if (!region.skinned) continue;
    const FaceCurves curves = curves_of(*region.skinned);
    std::unique_ptr<OccFilling> filling;
    peer.seconds += cpu_seconds_of([&] {
      filling = std::make_unique<OccFilling>(
          curves.loops, curves.inner, OccFillingSettings{"", 1e-4 * shape.size() / 3, 15, 9});
    });
    const auto points = filling->done() ? filling->points(30) : std::vector<Vec3>{};
    if (points.empty())
      std::printf("%s: filling of face '%s' fails: %s\n", shape.name.c_str(),
                  region.skinned->name.c_str(), filling->error_message().c_str());
    peer.done = peer.done && !points.empty();
    peer.measure(points, shape);
  }
  return peer;
}

/// The best of the lofts that would produce the surface.
Peer lofted(const ExpectedShape& shape) {
  Peer best;
  if (occ_version().empty()) return best;
  for (const auto& loft : shape.lofts) {
    Peer peer{true, true};
    for (const auto& names : loft) {
      std::vector<std::vector<Vec3>> sections;
      for (const std::string& name : names) sections.push_back(shape.curve(name).points);
      std::vector<Vec3> points;
      peer.seconds += cpu_seconds_of([&] { points = loft_points(sections, 30); });
      peer.done = peer.done && !points.empty();
      peer.measure(points, shape);
    }
    if (!best.applies || (peer.done && (!best.done || peer.max < best.max))) best = peer;
  }
  return best;
}

}  // namespace

void compare_expected(Checks& checks) {
  std::printf(
      "batten skin curves.csv without options: largest distance from the expected surface over the "
      "size.\n\n");
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("batten_expected_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  Table table;
  table.add({"expected shape", "tolerance", "Batten", "area", "volume", "exit", "s", "correct",
             "OpenCASCADE filling", "s", "loft", "s"});
  int correct = 0, silent = 0, filling_within = 0, loft_within = 0;
  for (const ExpectedShape& shape : batten_test::expected_shapes()) {
    std::ofstream(folder / "curves.csv") << shape.csv();
    SkinnedCurves result;
    double seconds = 0;
    // Once without the STEP file, for the time of the shape alone; once with all checks.
    seconds = cpu_seconds_of(
        [&] { batten_test::skin_curves(folder / "curves.csv", folder / "out", false); });
    result = batten_test::skin_curves(folder / "curves.csv", folder / "out", true);
    const auto deviation = batten_test::deviation_of(result, shape);
    const bool ok = deviation.correct && result.exit_code == 0;
    correct += ok;
    silent += !ok && !result.warns();
    const Peer filling = filled(result, shape), loft = lofted(shape);
    const auto within = [&](const Peer& peer) {
      return peer.applies && peer.done && peer.max <= shape.tolerance + 2e-4;
    };
    filling_within += within(filling);
    loft_within += within(loft);
    std::vector<std::string> row = {shape.name,
                                    format_number(shape.tolerance),
                                    result.facets ? text("%.1e", deviation.max) : "none",
                                    shape.area ? text("%.4f", deviation.area) : "",
                                    shape.volume ? text("%.4f", deviation.volume) : "",
                                    std::to_string(result.exit_code),
                                    text("%.2f", seconds),
                                    ok ? "yes" : "NO"};
    for (const Peer& peer : {filling, loft})
      for (const std::string& column : peer.columns()) row.push_back(column);
    table.add(std::move(row));
    if (!ok) std::printf("%s: %s\n", shape.name.c_str(), result.message.c_str());
    std::fflush(stdout);
  }
  std::filesystem::remove_all(folder);
  table.print();
  std::printf("Within the tolerance: fillings %d, lofts %d.\n\n", filling_within, loft_within);
  checks.at_least("correct expected shapes", correct, 35);
  checks.at_most("wrong expected shapes without a message", silent, 0);
}

}  // namespace batten::bench

#else

namespace batten::bench {

void compare_expected(Checks& checks) {
  std::printf("Built without the commands: no table of expected shapes.\n\n");
  checks.at_least("correct expected shapes", {}, 35);
}

}  // namespace batten::bench

#endif
