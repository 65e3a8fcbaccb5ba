#include "batten/mesh/regions/feature_region_deformer.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include "batten/core/disjoint_sets.h"
#include "batten/core/errors.h"
#include "batten/core/parallel_chunks.h"
#include "batten/core/rotations.h"
#include "batten/mesh/regions/feature_region_system.h"
#include "batten/mesh/rotation_batch.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/mesh/selection.h"

namespace batten {
namespace {

using Lists = std::vector<std::vector<int>>;

void check_rotation(const std::string& name, const Mat3& R) {
  if (!((R.transpose() * R - Mat3::Identity()).norm() < 1e-9) || !(R.determinant() > 0))
    throw InputError("the rotation of region '" + name + "' is none, expected RᵀR = 1, det R = 1");
}

void check_scale(const std::string& name, double scale) {
  if (!(scale > 0) || !(scale < 1e100))
    throw InputError("the scale of region '" + name + "' is " + format_number(scale) +
                     ", expected a number above 0");
}

std::vector<std::string> checked_names(const std::vector<FeatureRegion>& regions) {
  std::set<std::string> names;
  std::vector<std::string> list;
  for (const auto& region : regions) {
    if (region.name.empty()) throw InputError("found a region without name");
    if (!names.insert(region.name).second)
      throw InputError("the region '" + region.name + "' is there twice, expected different names");
    if (region.rotation) check_rotation(region.name, *region.rotation);
    check_scale(region.name, region.scale);
    list.push_back(region.name);
  }
  return list;
}

const FeatureRegionOptions& checked(const FeatureRegionOptions& options) {
  if (!(options.weight > 0) || !std::isfinite(options.weight))
    throw InputError("the weight of feature regions is " + format_number(options.weight) +
                     ", expected a number above 0");
  return options;
}

}  // namespace

struct FeatureRegionDeformer::Data {
  Data(const TriangleMesh& given, std::vector<FeatureRegion> stated, DeformProblem constraints,
       const FeatureRegionOptions& wanted);
  void find_constraint_sources();
  void group();
  void take(const Points& estimate, std::span<const HandleTransform> moves);
  void fit_face_rotations(const Points& estimate);
  void fit_region_rotations();
  Mat3 mean_of_group(int group) const;

  TriangleMesh mesh;
  std::vector<FeatureRegion> regions;
  DeformProblem problem;
  FeatureRegionOptions options;
  std::vector<std::string> names;
  Lists faces, corners;
  std::optional<FeatureRegionSystem> system, soft;  // soft: for deform_per_face() of hard regions
  std::vector<int> group_of;                        // lowest region of those that turn as one
  std::vector<int> constrained_by;  // of each group's lowest region: handle, kFixed, or kFree

