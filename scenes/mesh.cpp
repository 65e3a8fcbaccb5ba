#include "batten/scenes/mesh.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/text.h"
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

DeformProblem problem_of(const DeformerSettings& settings, const MeshTopology& topology) {
  const int count = topology.node_count();
  DeformProblem problem;
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
  return expand_to_nodes(std::move(problem), topology);
}

/// Index of the handle or feature with a name. Throws InputError, with the nearest name.
template <class Named>
size_t index_of_name(const std::string& name, const std::vector<Named>& all,
                     const std::string& what, const std::string& kind) {
  std::vector<std::string> names;
  for (size_t i = 0; i < all.size(); ++i) {
    if (all[i].name == name) return i;
    names.push_back(all[i].name);
  }
  throw InputError(what + ": found '" + name + "', expected a " + kind + "'s name" +
                   did_you_mean(name, names));
}

std::vector<double> scales_of(const std::map<std::string, double>& given,
                              const std::vector<FormFeature>& features) {
  if (given.empty()) return {};
  std::vector<double> scales(features.size(), 1);
  for (const auto& [name, scale] : given)
    scales[index_of_name(name, features, "scales", "feature")] = scale;
  return scales;
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
    : mesh(of),
      settings(given),
      deformer(of.data().mesh(), problem_of(given, of.data().topology())) {}

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
  if (!(flange_width >= 0) || !std::isfinite(flange_width))
    throw InputError("flange_width: found " + format_number(flange_width) +
                     ", expected a number from 0");
  FeatureDetectionOptions options;
  options.flange_width = flange_width;
  std::vector<Hole> holes;
  for (DetectedFeature& found : detect_features(data_->mesh(), options))
    if (found.kind == DetectedFeature::Kind::Hole)
      holes.push_back({found.measure, std::move(found.name),
                       data_->topology().nodes_of(std::move(found.vertices)),
                       loop_of_nodes(std::move(found.loop), data_->topology())});
  return holes;
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
                        const std::map<std::string, double>& scales, bool correct) {
  const DeformProblem& problem = state_->deformer.problem();
  DeformEdit edit;
  edit.handles = detail::transforms_of(moves, problem.handles, mesh().data().mesh());
  edit.feature_scales = detail::scales_of(scales, problem.features);
  return state_->serialize([&] {
    state_->deformer.deform(edit);
    if (correct) state_->deformer.correct();
    return node_positions(state_->deformer.positions(), mesh().data().source.file);
  });
}

Points Deformer::positions() const {
  return state_->serialize(
      [&] { return node_positions(state_->deformer.positions(), mesh().data().source.file); });
}

double Deformer::residual() const {
  return state_->serialize([&] { return state_->deformer.hard_residual(); });
}

int Deformer::unknowns() const { return state_->deformer.counts().unknowns; }

const std::vector<std::string>& Deformer::notes() const { return state_->deformer.notes(); }

const Mesh& Deformer::mesh() const { return state_->mesh; }

const DeformerSettings& Deformer::settings() const { return state_->settings; }

}  // namespace batten
