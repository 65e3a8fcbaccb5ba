// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/mesh.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/text.h"
#include "batten/mesh/features/feature_lines.h"
#include "batten/mesh/selection.h"
#include "batten/scenes/mesh_data.h"

namespace batten {
namespace detail {
namespace {

void check_faces(const ShellMesh& shells) {
  constexpr size_t fewest = 3;
  for (int f = 0; f < shells.face_count(); ++f) {
    const std::string face = " in face " + std::to_string(f) + " (from 0), expected ";
    if (shells.face(f).size() < fewest)
      throw InputError("faces: found " + format_count(isize(shells.face(f)), "vertex", "vertices") +
                       face + "3 or more");
    for (const int v : shells.face(f))
      if (v < 0 || v >= shells.node_count())
        throw InputError("faces: found " + std::to_string(v) + face + "0 to " +
                         std::to_string(shells.node_count() - 1));
  }
}

MeshSource source_without_file(ShellMesh shells) {
  check_faces(shells);
  PreparedMesh prepared = prepare(shells);
  return {MeshFile::from_shells(std::move(shells)), std::move(prepared)};
}

/// The vertices, if they are nodes.
std::vector<int> known_nodes(const std::vector<int>& vertices, const std::string& what,
                             int node_count) {
  for (const int v : vertices)
    if (v < 0 || v >= node_count)
      throw InputError(what + ": found " + std::to_string(v) + ", expected 0 to " +
                       std::to_string(node_count - 1));
  return vertices;
}

PointConstraint kernel_constraint(const OnPlane& given) {
  return {given.name, VertexCombination::mean_of(given.vertices), PointConstraint::Kind::OnPlane,
          given.normal};
}

PointConstraint kernel_constraint(const OnLine& given) {
  return {given.name, VertexCombination::mean_of(given.vertices), PointConstraint::Kind::OnLine,
          given.direction};
}

void add_constraints(const DeformerSettings& settings, const TriangleMesh& mesh,
                     DeformProblem& problem) {
  const int count = mesh.topology().node_count();
  for (const auto& any : settings.constraints)
    std::visit(
        [&](const auto& one) {
          known_nodes(one.vertices, "constraint '" + one.name + "'", count);
          problem.point_constraints.push_back(kernel_constraint(one));
        },
        any);
  for (const CharacterChain& chain : settings.chains) {
    known_nodes(chain.vertices, "chain '" + chain.name + "'", count);
    problem.chains.push_back(with_default_width(chain, mesh));
  }
  for (const LinearConstraint& row : settings.linear_constraints) {
    const std::string what = "linear constraint '" + row.name + "'";
    for (const auto& entry : row.combination.entries) known_nodes({entry.vertex}, what, count);
    if (row.rotates_with != -1) known_nodes({row.rotates_with}, what + ", rotates_with", count);
    problem.rows.push_back(row);
  }
}

DeformProblem problem_of(const DeformerSettings& settings, const TriangleMesh& mesh) {
  const MeshTopology& topology = mesh.topology();
  const int count = topology.node_count();
  DeformProblem problem;
  problem.weighting = settings.weighting;
  problem.fixed = known_nodes(settings.fixed, "fixed", count);
  for (const VertexGroup& handle : settings.handles)
    problem.handles.push_back(
        {handle.name, known_nodes(handle.vertices, "handle '" + handle.name + "'", count)});
  const auto add_features = [&](const std::vector<VertexGroup>& groups, FormFeature::Kind kind) {
    for (const VertexGroup& group : groups)
      problem.features.push_back(
          {group.name, known_nodes(group.vertices, "feature '" + group.name + "'", count), kind});
  };
  add_features(settings.features, FormFeature::Kind::Free);
  add_features(settings.keep_orientation, FormFeature::Kind::TranslationOnly);
  if (settings.region_of_interest)
    problem.region = known_nodes(*settings.region_of_interest, "region_of_interest", count);
  add_constraints(settings, mesh, problem);
  return expand_to_nodes(std::move(problem), topology);
}

/// A point of the plane or line of each constraint. The constraints have been checked.
std::vector<Vec3> origins_of(const DeformerSettings& settings, const TriangleMesh& mesh) {
  std::vector<Vec3> origins;
  for (const auto& any : settings.constraints)
    std::visit(
        [&](const auto& one) {
          if (one.origin && !one.origin->allFinite())
            throw InputError("constraint '" + one.name +
                             "': found an origin that is not finite, expected a point");
          origins.push_back(one.origin
                                ? *one.origin
                                : VertexCombination::mean_of(one.vertices).at(mesh.points()));
        },
        any);
  return origins;
}

std::vector<double> scales_of(const std::map<std::string, double>& given,
                              const std::vector<FormFeature>& features) {
  if (given.empty()) return {};
  std::vector<double> scales(features.size(), 1);
  for (const auto& [name, scale] : given)
    scales[index_of_name(name, features, "scales", "feature")] = scale;
  return scales;
}

std::vector<Vec3> targets_of(const std::map<std::string, Vec3>& given,
                             const std::vector<LinearConstraint>& rows) {
  std::vector<Vec3> targets;
  if (given.empty()) return targets;
  for (const LinearConstraint& row : rows) targets.push_back(row.target);
  for (const auto& [name, target] : given)
    targets[index_of_name(name, rows, "targets", "linear constraint")] = target;
  return targets;
}

}  // namespace

SharedMesh::SharedMesh(MeshSource read) : source(std::move(read)), of_file(true) {
  find_node_triangles();
}

SharedMesh::SharedMesh(ShellMesh shells, std::vector<MeshSet> named)
    : source(source_without_file(std::move(shells))), of_file(false), own_sets(std::move(named)) {
  find_node_triangles();
}

void SharedMesh::find_node_triangles() {
  if (topology().vertex_count() == topology().node_count()) return;
  node_triangles_ = topology().triangles();
  for (auto& triangle : node_triangles_)
    for (int& corner : triangle) corner = topology().node_of(corner);
}

const std::vector<std::array<int, 3>>& SharedMesh::node_triangles() const {
  return node_triangles_.empty() ? topology().triangles() : node_triangles_;
}

DeformerState::DeformerState(const Mesh& of, const DeformerSettings& given)
    : mesh(of), settings(given) {
  const TriangleMesh& triangles = of.data().mesh();
  DeformProblem problem = problem_of(given, triangles);
  if (given.rotation_mode == RotationMode::Harmonic) {
    linear = std::make_unique<FormFeatureDeformer>(triangles, std::move(problem));
  } else {
    const MeshEditorOptions options{
        .rotation_mode = given.rotation_mode, .keep_centres = false, .centres = {}};
    shape = triangles.points();
    editor =
        std::make_unique<MeshEditor>(of.data().source.prepared, shape, std::move(problem), options);
  }
  origins = origins_of(given, triangles);
  last.handles.resize(this->problem().handles.size());
  last.constraint_origins = origins;
}

void DeformerState::deform(const DeformEdit& edit, bool correct) {
  if (linear) {
    linear->deform(edit);
    report.last_correction = correct ? linear->correct() : 0;
    return;
  }
  editor->set(edit);
  shape = editor->solve_to_equilibrium();
  const MeshEditStatistics& statistics = editor->statistics();
  report = {statistics.iterations, statistics.converged, statistics.last_correction};
  residual = statistics.hard_residual;
}

HandleTransform transform_of(const Move& move) {
  if (move.axis.norm() == 0) throw InputError("axis: found length 0, expected a direction");
  HandleTransform transform;
  transform.translation = move.translate;
  transform.rotation_vector = to_rotation_vector(move.axis, move.angle * std::numbers::pi / 180);
  transform.scale = move.scale;
  if (move.about) transform.about = *move.about;
  return transform;
}

std::vector<HandleTransform> transforms_of(const std::map<std::string, Move>& moves,
                                           const std::vector<Handle>& handles,
                                           const TriangleMesh& mesh) {
  std::vector<HandleTransform> transforms(handles.size());
  for (const auto& [name, move] : moves) {
    const size_t h = index_of_name(name, handles, "moves", "handle");
    transforms[h] = transform_of(move);
    if (move.about) continue;
    for (const int v : handles[h].vertices) transforms[h].about += mesh.point(v);
    transforms[h].about /= static_cast<double>(handles[h].vertices.size());
  }
  return transforms;
}

}  // namespace detail

// Meshes.

namespace {

ShellMesh shells_of(const std::vector<Vec3>& points, const std::vector<std::vector<int>>& faces) {
  ShellMesh shells;
  shells.points.resize(static_cast<long>(points.size()), 3);
  for (long i = 0; i < shells.points.rows(); ++i)
    shells.points.row(i) = points[static_cast<size_t>(i)];
  for (const std::vector<int>& face : faces) shells.add_face(face);
  return shells;
}

std::vector<int> loop_of_nodes(std::vector<int> loop, const MeshTopology& topology) {
  for (int& vertex : loop) vertex = topology.node_of(vertex);
  return loop;
}

ShellMesh at_points(const ShellMesh& shells, const Points& points) {
  if (points.rows() != shells.node_count())
    throw InputError("points: found " + std::to_string(points.rows()) +
                     " rows, expected one for each of the " + std::to_string(shells.node_count()) +
                     " nodes");
  ShellMesh result = shells;
  result.points = points;
  return result;
}

}  // namespace

Mesh::Mesh(const std::vector<Vec3>& points, const std::vector<std::vector<int>>& faces)
    : data_(std::make_shared<const detail::SharedMesh>(shells_of(points, faces))) {}

const Points& Mesh::points() const { return data_->shells().points; }

std::vector<std::vector<int>> Mesh::faces() const {
  const ShellMesh& shells = data_->shells();
  std::vector<std::vector<int>> faces(static_cast<size_t>(shells.face_count()));
  for (int f = 0; f < shells.face_count(); ++f) {
    const auto nodes = shells.face(f);
    const size_t corners = shells.corners(f).size();
    for (size_t i = 0; i < corners; ++i) {
      faces[static_cast<size_t>(f)].push_back(nodes[i]);
      if (shells.second_order(f)) faces[static_cast<size_t>(f)].push_back(nodes[corners + i]);
    }
  }
  return faces;
}

const std::vector<std::array<int, 3>>& Mesh::triangles() const { return data_->node_triangles(); }

const std::vector<int>& Mesh::triangle_faces() const {
  return data_->source.prepared.face_of_triangle;
}

const Points& Mesh::corner_normals() const { return data_->corner_normals; }
const std::vector<MeshSet>& Mesh::sets() const { return data_->sets(); }

std::vector<std::vector<int>> Mesh::boundary_loops() const {
  std::vector<std::vector<int>> loops;
  for (const std::vector<int>& loop : data_->topology().boundary_loops())
    loops.push_back(loop_of_nodes(loop, data_->topology()));
  return loops;
}

std::string Mesh::format() const { return data_->of_file ? data_->source.file.format() : ""; }

const std::vector<std::string>& Mesh::notes() const { return data_->source.prepared.notes; }

std::vector<Hole> Mesh::holes(double flange_width) const {
  FeatureDetectionOptions options;
  options.flange_width = flange_width;
  std::vector<Hole> holes;
  for (DetectedFeature& found : suggested_features(options))
    if (found.kind == DetectedFeature::Kind::Hole)
      holes.push_back(
          {found.measure, std::move(found.name), std::move(found.vertices), std::move(found.loop)});
  return holes;
}

std::vector<DetectedFeature> Mesh::suggested_features(
    const FeatureDetectionOptions& options) const {
  const auto refuse = [](const std::string& what, double found, const std::string& expected) {
    throw InputError(what + ": found " + format_number(found) + ", expected " + expected);
  };
  if (!(options.crease_degrees > 0 && options.crease_degrees < 180))
    refuse("crease_angle", options.crease_degrees, "degrees above 0 and below 180");
  if (options.flange_rings < 1) refuse("flange_rings", options.flange_rings, "1 or more");
  if (!(options.flange_width >= 0) || !std::isfinite(options.flange_width))
    refuse("flange_width", options.flange_width, "a number from 0");
  std::vector<DetectedFeature> features = detect_features(data_->mesh(), options);
  for (DetectedFeature& feature : features) {
    feature.vertices = data_->topology().nodes_of(std::move(feature.vertices));
    feature.loop = loop_of_nodes(std::move(feature.loop), data_->topology());
  }
  return features;
}

VecX Mesh::saliency() const {
  return mesh_saliency(data_->mesh()).head(data_->topology().node_count());
}

std::vector<int> Mesh::crease_path(const std::vector<Vec3>& through, bool closed) const {
  try {
    std::vector<int> vertices;
    for (const Vec3& point : through) {
      if (!point.allFinite())
        throw InputError("found the point " + format_point(point) +
                         ", expected finite coordinates");
      vertices.push_back(nearest_vertex(data_->mesh(), point));
    }
    return batten::crease_path(data_->mesh(), vertices, closed);
  } catch (const InputError& e) {
    throw InputError("through: " + std::string(e.what()));
  }
}

std::vector<int> Mesh::vertices_in(const Vec3& low, const Vec3& high) const {
  if (!(low.array() <= high.array()).all())
    throw InputError("box: found the corners " + format_point(low) + " and " + format_point(high) +
                     ", expected the lower corner first");
  return data_->topology().nodes_of(vertices_in_box(data_->mesh(), low, high));
}

Box3 Mesh::bounds() const { return data_->mesh().box(); }

Mesh Mesh::with_points(const Points& points) const {
  return Mesh(
      std::make_shared<const detail::SharedMesh>(at_points(data_->shells(), points), sets()));
}

void Mesh::save(const std::filesystem::path& file, const std::string& unit) const {
  write_mesh(file, data_->shells(), sets(), unit.empty() ? 0 : unit_in_metres(unit));
}

void Mesh::save(const std::filesystem::path& file, const Points& points,
                const std::string& unit) const {
  write_mesh(file, at_points(data_->shells(), points), sets(),
             unit.empty() ? 0 : unit_in_metres(unit));
}

double Mesh::save_as_read(const std::filesystem::path& file, const Points& points,
                          bool large_field) const {
  if (!data_->of_file)
    throw InputError(file.string() +
                     ": found a mesh that was not read from a file, expected one of read_mesh(); "
                     "save() writes every mesh");
  MeshWriteOptions options;
  options.large_field_nodes = large_field;
  return data_->source.file.write(file, points, options).largest;
}

Mesh read_mesh(const std::filesystem::path& file) {
  return Mesh(std::make_shared<const detail::SharedMesh>(read_source(file)));
}

// Deformers.

Deformer::Deformer(const Mesh& mesh, const DeformerSettings& settings)
    : state_(std::make_unique<detail::DeformerState>(mesh, settings)) {}

Deformer::~Deformer() = default;
Deformer::Deformer(Deformer&&) noexcept = default;
Deformer& Deformer::operator=(Deformer&&) noexcept = default;

Points Deformer::deform(const std::map<std::string, Move>& moves,
                        const std::map<std::string, double>& scales, bool correct,
                        const std::map<std::string, Vec3>& origins,
                        const std::map<std::string, Vec3>& targets) {
  const DeformProblem& problem = state_->problem();
  DeformEdit edit;
  edit.handles = detail::transforms_of(moves, problem.handles, mesh().data().mesh());
  edit.feature_scales = detail::scales_of(scales, problem.features);
  edit.constraint_origins = state_->origins;
  for (const auto& [name, origin] : origins)
    edit.constraint_origins[detail::index_of_name(name, problem.point_constraints, "origins",
                                                  "constraint")] = origin;
  edit.targets = detail::targets_of(targets, problem.rows);
  return state_->serialize([&] {
    state_->deform(edit, correct);
    state_->last = edit;
    state_->last_correct = correct;
    return node_positions(state_->positions(), mesh().data().source.file);
  });
}

Points Deformer::positions() const {
  return state_->serialize(
      [&] { return node_positions(state_->positions(), mesh().data().source.file); });
}

DeformerReport Deformer::report() const {
  return state_->serialize([&] { return state_->report; });
}

double Deformer::residual() const {
  return state_->serialize(
      [&] { return state_->linear ? state_->linear->hard_residual() : state_->residual; });
}

int Deformer::unknowns() const {
  return (state_->linear ? state_->linear->counts() : state_->editor->counts()).unknowns;
}

const std::vector<std::string>& Deformer::notes() const {
  return state_->linear ? state_->linear->notes() : state_->editor->notes();
}

const Mesh& Deformer::mesh() const { return state_->mesh; }

const DeformerSettings& Deformer::settings() const { return state_->settings; }

}  // namespace batten
