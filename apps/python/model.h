// A scene and the shape that it makes, as Python holds it.
#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "batten/apps/commands/shapes/solved_shape.h"
#include "batten/io/report/report.h"

namespace batten::python {

/// Facets of all regions, side by side: what write_vtp() writes, bit by bit.
struct FacetArrays {
  std::vector<double> points, normals;  ///< x, y, z one after the other
  std::vector<std::array<int, 3>> triangles;
  std::vector<int> regions;  ///< of each triangle
};

/// A scene, its model and one shape of it. It does not change; copies of what it is made of share.
class Model {
 public:
  /// Makes the model of the scene's lines and its shape. Throws what run_scene() throws.
  static std::shared_ptr<const Model> of_scene(const Scene& scene, const Progress& progress);
  /// Another shape of the same lines.
  Model(Scene scene, std::vector<CharacterLine> lines, std::shared_ptr<const BuiltModel> made,
        SolvedShape shape);

  /// The shape under other values of the scene's parameters.
  std::shared_ptr<const Model> with_values(
      const std::vector<std::pair<std::string, double>>& values, const Progress& progress) const;

  const Scene& scene() const { return scene_; }
  const std::vector<CharacterLine>& lines() const { return lines_; }
  const std::shared_ptr<const BuiltModel>& made() const { return made_; }
  const SolvedShape& shape() const { return shape_; }

  /// Made at first use, by any thread.
  std::shared_ptr<const FacetArrays> facets() const;
  /// The measures of the shape (export_shape() without a file), made at first use.
  const Report& report(const Progress& progress) const;

 private:
  Scene scene_;
  std::vector<CharacterLine> lines_;
  std::shared_ptr<const BuiltModel> made_;  // as its lines make it
  SolvedShape shape_;
  mutable std::mutex mutex_;
  mutable std::shared_ptr<const FacetArrays> facets_;
  mutable std::optional<Report> report_;
};

/// Throws InputError where no region has a surface.
void require_surface(const Model& model);

}  // namespace batten::python
