// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/lines/scene_neighbours.h"

#include <algorithm>
#include <numbers>
#include <set>
#include <string>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/io/files/command_files.h"
#include "batten/io/files/text.h"
#include "batten/io/lines/cad_plugin.h"
#include "batten/scenes/lines/mesh_neighbours.h"

namespace batten {
namespace {

bool has_bridge(const Scene& scene) {
  return std::any_of(scene.neighbours.begin(), scene.neighbours.end(),
                     [](const SceneNeighbour& given) { return given.bridge; });
}

NeighbourCurve mirrored(NeighbourCurve curve, int axis) {
  for (NeighbourSample& sample : curve.samples)
    for (Vec3* v : {&sample.point, &sample.into, &sample.curvature}) (*v)[axis] *= -1;
  return curve;
}

std::string some(std::vector<std::string> names) {
  constexpr size_t most = 8;
  const bool more = names.size() > most;
  if (more) names.resize(most);
  return comma_separated(names) + (more ? ", …" : "");
}

std::string describe(const std::vector<NeighbourOpening>& openings, const std::string& unit) {
  std::string text;
  constexpr size_t most = 12;
  for (size_t k = 0; k < openings.size() && k < most; ++k) {
    const NeighbourOpening& opening = openings[k];
    text += "\n  opening " + std::to_string(k + 1) + ": " +
            format_count(isize(opening.lines), "edge") + " (" + some(opening.lines) + "), length " +
            format_number(opening.length) + " " + unit + ", around " +
            format_point(opening.centre) + ", beside " + comma_separated(opening.faces) +
            (opening.outer_boundary ? ", an outer boundary" : "");
  }
  if (openings.size() > most) text += "\n  …";
  return text;
}

/// Reads the faces of one [[neighbour]].
class NeighbourReader {
 public:
  NeighbourReader(const Scene& scene, const SceneNeighbour& given, SceneNeighbours& result)
      : scene_(scene), given_(given), result_(result), connects_(has_bridge(scene)) {
    record_input(given.file);
    try {
      if (MeshFile::can_read(given.file))
        found_ = mesh_neighbour_faces(read_mesh_neighbour(given.file, given.faces, given.without));
      else
        found_ = cad_plugin().read_cad_neighbours(given.file, unit_in_metres(scene.unit),
                                                  {given.faces, given.without});
    } catch (const InputError& e) {
      throw InputError(scene.at(given.location) + e.what());
    }
    if (found_.neighbours.empty())
      fail(
          "found no free edge, expected an opening between its faces; 'faces' (--face) selects the "
          "faces beside one, 'without' (--replace) leaves out those that are to be replaced");
  }

  void read() {
    for (NeighbourCurve curve : found_.neighbours) {
      curve.name += " of " + given_.file.filename().string();
      // Those who connect faces want a face that continues them.
      curve.continuity = given_.continuity == NeighbourContinuity::Automatic && connects_
                             ? NeighbourContinuity::Tangent
                             : given_.continuity;
      if (scene_.network.symmetry)
        result_.neighbours.push_back(mirrored(curve, *scene_.network.symmetry));
      result_.neighbours.push_back(std::move(curve));
    }
    const bool selected = !given_.openings.empty() || !given_.edges.empty();
    if (!given_.fill.value_or(selected || !has_outlines(scene_))) return;
    result_.accuracy = std::max(result_.accuracy, found_.accuracy);
    if (!given_.edges.empty() && has_blend(scene_)) {
      for (const std::string& name : given_.edges) {
        BlendEdge edge = blend_edge(found_, index_of(name));
        edge.name = add_line(name);
        result_.blend.push_back(std::move(edge));
      }
      return;
    }
    const std::vector<int> which = openings();
    result_.openings += describe(found_.openings, scene_.unit);
    for (const int k : which) fill(found_.openings[static_cast<size_t>(k)], isize(which));
  }

 private:
  [[noreturn]] void fail(const std::string& text) const {
    throw InputError(scene_.at(given_.location) + given_.file.string() + ": " + text);
  }

  // Indices of the openings to fill.
  std::vector<int> openings() const {
    const std::vector<NeighbourOpening>& all = found_.openings;
    std::vector<int> which;
    for (const int number : given_.openings) {
      if (number > isize(all))
        fail("found no opening " + std::to_string(number) + ", expected 1 to " +
             std::to_string(all.size()) + ":" + describe(all, scene_.unit));
      which.push_back(number - 1);
    }
    for (const std::string& name : given_.edges) which.push_back(opening_with(name));
    if (!which.empty()) return sorted_unique(std::move(which));
    for (int k = 0; k < isize(all); ++k)
      if (!all[k].outer_boundary) which.push_back(k);
    if (which.empty())
      fail(all.empty() ? "found " + format_count(isize(found_.open_lines), "free edge") +
                             " that form no closed loop, expected an opening"
                       : "found no opening but the outer boundary of its faces; 'openings' "
                         "(--opening) or 'edges' (--edge) selects others:" +
                             describe(all, scene_.unit));
    return which;
  }

