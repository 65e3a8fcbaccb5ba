// SPDX-License-Identifier: MPL-2.0
// Embeds holes and inner lines on an existing surface.

#include <algorithm>
#include <cmath>
#include <optional>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fem/surface_projector.h"
#include "batten/skinning/domains/domain_input.h"
#include "batten/skinning/domains/outline.h"

namespace batten {
namespace {

// Reparametrises a pcurve along its path in (u, v) in proportion to the arc length of the curve.
// Closest points cluster where the curve bulges away from the surface, and the surface between two
// such lines would sag.
HermiteCurve match_arc_length(const HermiteCurve& curve, const HermiteCurve& pcurve) {
  constexpr int samples = 32;  // per segment
  std::vector<double> t{pcurve.start()}, path_length{0}, length{0};
  for (int s = 0; s < curve.segment_count(); ++s)
    for (int k = 0; k < samples; ++k) {
      const double from = curve.parameters()[s], h = curve.mesh().length(s);
      const CurveMesh::SegmentPoint middle{s, (k + 0.5) / samples};
      t.push_back(from + h * (k + 1) / samples);
      path_length.push_back(path_length.back() + h / samples * pcurve.evaluate(middle, 1).norm());
      length.push_back(length.back() + h / samples * curve.evaluate(middle, 1).norm());
    }
  const double scale = path_length.back() / length.back();
  Points dofs(pcurve.dofs().rows(), 3);
  for (int i = 0; i < pcurve.node_count(); ++i) {
    // The parameter at which the path in (u, v) has the same fraction of length as the curve at
    // node i.
    const double target = scale * length[samples * i];
    const auto above = std::upper_bound(path_length.begin(), path_length.end(), target);
    const auto k = static_cast<size_t>(std::clamp<long>(above - path_length.begin(), 1,
                                                        static_cast<long>(path_length.size()) - 1));
    const double part = std::clamp(
        (target - path_length[k - 1]) / std::max(path_length[k] - path_length[k - 1], 1e-300), 0.0,
        1.0);
    const double at = i + 1 == pcurve.node_count() && !pcurve.closed()
                          ? pcurve.end()
                          : t[k - 1] + part * (t[k] - t[k - 1]);
    const Vec3 c = pcurve.evaluate(at), direction = pcurve.evaluate(at, 1).normalized();
    const double span = curve.end() - curve.start();
    dofs.row(pcurve.mesh().position_dof(i)) = round_to_grid(c);
    dofs.row(pcurve.mesh().slope_in(i)) =
        round_slope_to_grid(scale * curve.slope_in(i).norm() * direction, span);
    dofs.row(pcurve.mesh().slope_out(i)) =
        round_slope_to_grid(scale * curve.slope_out(i).norm() * direction, span);
  }
  return {pcurve.mesh(), dofs};
}

// The same curve with nodes at most one element apart.
HermiteCurve with_close_nodes(const HermiteCurve& curve, double edge_length) {
  std::vector<double> between;
  const auto& u = curve.parameters();
  for (size_t i = 0; i + 1 < u.size(); ++i) {
    const double length = (u[i + 1] - u[i]) * curve.evaluate({static_cast<int>(i), 0.5}, 1).norm();
    const int cuts = static_cast<int>(std::ceil(length / edge_length));
    for (int k = 1; k < cuts; ++k) between.push_back(u[i] + (u[i + 1] - u[i]) * k / cuts);
  }
  return curve.with_nodes(between);
}

class Embedder {
 public:
  Embedder(const Surface& surface, const DomainInput& task, RegionGeometry& geometry)
      : surface_(surface), projector_(surface), task_(task), geometry_(geometry) {}

  /// Adds a hole, clockwise in the domain.
  void hole(const Outline& hole) {
    for (const auto& piece : hole.segments)
      if (piece.segment.mesh_alignment == CharacterLine::MeshAlignment::EdgeAligned)
        throw InputError("curve '" + piece.segment.name +
                         "' has alignment = \"aligned\", but curves around holes are always "
                         "embedded");
    const size_t first = geometry_.embedded.size();
    auto [segments, area] = loop(hole);
    if (area > 0) {
      geometry_.embedded.resize(first);
      segments = loop(reversed(hole)).first;
    }
    geometry_.boundary.push_back(std::move(segments));
  }

