// SPDX-License-Identifier: MPL-2.0
// The model of the mouse example, for tests and benchmarks.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "batten/fairing/curves/curve_through_points.h"
#include "batten/io/scene/scene.h"
#include "batten/skinning/search/find_regions.h"
#include "batten/skinning/surfaces/skin_network.h"
#include "batten/skinning/surfaces/surface_model.h"

namespace batten_test {
using namespace batten;

/// A network and the model that was built from it.
struct NetworkModel {
  CurveNetwork network;
  FoundRegions found;
  SurfaceModel model;
};

inline NetworkModel made(const std::vector<CharacterLine>& lines,
                         const NetworkOptions& network_options, const RegionSearchOptions& regions,
                         const ModelOptions& options) {
  CurveNetwork network(lines, network_options);
  FoundRegions found = find_regions(network, regions);
  SurfaceModel model = skin_network(network, found, options);
  return {std::move(network), std::move(found), std::move(model)};
}

/// The mouse of examples/09-mouse, with another edge length (mm).
inline NetworkModel mouse(double edge) {
  const Scene scene = read_scene(std::string(BATTEN_SOURCE_DIR) + "/examples/09-mouse/scene.toml");
  constexpr double corner = 60;
  std::vector<CharacterLine> lines;
  for (const SceneLine& line : scene.lines)
    lines.push_back({line.name, curve_through_points(line.name, line.points, corner)});
  NetworkOptions network;
  network.corner_angle = corner;
  RegionSearchOptions regions;
  regions.specs = scene.network.regions;
  ModelOptions options;
  options.name = "mouse";
  options.skin.edge_length = edge;
  options.joins = scene.network.joins;
  return made(lines, network, regions, options);
}

}  // namespace batten_test