  DeformEdit edit;
  std::vector<std::vector<Mat3>> face_rotations;
  std::vector<std::vector<double>> areas;
  std::vector<Mat3> rotations, scaled;  // R', s R'
  std::vector<double> scales;
  Points result;
};

FeatureRegionDeformer::Data::Data(const TriangleMesh& given, std::vector<FeatureRegion> stated,
                                  DeformProblem constraints, const FeatureRegionOptions& wanted)
    : mesh(given),
      regions(std::move(stated)),
      problem(std::move(constraints)),
      options(checked(wanted)),
      names(checked_names(regions)),
      result(given.points()) {
  for (const auto& region : regions) {
    faces.push_back(faces_of(mesh, region));
    corners.push_back(vertices_of_triangles(mesh.topology(), faces.back()));
    face_rotations.emplace_back(faces.back().size(), Mat3::Identity());
    areas.emplace_back();
    for (const int f : faces.back()) areas.back().push_back(mesh.area_vector(f).norm() / 2);
    scales.push_back(region.scale);
  }
  rotations.assign(regions.size(), Mat3::Identity());
  scaled = rotations;
  system.emplace(mesh, problem, names, faces, corners, options);
  group();
  find_constraint_sources();
}

void FeatureRegionDeformer::Data::group() {
  DisjointSets groups(regions.size());
  if (options.kind == FeatureRegionOptions::Kind::Hard) {
    std::vector<int> first(mesh.vertex_count(), -1);
    for (size_t r = 0; r < regions.size(); ++r)
      for (const int v : corners[r])
        if (first[v] < 0)
          first[v] = static_cast<int>(r);
        else
          groups.unite(first[v], static_cast<int>(r));
  }
  for (size_t r = 0; r < regions.size(); ++r) group_of.push_back(groups.find(static_cast<int>(r)));
}

void FeatureRegionDeformer::Data::find_constraint_sources() {
  constrained_by.assign(regions.size(), DeformSystem::kFree);
  for (size_t r = 0; r < regions.size(); ++r)
    for (const int v : corners[r])
      if (system->constrained_by(v) != DeformSystem::kFree)
        constrained_by[group_of[r]] =
            std::max(constrained_by[group_of[r]], system->constrained_by(v));
}

void FeatureRegionDeformer::Data::take(const Points& estimate,
                                       std::span<const HandleTransform> moves) {
  edit.handles.assign(moves.begin(), moves.end());
  check(problem, edit);
  if (estimate.rows() != mesh.vertex_count() || !estimate.allFinite())
    throw InputError("the estimate has " + std::to_string(estimate.rows()) + " points, expected " +
                     std::to_string(mesh.vertex_count()) + " finite ones");
  fit_face_rotations(estimate);
  fit_region_rotations();
}

void FeatureRegionDeformer::Data::fit_face_rotations(const Points& estimate) {
  for (size_t r = 0; r < regions.size(); ++r)
    parallel_chunks<256>(isize(faces[r]), [&](long begin, long end) {
      const auto n = static_cast<size_t>(end - begin);
      rotations_of_triangles(mesh.triangles(), std::span(faces[r]).subspan(begin, n), mesh.points(),
                             estimate, std::span(face_rotations[r]).subspan(begin, n));
    });
}

Mat3 FeatureRegionDeformer::Data::mean_of_group(int group) const {
  std::vector<Mat3> all;
  std::vector<double> weights;
  for (size_t r = 0; r < regions.size(); ++r)
    if (group_of[r] == group) {
      all.insert(all.end(), face_rotations[r].begin(), face_rotations[r].end());
      weights.insert(weights.end(), areas[r].begin(), areas[r].end());
    }
  return options.mean == FeatureRegionOptions::Mean::Squared ? mean_rotation(all, weights)
                                                             : median_rotation(all, weights);
}

void FeatureRegionDeformer::Data::fit_region_rotations() {
  std::vector<const Mat3*> prescribed(regions.size(), nullptr);  // of each group
  for (size_t r = 0; r < regions.size(); ++r)
    if (regions[r].rotation && !prescribed[group_of[r]])
      prescribed[group_of[r]] = &*regions[r].rotation;
  for (size_t r = 0; r < regions.size(); ++r) {
    const int group = group_of[r], by = constrained_by[group];
    scales[r] = by >= 0 ? edit.handles[by].scale : regions[r].scale;
    if (regions[r].rotation) {
      rotations[r] = *regions[r].rotation;
    } else if (prescribed[group]) {
      rotations[r] = *prescribed[group];
    } else if (by >= 0) {
      rotations[r] = rotation_matrix(edit.handles[by].rotation_vector);
    } else if (by != DeformSystem::kFree) {
      rotations[r].setIdentity();
    } else {
      rotations[r] = group == static_cast<int>(r) ? mean_of_group(group) : rotations[group];
    }
    scaled[r] = scales[r] * rotations[r];
  }
}

FeatureRegionDeformer::FeatureRegionDeformer(const TriangleMesh& mesh,
                                             std::vector<FeatureRegion> regions,
                                             std::vector<int> fixed, std::vector<Handle> handles,
                                             const FeatureRegionOptions& options) {
  DeformProblem constraints;
  constraints.fixed = std::move(fixed);
  constraints.handles = std::move(handles);
  data_ = std::make_unique<Data>(mesh, std::move(regions), std::move(constraints), options);
}
FeatureRegionDeformer::~FeatureRegionDeformer() = default;
FeatureRegionDeformer::FeatureRegionDeformer(FeatureRegionDeformer&&) noexcept = default;
FeatureRegionDeformer& FeatureRegionDeformer::operator=(FeatureRegionDeformer&&) noexcept = default;

const Points& FeatureRegionDeformer::deform(const Points& estimate,
                                            std::span<const HandleTransform> moves) {
  Data& d = *data_;
  d.take(estimate, moves);
  d.system->solve(
      estimate, d.edit, d.scales, d.scaled,
      [&](int region, int) -> const Mat3& { return d.scaled[region]; }, d.result);
  return d.result;
}

const Points& FeatureRegionDeformer::deform_per_face(const Points& estimate,
                                                     std::span<const HandleTransform> moves) {
  Data& d = *data_;
  d.take(estimate, moves);
  FeatureRegionSystem* system = &*d.system;
  if (d.options.kind == FeatureRegionOptions::Kind::Hard) {
    FeatureRegionOptions soft = d.options;
    soft.kind = FeatureRegionOptions::Kind::Soft;
    if (!d.soft) d.soft.emplace(d.mesh, d.problem, d.names, d.faces, d.corners, soft);
    system = &*d.soft;
  }
  system->solve(
      estimate, d.edit, d.scales, d.scaled,
      [&](int region, int k) -> Mat3 { return d.scales[region] * d.face_rotations[region][k]; },
      d.result);
  return d.result;
}

void FeatureRegionDeformer::set_rotation(int region, const std::optional<Mat3>& rotation) {
  FeatureRegion& r = data_->regions.at(region);
  if (rotation) check_rotation(r.name, *rotation);
  r.rotation = rotation;
}

void FeatureRegionDeformer::set_scale(int region, double scale) {
  FeatureRegion& r = data_->regions.at(region);
  check_scale(r.name, scale);
  r.scale = scale;
}

const Points& FeatureRegionDeformer::positions() const { return data_->result; }
const std::vector<Mat3>& FeatureRegionDeformer::region_rotations() const {
  return data_->rotations;
}
const std::vector<double>& FeatureRegionDeformer::region_scales() const { return data_->scales; }
const std::vector<Mat3>& FeatureRegionDeformer::face_rotations(int region) const {
  return data_->face_rotations.at(region);
}
const std::vector<int>& FeatureRegionDeformer::faces(int region) const {
  return data_->faces.at(region);
}
const std::vector<int>& FeatureRegionDeformer::vertices(int region) const {
  return data_->corners.at(region);
}
const std::vector<FeatureRegion>& FeatureRegionDeformer::regions() const { return data_->regions; }
int FeatureRegionDeformer::unknowns() const { return data_->system->unknowns(); }

}  // namespace batten
