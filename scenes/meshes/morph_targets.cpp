// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/meshes/morph_targets.h"

#include <memory>
#include <numeric>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/text.h"
#include "batten/scenes/mesh_data.h"
#include "batten/scenes/model.h"
#include "batten/scenes/runs/target_files.h"

namespace batten {
namespace {

/// Appends the surface of a scene as curved triangles.
void append_scene(TargetFaces& all, const std::filesystem::path& file,
                  const TargetFileOptions& options) {
  if (!options.own_unit.empty() || options.cage)
    throw InputError("found a 'unit' or a 'cage' for a scene, expected none");
  const Model model = load(file);
  const Mesh mesh = model.mesh();
  const Points& corners = mesh.corner_normals();
  std::vector<PnTriangle::Corners> normals;
  for (long t = 0; t < corners.rows() / 3; ++t)
    normals.push_back({corners.row(3 * t).transpose(), corners.row(3 * t + 1).transpose(),
                       corners.row(3 * t + 2).transpose()});
  all.append(mesh.data().shells(), unit_in_metres(model.unit()) / unit_in_metres(options.unit),
             normals);
}

void append_target(TargetFaces& all, const std::filesystem::path& file,
                   const TargetFileOptions& options) {
  if (lower_extension(file) == ".toml")
    append_scene(all, file, options);
  else
    append_target_file(all, file, options);
}

}  // namespace

void gather_targets(const DeformScene& scene, VertexSelector& select, const TriangleMesh& mesh,
                    SharedConstraints& shared) {
  for (const MorphTargetSpec& rule : scene.targets) {
    std::vector<int> vertices;
    for (const LocatedString& name : rule.of) {
      const std::vector<int> more = vertices_of(name, shared, select);
      vertices.insert(vertices.end(), more.begin(), more.end());
    }
    if (rule.of.empty()) {
      vertices.resize(static_cast<size_t>(mesh.topology().node_count()));
      std::iota(vertices.begin(), vertices.end(), 0);
    }
    try {
      constexpr double chord = 1e-4;  // of the size
      TargetFaces faces;
      append_target(faces, rule.file,
                    {.unit = scene.unit, .own_unit = rule.unit, .chord = chord * mesh.size()});
      const std::shared_ptr<const TargetSurface> surface = target_parts(faces).whole;
      shared.surfaces.push_back(surface);
      shared.targets.emplace_back(
          mesh, sorted_unique(std::move(vertices)),
          [surface](const Vec3& p, const Vec3& along) -> std::optional<TargetPoint> {
            const auto nearest = surface->nearest(p, along);
            if (!nearest) return std::nullopt;
            return TargetPoint{nearest->at, nearest->normal, nearest->at_boundary};
          },
          TargetFollowerOptions{rule.smoothing, rule.reach, rule.offset});
    } catch (const InputError& e) {
      throw InputError(scene.at(rule.location) + e.what());
    }
  }
}

}  // namespace batten