  /// Adds a line. `evenly`: its pcurve is proportional to the curve's arc length.
  void line(EmbeddedLine line, bool evenly) {
    const HermiteCurve nodes = with_close_nodes(line.fitted, task_.options.edge_length);
    line.pcurve = nearest(line, nodes);
    if (evenly) line.pcurve = match_arc_length(nodes, line.pcurve);
    geometry_.embedded.push_back(std::move(line));
  }

 private:
  // Adds the lines of a loop. Returns its boundary segments, and the signed area that its pcurves
  // enclose.
  std::pair<std::vector<BoundarySegment>, double> loop(const Outline& hole) {
    const size_t first = geometry_.embedded.size();
    DomainLoops::Loop pcurves;
    std::vector<BoundarySegment> segments;
    for (EmbeddedLine& piece : fit_loop_lines(hole, task_)) {
      segments.push_back({BoundarySegment::Kind::Embedded, isize(geometry_.embedded)});
      line(std::move(piece), false);
      pcurves.push_back(geometry_.embedded.back().pcurve);
    }
    // Each pcurve begins exactly (bitwise) where the one before it ends.
    for (size_t k = 0; k < pcurves.size() && pcurves.size() > 1; ++k) {
      EmbeddedLine& piece = geometry_.embedded[first + k];
      const HermiteCurve& before =
          geometry_.embedded[first + (k + pcurves.size() - 1) % pcurves.size()].pcurve;
      Points dofs = piece.pcurve.dofs();
      dofs.row(piece.pcurve.mesh().position_dof(0)) = before.position(before.node_count() - 1);
      piece.pcurve = {piece.pcurve.mesh(), dofs};
      pcurves[k] = piece.pcurve;
    }
    const double area = DomainLoops({pcurves}).area();
    return {std::move(segments), area};
  }

  // Pcurve through the closest points of the surface at the nodes. Its slopes follow from the
  // surface's first derivatives by least squares.
  HermiteCurve nearest(const EmbeddedLine& line, const HermiteCurve& nodes) const {
    Points dofs(nodes.dofs().rows(), 3);
    const double span = nodes.end() - nodes.start();
    std::optional<Surface::ClosestPoint> before;
    for (int i = 0; i < nodes.node_count(); ++i) {
      const Vec3 x = nodes.position(i);
      const Surface::ClosestPoint closest =
          before ? projector_.nearest(x, before->where) : surface_.closest_point(x);
      before = closest;
      constexpr double far = 0.5;
      if (closest.distance > far * task_.size)
        throw InputError("curve '" + line.line.name + "' is " + format_number(closest.distance) +
                         " away from the face, expected at most half of the face's size, " +
                         format_number(far * task_.size));
      const SurfaceJet jet = surface_.jet(closest.where);
      const Vec2 uv = surface_.mesh().shape(closest.where.triangle).point(closest.where.L);
      Eigen::Matrix<double, 3, 2> J;
      J << jet.x_u, jet.x_v;
      const auto pull = [&](const Vec3& slope) -> Vec3 {
        const Vec2 d = solve_symmetric_2x2(J.transpose() * J, J.transpose() * slope);
        return round_slope_to_grid({d.x(), d.y(), 0}, span);
      };
      dofs.row(nodes.mesh().position_dof(i)) << round_to_grid(uv.x()), round_to_grid(uv.y()), 0;
      dofs.row(nodes.mesh().slope_in(i)) = pull(nodes.slope_in(i));
      dofs.row(nodes.mesh().slope_out(i)) = pull(nodes.slope_out(i));
    }
    return {nodes.mesh(), dofs};
  }

