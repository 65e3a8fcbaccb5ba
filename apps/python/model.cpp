#include "batten/apps/python/model.h"

#include "batten/apps/commands/commands.h"
#include "batten/apps/commands/lines/scene_lines.h"
#include "batten/apps/commands/shapes/make_session.h"
#include "batten/apps/commands/shapes/shape_files.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/skinning/facets/facets.h"

namespace batten::python {
namespace {

/// Facets of one face, with points and normals of the exact surface.
struct FacetsOfRegion {
  DisplayFacets display;
  std::vector<SurfaceJet> jets;
};

FacetArrays joined(const std::vector<FacetsOfRegion>& regions) {
  FacetArrays all;
  for (int r = 0; r < isize(regions); ++r) {
    const int first = static_cast<int>(all.points.size() / 3);
    for (const SurfaceJet& jet : regions[static_cast<size_t>(r)].jets) {
      const Vec3 normal = jet.normal();
      all.points.insert(all.points.end(), jet.x.data(), jet.x.data() + 3);
      all.normals.insert(all.normals.end(), normal.data(), normal.data() + 3);
    }
    for (std::array<int, 3> facet : regions[static_cast<size_t>(r)].display.tessellation.facets) {
      for (int& corner : facet) corner += first;
      all.triangles.push_back(facet);
      all.regions.push_back(r);
    }
  }
  return all;
}

FacetArrays facets_of(const std::vector<SkinnedRegion>& regions) {
  std::vector<FacetsOfRegion> parts(regions.size());
  const auto all = pointers(regions);
  const double length = mean_facet_length(all);
  const int per_edge = display_facets_per_edge(all);
  parallel_for(isize(regions), [&](int r) {
    FacetsOfRegion& part = parts[static_cast<size_t>(r)];
    const SkinnedRegion& region = regions[static_cast<size_t>(r)];
    part.display = facets(region, per_edge, length);
    for (const Location& where : part.display.tessellation.points)
      part.jets.push_back(region.surface.jet(where));
  });
  return joined(parts);
}

}  // namespace

Model::Model(Scene scene, std::vector<CharacterLine> lines, std::shared_ptr<const BuiltModel> made,
             SolvedShape shape)
    : scene_(std::move(scene)),
      lines_(std::move(lines)),
      made_(std::move(made)),
      shape_(std::move(shape)) {}

std::shared_ptr<const Model> Model::of_scene(const Scene& scene, const Progress& progress) {
  progress.update("curves", 0);
  std::vector<CharacterLine> lines = faired_lines(scene, progress).lines;
  auto made = std::make_shared<BuiltModel>(build_model(scene, lines, progress));
  SolvedShape shape = solve_refined_shape(*made, scene, progress);
  return std::make_shared<Model>(scene, std::move(lines), std::move(made), std::move(shape));
}

std::shared_ptr<const Model> Model::with_values(
    const std::vector<std::pair<std::string, double>>& values, const Progress& progress) const {
  Scene scene = scene_;
  bool live = true;  // the model of the curves can be reused
  for (const auto& [name, value] : values) {
    scene.set(name, value, "");
    const bool material = name.starts_with("alpha") || name.starts_with("beta");
    live &= is_session_parameter(scene, name) && !(material && made_->network);
  }
  if (!live) return of_scene(scene, progress);
  SolvedShape shape = solve_refined_shape(*made_, scene, progress);
  return std::make_shared<Model>(std::move(scene), lines_, made_, std::move(shape));
}

std::shared_ptr<const FacetArrays> Model::facets() const {
  const std::lock_guard lock(mutex_);
  if (!facets_) facets_ = std::make_shared<FacetArrays>(facets_of(shape_.regions));
  return facets_;
}

const Report& Model::report(const Progress& progress) const {
  const std::lock_guard lock(mutex_);
  if (!report_) report_ = export_shape(scene_, *made_, shape_, {}, progress);
  return *report_;
}

void require_surface(const Model& model) {
  if (model.shape().regions.empty())
    throw InputError(model.scene().name + ": found no surface, expected curves that bound a face");
}

Scene scene_of_file(const std::string& file) {
  switch (file_kind(file)) {
    case FileKind::Cad:
    case FileKind::Lines:
      return scene_of_lines({file}, {}, "mm");
    default:
      return read_scene(file);
  }
}

}  // namespace batten::python
