// SPDX-License-Identifier: MPL-2.0
#include <cmath>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/skinning/domains/domain_input.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/domains/outline.h"
#include "batten/skinning/region/polygon_fit.h"

namespace batten {
namespace {

// The plane of the outline, with scaled and rounded (u, v) coordinates of points and directions.
struct ProjectionPlane {
  Vec3 middle, e1, e2;
  double size;

  ProjectionPlane(const Outline& loop, double region_size) : size(region_size) {
    const Vec3 n = loop_normal(loop);
    const Vec3 axis = std::abs(n.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
    e1 = (axis - axis.dot(n) * n).normalized();
    e2 = n.cross(e1);
    middle.setZero();
    double length = 0;
    for (const auto& piece : loop.segments) {
      constexpr int samples = 32;
      const InputCurve& c = *piece.segment.curve;
      for (int i = 0; i < samples; ++i)
        middle += piece.length / samples *
                  c.evaluate(c.start() + (c.end() - c.start()) * (i + 0.5) / samples);
      length += piece.length;
    }
    middle /= length;
  }

  HermiteCurve pcurve(const HermiteCurve& curve) const {
    Points dofs = curve.dofs();
    const double span = curve.end() - curve.start();
    std::vector<char> is_position(static_cast<size_t>(dofs.rows()), 0);
    for (int i = 0; i < curve.node_count(); ++i) is_position[curve.mesh().position_dof(i)] = 1;
    for (long r = 0; r < dofs.rows(); ++r) {
      Vec3 x = dofs.row(r);
      if (is_position[r]) {
        x -= middle;
        dofs.row(r) << round_to_grid(e1.dot(x) / size), round_to_grid(e2.dot(x) / size), 0;
      } else {
        dofs.row(r)
            << round_slope_to_grid({e1.dot(x) / size, e2.dot(x) / size, 0}, span).transpose();
      }
    }
    return {curve.mesh(), dofs};
  }
};

// Throws if the line is so steep against the plane that its pcurve is nearly stationary.
void require_flat_enough(const EmbeddedLine& line, double size) {
  constexpr double least = 0.1;
  constexpr int samples = 16;
  for (int s = 0; s < line.fitted.segment_count(); ++s)
    for (int k = 0; k < samples; ++k) {
      const CurveMesh::SegmentPoint at_sample{s, (k + 0.5) / samples};
      const double in_space = line.fitted.evaluate(at_sample, 1).norm(),
                   in_plane = size * line.pcurve.evaluate(at_sample, 1).norm();
      if (!(in_plane >= least * in_space))
        throw InputError("curve '" + line.line.name +
                         "' cannot be projected: it is nearly perpendicular to the plane of the "
                         "outline near " +
                         format_point(line.fitted.evaluate(at_sample)) +
                         "; use domain = \"polygon\" (needs corners) or \"annulus\" (needs two "
                         "loops)");
    }
}

}  // namespace

RegionGeometry make_projected_geometry(const Outline& loop, const std::vector<Outline>& holes,
                                       const std::vector<SmoothSegment>& inner,
                                       const DomainInput& task) {
  RegionGeometry geometry;
  const ProjectionPlane plane(loop, task.size);
  warn_about_rounded_kinks(loop, task.options.corner_angle, geometry.warnings);

  const auto add = [&](EmbeddedLine line) {
    if (line.line.mesh_alignment == CharacterLine::MeshAlignment::EdgeAligned)
      throw InputError("curve '" + line.line.name +
                       "' has alignment = \"aligned\", but curves of a projected domain are "
                       "always embedded");
    line.pcurve = plane.pcurve(line.fitted);
    require_flat_enough(line, task.size);
    geometry.embedded.push_back(std::move(line));
  };
  const auto add_loop = [&](const Outline& l) {
    std::vector<BoundarySegment> segments;
    for (EmbeddedLine& line : fit_loop_lines(l, task)) {
      segments.push_back({BoundarySegment::Kind::Embedded, isize(geometry.embedded)});
      add(std::move(line));
    }
    geometry.boundary.push_back(segments);
  };
  add_loop(loop);
  for (const Outline& hole : holes) {
    // Holes must be clockwise in the plane.
    std::vector<EmbeddedLine> lines = fit_loop_lines(hole, task);
    DomainLoops::Loop pcurves;
    for (const EmbeddedLine& line : lines) pcurves.push_back(plane.pcurve(line.fitted));
    add_loop(DomainLoops({pcurves}).area() > 0 ? reversed(hole) : hole);
  }
  for (const SmoothSegment& s : inner) add(fit_inner_line(s, task));

  const size_t n = loop.segments.size();
  for (const int c : loop.corners) {
    const auto i = static_cast<size_t>(c);
    const HermiteCurve &in = geometry.embedded[(i + n - 1) % n].pcurve,
                       &out = geometry.embedded[i].pcurve;
    const Vec3 a = in.slope_in(in.node_count() - 1), b = out.slope_out(0), x = out.position(0);
    const double turning_angle = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
    const LoopVertex vertex = loop_vertex_at(loop, i);
    const double in_space = degrees_between(vertex.incoming, vertex.outgoing);
    constexpr double degrees = 180 / 3.14159265358979323846;
    geometry.corners.push_back({Vec2(x.x(), x.y()), 180 - turning_angle * degrees,
                                turning_angle >= 0 ? 180 - in_space : 180 + in_space});
  }

  DomainLoops::Loop outline;
  for (const BoundarySegment& piece : geometry.boundary[0])
    outline.push_back(geometry.embedded[piece.index].pcurve);
  geometry.mesh = make_grid_mesh(DomainLoops({outline}), task);
  return geometry;
}

bool has_simple_projection(const Outline& loop, const DomainInput& task) {
  if (!encloses_area(loop)) return false;
  const ProjectionPlane plane(loop, task.size);
  const auto flat = [&](const Vec3& x) { return Vec2(plane.e1.dot(x), plane.e2.dot(x)); };
  constexpr int samples = 48;
  constexpr double least = 0.1;
  std::vector<Vec2> polygon;
  for (const auto& piece : loop.segments) {
    const InputCurve& c = *piece.segment.curve;
    for (int i = 0; i < samples; ++i) {
      const double step = (c.end() - c.start()) / samples;
      const Vec3 slope = c.evaluate(c.start() + (i + 0.5) * step, 1);
      if (!(flat(slope).norm() >= least * slope.norm())) return false;
      polygon.push_back(flat(c.evaluate(c.start() + i * step)));
    }
  }
  for (const int c : loop.corners) {
    const LoopVertex vertex = loop_vertex_at(loop, static_cast<size_t>(c));
    const Vec2 in = flat(vertex.incoming).normalized(), out = flat(vertex.outgoing).normalized();
    const double in_space = vertex.incoming.cross(vertex.outgoing).norm(),
                 in_plane = std::abs(cross(in, out));
    if (in_space < least * in_plane || in_plane < least * in_space) return false;
  }
  return is_simple_and_ccw(polygon);
}

std::shared_ptr<const ParametricMesh> make_grid_mesh(const DomainLoops& outside,
                                                     const DomainInput& task) {
  const double h = round_to_grid(task.options.edge_length / task.size);
  const Vec2 extent = outside.high() - outside.low();
  const double expected = 2 * extent.x() * extent.y() / (h * h);
  require_mesh_size(expected, task.options.edge_length, task.size, "a face");
  const int columns = static_cast<int>(std::ceil(extent.x() / h)) + 2,
            rows = static_cast<int>(std::ceil(extent.y() / h)) + 2;
  const Vec2 origin =
      round_to_grid(Vec2(0.5 * (outside.low() + outside.high()) - 0.5 * h * Vec2(columns, rows)));
  std::vector<Vec2> vertices;
  std::vector<ParametricMesh::Triangle> triangles;
  for (int j = 0; j <= rows; ++j)
    for (int i = 0; i <= columns; ++i) vertices.push_back(origin + h * Vec2(i, j));
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const int a = j * (columns + 1) + i, b = a + 1, c = a + columns + 1, d = c + 1;
      if ((i + j) % 2 == 0) {
        triangles.push_back({a, b, d});
        triangles.push_back({a, d, c});
      } else {
        triangles.push_back({a, b, c});
        triangles.push_back({b, d, c});
      }
    }
  return std::make_shared<ParametricMesh>(std::move(vertices), std::move(triangles));
}

}  // namespace batten