  const Surface& surface_;
  const SurfaceProjector projector_;
  const DomainInput& task_;
  RegionGeometry& geometry_;
};

// One flag per line to be embedded: 1 if it crosses no other inner line.
std::vector<char> crosses_no_other(const std::vector<SmoothSegment>& inner,
                                   const RegionGeometry& geometry, double distance) {
  std::vector<BoxedCurve> others;
  for (const SmoothSegment& s : inner) others.emplace_back(*s.curve);
  for (const EmbeddedLine& line : geometry.embedded)
    if (line.line.role == CharacterLine::Role::Inner) others.emplace_back(*line.line.curve);
  for (const EdgeAlignedLine& aligned_line : geometry.edge_aligned)
    if (aligned_line.line.role == CharacterLine::Role::Inner)
      others.emplace_back(*aligned_line.line.curve);
  std::vector<char> found(inner.size(), 1);
  for (size_t i = 0; i < inner.size(); ++i)
    for (size_t j = 0; j < others.size() && found[i]; ++j)
      found[i] = j == i || !others[i].crossing(others[j], distance, {}, 0).found;
  return found;
}

}  // namespace

void embed_on_surface(const Surface& surface, const std::vector<Outline>& holes,
                      const std::vector<SmoothSegment>& inner, const DomainInput& task,
                      RegionGeometry& geometry) {
  // Lines that cross others keep the plain closest points, so that they meet in the domain too.
  const std::vector<char> evenly = crosses_no_other(inner, geometry, 10 * task.gap_tolerance);
  Embedder embedder(surface, task, geometry);
  for (const Outline& hole : holes) embedder.hole(hole);
  for (size_t i = 0; i < inner.size(); ++i)
    embedder.line(fit_inner_line(inner[i], task), evenly[i]);
}

// Curves fitted to lines that are embedded.

namespace {

// Fraction of the tolerance for fitting an embedded line; the rest is for the gap of the surface.
constexpr double kFitToleranceFraction = 0.25;

FitOptions fit_options(const DomainInput& task, bool closed) {
  FitOptions fit;
  fit.tolerance = kFitToleranceFraction * task.options.tolerance;
  fit.corner_angle = 180;
  fit.closed = closed;
  fit.fixed_parameters = true;
  return fit;
}

HermiteCurve fitted_open(const SmoothSegment& s, const LoopVertex& start, const LoopVertex& end,
                         const DomainInput& task) {
  if (s.prescribed) return s.prescribed->curve;
  if (const auto exact = reuse_cubic_input(s, 0, start.position, end.position)) return *exact;
  FitOptions fit = fit_options(task, false);
  fit.start = {start.position, start.outgoing};
  fit.end = {end.position, end.incoming};
  return fit_curve(s.name, s.curve, fit);
}

HermiteCurve fitted_closed(const SmoothSegment& s, const DomainInput& task) {
  if (s.prescribed && s.prescribed->curve.segment_count() > 1)
    return as_closed_curve(s.prescribed->curve);
  const FitOptions fit = fit_options(task, true);
  if (const auto exact = exact_curve(*s.curve, fit.corner_angle); exact && exact->closed())
    return *exact;
  return fit_curve(s.name, s.curve, fit);
}

bool closes(const SmoothSegment& s, double gap_tolerance) {
  const InputCurve& c = *s.curve;
  return (c.evaluate(c.start()) - c.evaluate(c.end())).norm() <= gap_tolerance;
}

bool smooth_at_seam(const SmoothSegment& s, double corner_angle) {
  const InputCurve& c = *s.curve;
  return degrees_between(c.evaluate(c.end(), 1), c.evaluate(c.start(), 1)) <= corner_angle;
}

}  // namespace

std::vector<EmbeddedLine> fit_loop_lines(const Outline& loop, const DomainInput& task) {
  std::vector<EmbeddedLine> lines;
  const size_t n = loop.segments.size();
  for (size_t p = 0; p < n; ++p) {
    const auto& piece = loop.segments[p];
    EmbeddedLine line;
    line.line = piece.segment.line(false);
    line.fitted = n == 1 && loop.corners.empty()
                      ? fitted_closed(piece.segment, task)
                      : fitted_open(piece.segment, loop_vertex_at(loop, p),
                                    loop_vertex_at(loop, (p + 1) % n), task);
    if (piece.segment.prescribed && piece.flipped) line.fitted = line.fitted.backwards();
    lines.push_back(std::move(line));
  }
  return lines;
}

EmbeddedLine fit_inner_line(const SmoothSegment& s, const DomainInput& task) {
  const InputCurve& c = *s.curve;
  EmbeddedLine line;
  line.line = s.line(false);
  if (closes(s, task.gap_tolerance) && smooth_at_seam(s, task.options.corner_angle)) {
    line.fitted = fitted_closed(s, task);
    return line;
  }
  Vec3 start = c.evaluate(c.start()), end = c.evaluate(c.end());
  if (closes(s, task.gap_tolerance)) start = end = 0.5 * (start + end);
  const Vec3 t0 = c.evaluate(c.start(), 1).normalized(), t1 = c.evaluate(c.end(), 1).normalized();
  line.fitted = fitted_open(s, {start, t0, t0}, {end, t1, t1}, task);
  return line;
}

}  // namespace batten
