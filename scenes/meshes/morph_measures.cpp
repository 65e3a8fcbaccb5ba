// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/meshes/morph_measures.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "batten/core/containers.h"
#include "batten/core/geometry.h"
#include "batten/io/files/text.h"
#include "batten/mesh/element_quality.h"
#include "batten/mesh/rotation_fitting.h"
#include "batten/scenes/meshes/dimension_requirements.h"

namespace batten {
namespace {

double largest_move(const Points& before, const Points& after, int* where = nullptr) {
  long row = 0;
  const double largest = before.rows() > 0 ? (after - before).rowwise().norm().maxCoeff(&row) : 0;
  if (where) *where = static_cast<int>(row);
  return largest;
}

void measure_into(DeformReport& report, const MeshFile& file, const TriangleMesh& original,
                  const Points& all_after, const SharedConstraints& shared) {
  const Points before = node_positions(original.points(), file),
               after = node_positions(all_after, file);
  const MeshTopology& topology = original.topology();
  for (const FormFeature& f : shared.features) {
    const Similarity fit = fit_similarity(before, after, f.vertices);
    const double angle = Eigen::AngleAxisd(fit.R).angle() * 180 / std::numbers::pi;
    const auto centre = VertexCombination::mean_of(f.vertices);
    Box3 box;
    for (const int v : f.vertices) box.extend(before.row(v).transpose());
    report.features.push_back({f.name, isize(f.vertices), box.diagonal().norm(), fit.max_error,
                               fit.scale, angle, (centre.at(after) - centre.at(before)).norm()});
  }
  for (const MeshCurve& c : shared.curves)
    report.curves.push_back({c.name, isize(c.vertices), c.shape.curve.segment_count(),
                             c.shape.fairing, c.shape.wavelength, c.shape.largest_shift,
                             distance_from(c, after) / original.size(), c.shape.before,
                             c.shape.after});
  std::vector<int> feature_of(before.rows(), -1);
  for (size_t f = 0; f < shared.features.size(); ++f)
    for (const int v : shared.features[f].vertices) feature_of[v] = static_cast<int>(f);
  auto loops = topology.boundary_loops();
  for (auto& loop : loops)
    for (int& v : loop) v = topology.node_of(v);
  for (size_t l = 0; l < loops.size(); ++l) {
    DeformReport::Hole hole;
    hole.loop = static_cast<int>(l) + 1;
    hole.vertices = isize(loops[l]);
    const int owner = feature_of[loops[l][0]];
    if (owner >= 0 && std::all_of(loops[l].begin(), loops[l].end(),
                                  [&](int v) { return feature_of[v] == owner; }))
      hole.feature = shared.features[owner].name;
    hole.before = measure_hole(before, loops[l]);
    hole.after = measure_hole(after, loops[l]);
    report.holes.push_back(hole);
  }
  report.before = summarize(file.shells(), before);
  report.after = summarize(file.shells(), after);
  for (auto* q : {&report.before, &report.after})
    for (auto* m : {&q->aspect, &q->warpage_degrees, &q->jacobian, &q->smallest_angle_degrees,
                    &q->largest_angle_degrees})
      if (m->worst_face >= 0) m->worst_face = static_cast<int>(file.face_label(m->worst_face));
  for (const int f : inverted_faces(file.shells(), before, after))
    report.inverted.push_back(file.face_label(f));
  report.size = original.size();
  report.largest_coordinate = std::max(before.cwiseAbs().maxCoeff(), after.cwiseAbs().maxCoeff());
  int where = 0;
  report.largest_displacement = largest_move(before, after, &where);
  report.largest_displacement_node = file.node_label(where);
}

/// Reports how the attached elements moved.
void measure_attached_into(DeformReport& report, const MeshFile& file,
                           const AttachedNodes& attached, const Points& before,
                           const Points& after) {
  const auto& elements = file.other_elements();
  std::map<std::string, int> count;
  for (const NonShellElement& e : elements) ++count[e.name];
  const AttachedMotion motion = attached.motion(before, after);
  report.attached.elements.assign(count.begin(), count.end());
  report.attached.connections = motion.connections;
  report.attached.max_rigid_error = motion.max_rigid_error;
  report.attached.worst_connection = motion.worst_connection;
  report.attached.moved_with_shells = motion.moved_nodes;
  for (const int e : motion.inverted_solids)
    report.attached.inverted_solids.push_back(elements[e].label);
  if (motion.max_gap_change > 1e-6 * report.size)
    report.warnings.push_back(motion.worst_tie +
                              ": tied nodes leave their surface, the gap changes by up to " +
                              format_number(motion.max_gap_change) + " " + report.unit +
                              ", because handles, fixed nodes or features prescribe their motion");
}

/// Names nodes that belong to no shell and do not move, while the mesh next to them does.
void note_left_behind(DeformReport& report, const MeshFile& file, const TriangleMesh& original,
                      const AttachmentOptions& options, const Points& before, const Points& after) {
  const ShellMesh& shells = file.shells();
  std::vector<char> known(static_cast<size_t>(shells.node_count()), 0);
  for (int f = 0; f < shells.face_count(); ++f)
    for (const int v : shells.face(f)) known[v] = 1;
  std::map<std::string, std::vector<int>> left;  // by the type of an element
  const auto stays = [&](int v) { return !known[v] && before.row(v) == after.row(v); };
  for (const NonShellElement& e : file.other_elements())
    for (const int v : e.nodes)
      if (stays(v)) {
        if (options.of(e.kind) != AttachmentRule::Stay) left["of " + e.name].push_back(v);
        known[v] = 1;
      }
  for (int v = 0; v < shells.node_count(); ++v)
    if (stays(v)) left["of no element"].push_back(v);
  if (left.empty()) return;
  const TriangleTree tree(original);
  for (auto& [kind, nodes] : left) {
    double farthest = 0;
    std::string labels;
    int count = 0;
    for (const int v : nodes) {
      const auto closest = tree.nearest(before.row(v).transpose());
      double moved = 0;
      for (int k = 0; closest && k < 3; ++k) {
        const int corner = original.topology().node_of(
            original.triangles()[closest->triangle][static_cast<size_t>(k)]);
        moved = std::max(moved, (after.row(corner) - before.row(corner)).norm());
      }
      if (!(moved > 1e-9 * report.size)) continue;
      farthest = std::max(farthest, moved);
      constexpr int kMostNamed = 5;
      if (count < kMostNamed)
        labels += (count ? ", " : "") + std::to_string(file.node_label(v));
      else if (count == kMostNamed)
        labels += ", …";
      ++count;
    }
    if (count > 0)
      report.warnings.push_back(format_count(count, "node") + " " + kind + " (" + labels +
                                ") stay in place: no connection leads to a shell, and the shells "
                                "next to them move by up to " +
                                format_number(farthest) + " " + report.unit +
                                "; select them in a handle if they belong to the moved part");
  }
}

const char* dimension_type(DimensionSpec::Kind kind) {
  constexpr const char* names[] = {"distance", "radius", "angle", "area", "volume", "mass"};
  return names[static_cast<int>(kind)];
}

std::string dimension_unit(DimensionSpec::Kind kind, const std::string& length) {
  switch (kind) {
    case DimensionSpec::Kind::Angle:
      return "degrees";
    case DimensionSpec::Kind::Area:
      return length + "²";
    case DimensionSpec::Kind::Volume:
      return length + "³";
    case DimensionSpec::Kind::Mass:
      return "";
    default:
      return length;
  }
}

/// Distances of the samples of a target from the mesh, minus the offset, for samples beside which the
/// mesh has a point: not beyond its boundary, nor on another side.
void measure_back_into(DeformReport::Target& target, const TargetSurface& surface,
                       const TargetFollowerOptions& options, const TriangleMesh& mesh) {
  const TriangleTree tree(mesh);
  std::vector<char> at_boundary(static_cast<size_t>(mesh.vertex_count()), 0);
  for (const auto& loop : mesh.topology().boundary_loops())
    for (const int v : loop) at_boundary[v] = 1;
  double sum = 0;
  int count = 0;
  for (const TargetSurface::Nearest& sample : surface.samples()) {
    const auto found = tree.nearest(sample.at + options.offset * sample.normal);
    if (!found || found->distance > options.reach) continue;
    const auto& corners = mesh.triangles()[found->triangle];
    double inside = 1;  // sum of the weights of corners that are not at the boundary
    for (size_t k = 0; k < 3; ++k)
      if (at_boundary[corners[k]]) inside -= found->weights[static_cast<long>(k)];
    constexpr double cosine = 0.5, at_edge = 1e-9;
    const Vec3 normal = mesh.area_vector(found->triangle).normalized();
    if (inside < at_edge || std::abs(normal.dot(sample.normal)) < cosine) continue;
    ++count;
    sum += found->distance * found->distance;
    target.back_largest = std::max(target.back_largest, found->distance);
  }
  if (count > 0) target.back_rms = std::sqrt(sum / count);
}

void measure_targets_into(DeformReport& report, const MorphSolver& solver) {
  const TriangleMesh after = solver.mesh().with_points(solver.shape());
  for (size_t k = 0; k < solver.shared().targets.size(); ++k) {
    const TargetFollower& follower = solver.shared().targets[k];
    const TargetDistance distance = follower.distance(solver.shape());
    DeformReport::Target target{solver.scene().targets[k].file.filename().string(),
                                distance.vertices,
                                distance.ignored,
                                distance.rms,
                                distance.largest,
                                0,
                                0,
                                follower.options().smoothing};
    measure_back_into(target, *solver.shared().surfaces[k], follower.options(), after);
    report.targets.push_back(target);
  }
}

void measure_dimensions_into(DeformReport& report, const MorphSolver& solver,
                             const std::vector<MeshDimension>& dimensions) {
  for (const MeshDimension& d : dimensions) {
    report.dimensions.push_back({d.name(),
                                 dimension_type(d.kind()),
                                 d.value(solver.mesh().points()),
                                 d.value(solver.shape()),
                                 dimension_unit(d.kind(), report.unit),
                                 {}});
    for (const RequirementSpec& rule : solver.scene().requirements)
      if (rule.dimension.text == d.name())
        report.dimensions.back().required.push_back(condition_text(rule));
  }
}

}  // namespace

void measure_morph(DeformReport& report, const MeshFile& file, const MorphSolver& solver,
                   const std::vector<MeshDimension>& dimensions) {
  report.parameters = solver.scene().parameters();
  for (const auto& edit : solver.edits())
    report.edits.push_back({edit->rule().name, edit->statistics()});
  measure_into(report, file, solver.mesh(), solver.shape(), solver.shared());
  measure_attached_into(report, file, solver.attached(), solver.mesh().points(), solver.shape());
  measure_dimensions_into(report, solver, dimensions);
  measure_targets_into(report, solver);
}

void warn_left_behind(DeformReport& report, const MeshFile& file, const MorphSolver& solver) {
  note_left_behind(report, file, solver.mesh(), solver.scene().following, solver.mesh().points(),
                   solver.shape());
}

std::vector<FailedCheck> failed_checks(const DeformReport& report, const MorphSolver& solver,
                                       const std::vector<MeshDimension>& dimensions) {
  std::vector<FailedCheck> failed = failed_checks(report);
  const std::vector<FailedCheck> unmet =
      unmet_requirements(solver.scene(), dimensions, solver.mesh(), solver.shape());
  failed.insert(failed.end(), unmet.begin(), unmet.end());
  return failed;
}

}  // namespace batten