  // Index of a free edge.
  int index_of(const std::string& name) const {
    std::vector<std::string> known;
    for (const CharacterLine& line : found_.lines) {
      if (line.name == name) return isize(known);
      known.push_back(line.name);
    }
    fail("found no free edge '" + name + "', expected one of: " + some(known));
  }

  // Index of the opening that contains a free edge.
  int opening_with(const std::string& name) const {
    index_of(name);
    for (int k = 0; k < isize(found_.openings); ++k) {
      const auto& lines = found_.openings[static_cast<size_t>(k)].lines;
      if (std::find(lines.begin(), lines.end(), name) != lines.end()) return k;
    }
    fail("found no closed loop of free edges with '" + name + "', expected an opening");
  }

  // Adds a free edge to the curves of the scene; the result is its name there.
  std::string add_line(const std::string& name) {
    CharacterLine& added =
        result_.lines.emplace_back(found_.lines[static_cast<size_t>(index_of(name))]);
    const auto taken = [&](const std::string& wanted) {
      return std::any_of(result_.lines.begin(), result_.lines.end() - 1,
                         [&](const CharacterLine& one) { return one.name == wanted; });
    };
    for (int n = 2; taken(added.name); ++n) added.name = name + "_" + std::to_string(n);
    return added.name;
  }

  void fill(const NeighbourOpening& opening, int count) {
    RegionSpec spec;
    spec.name = count > 1 || scene_.neighbours.size() > 1
                    ? "patch " + std::to_string(result_.regions.size() + 1)
                    : "patch";
    spec.where = scene_.at(given_.location);
    spec.loops.emplace_back();
    for (const std::string& name : opening.lines) spec.loops.front().push_back(add_line(name));
    // Elements smaller than the triangles of the mesh would only make small triangles beside large
    // ones. The usual length is 1/20 of the size.
    constexpr double usual = 1.0 / 20;
    if (!(scene_.skin.options.edge_length > 0) &&
        opening.edge_length > usual * opening.length / std::numbers::pi)
      spec.skin.edge_length = opening.edge_length;
    if (!has_outlines(scene_)) result_.regions.push_back(std::move(spec));
  }

  const Scene& scene_;
  const SceneNeighbour& given_;
  SceneNeighbours& result_;
  bool connects_;
  NeighbourFaces found_;
};

// Replaces the faces in two openings by one annular face between them, or connects the edges of a blend.
void connect(const Scene& scene, const SceneNeighbour& bridge, SceneNeighbours& result) {
  if (!result.blend.empty()) {
    try {
      Blend blend = blend_between(result.blend, bridge.tension);
      result.lines.insert(result.lines.end(), blend.curves.begin(), blend.curves.end());
      result.regions = {std::move(blend.region)};
    } catch (const InputError& e) {
      throw InputError(scene.at(bridge.location) + e.what());
    }
    return;
  }
  if (result.regions.size() != 2)
    throw InputError(scene.at(bridge.location) + "found a blend of " +
                     format_count(isize(result.regions), "opening") +
                     ", expected two; 'openings' (--opening) or 'edges' (--edge) selects them:" +
                     result.openings);
  RegionSpec one = std::move(result.regions[0]);
  one.name = "bridge";
  one.loops.push_back(std::move(result.regions[1].loops.front()));
  one.annulus = true;
  result.regions = {std::move(one)};
}

}  // namespace

bool has_outlines(const Scene& scene) {
  return std::any_of(scene.lines.begin(), scene.lines.end(), [](const SceneLine& line) {
    return line.role == CharacterLine::Role::Outline;
  });
}

bool has_blend(const Scene& scene) {
  return has_bridge(scene) &&
         std::any_of(scene.neighbours.begin(), scene.neighbours.end(),
                     [](const SceneNeighbour& given) { return !given.edges.empty(); });
}

SceneNeighbours read_neighbours(const Scene& scene) {
  SceneNeighbours result;
  for (const SceneNeighbour& given : scene.neighbours) NeighbourReader(scene, given, result).read();
  const auto bridge = std::find_if(scene.neighbours.begin(), scene.neighbours.end(),
                                   [](const SceneNeighbour& given) { return given.bridge; });
  if (bridge != scene.neighbours.end()) connect(scene, *bridge, result);
  return result;
}

}  // namespace batten
