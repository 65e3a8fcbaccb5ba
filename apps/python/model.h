// The Python class Model: a scene and the surface that it produces.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "batten/apps/commands/shapes/solved_shape.h"
#include "batten/io/report/report.h"

namespace batten::python {

/// Facets of all regions in common arrays; bit-identical to the output of write_vtp().
struct FacetArrays {
  std::vector<double> points, normals;  ///< x, y, z of each point in turn
  std::vector<std::array<int, 3>> triangles;
  std::vector<int> regions;  ///< region of each triangle
};

/// A scene, its model and one shape of it. Immutable; copies share their data.
class Model {
 public:
  /// Builds the model of the scene's lines and solves for its shape. Throws as run_scene() does.
  static std::shared_ptr<const Model> of_scene(const Scene& scene, const Progress& progress);
  /// Wraps another shape of the same lines.
  Model(Scene scene, std::vector<CharacterLine> lines, std::shared_ptr<const BuiltModel> made,
        SolvedShape shape);

  /// Computes the shape for other values of the scene's parameters. The model is reused if only
  /// session parameters change.
  std::shared_ptr<const Model> with_values(
      const std::vector<std::pair<std::string, double>>& values, const Progress& progress) const;

  const Scene& scene() const { return scene_; }
  const std::vector<CharacterLine>& lines() const { return lines_; }
  const std::shared_ptr<const BuiltModel>& made() const { return made_; }
  const SolvedShape& shape() const { return shape_; }

  /// Facets of the shape; computed at first use, thread-safe.
  std::shared_ptr<const FacetArrays> facets() const;
  /// Measured quality of the shape (export_shape() without files); computed at first use.
  const Report& report(const Progress& progress) const;

 private:
  Scene scene_;
  std::vector<CharacterLine> lines_;
  std::shared_ptr<const BuiltModel> made_;  // before any session
  SolvedShape shape_;
  mutable std::mutex mutex_;
  mutable std::shared_ptr<const FacetArrays> facets_;
  mutable std::optional<Report> report_;
};

/// Throws InputError if no region has a surface.
void require_surface(const Model& model);

/// Reads a scene file, or makes a scene of the curves in a curve file.
Scene scene_of_file(const std::string& file);

}  // namespace batten::python
