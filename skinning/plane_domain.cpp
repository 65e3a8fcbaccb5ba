#include <algorithm>
#include <cmath>
#include <optional>

#include "batten/core/errors.h"
#include "batten/core/plane.h"
#include "batten/core/words.h"
#include "batten/fairing/curve_fit.h"
#include "batten/fem/surface_projector.h"
#include "batten/skinning/region_parts.h"

namespace batten {
namespace {

// Of lines in an embedding: fit and gap share the tolerance.
constexpr double kFitShare = 0.25;

FitOptions fit_options(const DomainTask& task, bool closed) {
  FitOptions fit;
  fit.tolerance = kFitShare * task.tolerance;
  fit.corner_angle = 180;
  fit.closed = closed;
  fit.even = true;
  return fit;
}

HermiteCurve fitted_open(const Stretch& s, const Joint& start, const Joint& end,
                         const DomainTask& task) {
  if (s.given) return s.given->curve;
  if (const auto exact = kept_as_given(s, 0, start.position, end.position)) return *exact;
  FitOptions fit = fit_options(task, false);
  fit.start = {start.position, start.outgoing};
  fit.end = {end.position, end.incoming};
  return fit_curve(s.name, s.curve, fit);
}

// A curve that comes back to its start, without an end.
HermiteCurve closed(const HermiteCurve& curve) {
  if (curve.closed()) return curve;
  const long last = 2 * (curve.node_count() - 1);
  return {CurveMesh(curve.parameters(), true), curve.dofs().topRows(last)};
}

HermiteCurve fitted_closed(const Stretch& s, const DomainTask& task) {
  if (s.given && s.given->curve.segment_count() > 1) return closed(s.given->curve);
  const FitOptions fit = fit_options(task, true);
  if (const auto exact = exact_curve(*s.curve, fit.corner_angle); exact && exact->closed())
    return *exact;
  return fit_curve(s.name, s.curve, fit);
}

bool closes(const Stretch& s, double join) {
  const InputCurve& c = *s.curve;
  return (c.evaluate(c.start()) - c.evaluate(c.end())).norm() <= join;
}

bool smooth_at_seam(const Stretch& s, double corner_angle) {
  const InputCurve& c = *s.curve;
  return degrees_between(c.evaluate(c.end(), 1), c.evaluate(c.start(), 1)) <= corner_angle;
}

}  // namespace

std::vector<EmbeddedLine> embedded_loop(const Outline& loop, const DomainTask& task) {
  std::vector<EmbeddedLine> lines;
  const size_t n = loop.pieces.size();
  for (size_t p = 0; p < n; ++p) {
    const auto& piece = loop.pieces[p];
    EmbeddedLine line;
    line.line = piece.stretch.line(false);
    line.fitted = n == 1 && loop.corners.empty() ? fitted_closed(piece.stretch, task)
                                                 : fitted_open(piece.stretch, joint_at(loop, p),
                                                               joint_at(loop, (p + 1) % n), task);
    if (piece.stretch.given && piece.flipped) line.fitted = line.fitted.backwards();
    lines.push_back(std::move(line));
  }
  return lines;
}

namespace {

EmbeddedLine embedded_inner(const Stretch& s, const DomainTask& task) {
  const InputCurve& c = *s.curve;
  EmbeddedLine line;
  line.line = s.line(false);
  if (closes(s, task.join) && smooth_at_seam(s, task.options.corner_angle)) {
    line.fitted = fitted_closed(s, task);
    return line;
  }
  Vec3 start = c.evaluate(c.start()), end = c.evaluate(c.end());
  if (closes(s, task.join)) start = end = 0.5 * (start + end);
  const Vec3 t0 = c.evaluate(c.start(), 1).normalized(), t1 = c.evaluate(c.end(), 1).normalized();
  line.fitted = fitted_open(s, {start, t0, t0}, {end, t1, t1}, task);
  return line;
}

// The plane of the outline: (u, v) of points and of directions, scaled and rounded.
struct Plane {
  Vec3 middle, e1, e2;
  double size;

  Plane(const Outline& loop, double region_size) : size(region_size) {
    const Vec3 n = loop_normal(loop);
    const Vec3 axis = std::abs(n.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY();
    e1 = (axis - axis.dot(n) * n).normalized();
    e2 = n.cross(e1);
    middle.setZero();
    double length = 0;
    for (const auto& piece : loop.pieces) {
      constexpr int samples = 32;
      const InputCurve& c = *piece.stretch.curve;
      for (int i = 0; i < samples; ++i)
        middle += piece.length / samples *
                  c.evaluate(c.start() + (c.end() - c.start()) * (i + 0.5) / samples);
      length += piece.length;
    }
    middle /= length;
  }

  HermiteCurve image(const HermiteCurve& curve) const {
    Points dofs = curve.dofs();
    const double span = curve.end() - curve.start();
    std::vector<char> is_position(static_cast<size_t>(dofs.rows()), 0);
    for (int i = 0; i < curve.node_count(); ++i)
      is_position[static_cast<size_t>(curve.mesh().position_dof(i))] = 1;
    for (long r = 0; r < dofs.rows(); ++r) {
      Vec3 x = dofs.row(r);
      if (is_position[static_cast<size_t>(r)]) {
        x -= middle;
        dofs.row(r) << rounded(e1.dot(x) / size), rounded(e2.dot(x) / size), 0;
      } else {
        dofs.row(r) << rounded_slope({e1.dot(x) / size, e2.dot(x) / size, 0}, span).transpose();
      }
    }
    return {curve.mesh(), dofs};
  }
};

// Where the line is so steep against the plane that its image hardly moves.
void require_flat_enough(const EmbeddedLine& line, double size) {
  constexpr double least = 0.1;
  constexpr int samples = 16;
  for (int s = 0; s < line.fitted.segment_count(); ++s)
    for (int k = 0; k < samples; ++k) {
      const CurveMesh::Where at_sample{s, (k + 0.5) / samples};
      const double in_space = line.fitted.evaluate(at_sample, 1).norm(),
                   in_plane = size * line.image.evaluate(at_sample, 1).norm();
      if (!(in_plane >= least * in_space))
        throw InputError("line '" + line.line.name +
                         "' is nearly at right angles to the plane of "
                         "the outline near " +
                         at(line.fitted.evaluate(at_sample)) +
                         ": it has no image there (a polygon or a ring might suit: give the "
                         "outline corners, or two loops)");
    }
}

}  // namespace

RegionParts plane_parts(const Outline& loop, const std::vector<Outline>& holes,
                        const std::vector<Stretch>& inner, const DomainTask& task) {
  RegionParts parts;
  const Plane plane(loop, task.size);
  warn_of_smoothed_joints(loop, task.options.corner_angle, parts.warnings);

  const auto add = [&](EmbeddedLine line) {
    if (line.line.treatment == CharacterLine::Treatment::Fitted)
      throw InputError("line '" + line.line.name +
                       "' cannot be fitted: the domain is a plane, where lines are embedded");
    line.image = plane.image(line.fitted);
    require_flat_enough(line, task.size);
    parts.embedded.push_back(std::move(line));
  };
  const auto add_loop = [&](const Outline& l) {
    std::vector<BoundaryPiece> pieces;
    for (EmbeddedLine& line : embedded_loop(l, task)) {
      pieces.push_back({BoundaryPiece::Kind::Embedded, static_cast<int>(parts.embedded.size())});
      add(std::move(line));
    }
    parts.boundary.push_back(pieces);
  };
  add_loop(loop);
  for (const Outline& hole : holes) {
    // Clockwise in the plane.
    std::vector<EmbeddedLine> lines = embedded_loop(hole, task);
    DomainLoops::Loop images;
    for (const EmbeddedLine& line : lines) images.push_back(plane.image(line.fitted));
    add_loop(DomainLoops({images}).area() > 0 ? reversed(hole) : hole);
  }
  for (const Stretch& s : inner) add(embedded_inner(s, task));

  const size_t n = loop.pieces.size();
  for (const int c : loop.corners) {
    const auto i = static_cast<size_t>(c);
    const HermiteCurve &in = parts.embedded[(i + n - 1) % n].image, &out = parts.embedded[i].image;
    const Vec3 a = in.slope_in(in.node_count() - 1), b = out.slope_out(0), x = out.position(0);
    const double turn = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
    const Joint joint = joint_at(loop, i);
    const double in_space = degrees_between(joint.incoming, joint.outgoing);
    constexpr double degrees = 180 / 3.14159265358979323846;
    parts.corners.push_back(
        {Vec2(x.x(), x.y()), 180 - turn * degrees, turn >= 0 ? 180 - in_space : 180 + in_space});
  }

  DomainLoops::Loop outline;
  for (const BoundaryPiece& piece : parts.boundary[0])
    outline.push_back(parts.embedded[static_cast<size_t>(piece.index)].image);
  parts.mesh = squares_over(DomainLoops({outline}), task);
  return parts;
}

bool projects_simply(const Outline& loop, const DomainTask& task) {
  if (!encloses_area(loop)) return false;
  const Plane plane(loop, task.size);
  const auto flat = [&](const Vec3& x) { return Vec2(plane.e1.dot(x), plane.e2.dot(x)); };
  constexpr int samples = 48;
  constexpr double least = 0.1;
  std::vector<Vec2> polygon;
  for (const auto& piece : loop.pieces) {
    const InputCurve& c = *piece.stretch.curve;
    for (int i = 0; i < samples; ++i) {
      const double step = (c.end() - c.start()) / samples;
      const Vec3 slope = c.evaluate(c.start() + (i + 0.5) * step, 1);
      if (!(flat(slope).norm() >= least * slope.norm())) return false;
      polygon.push_back(flat(c.evaluate(c.start() + i * step)));
    }
  }
  for (const int c : loop.corners) {
    const Joint joint = joint_at(loop, static_cast<size_t>(c));
    const Vec2 in = flat(joint.incoming).normalized(), out = flat(joint.outgoing).normalized();
    const double in_space = joint.incoming.cross(joint.outgoing).norm(),
                 in_plane = std::abs(cross(in, out));
    if (in_space < least * in_plane || in_plane < least * in_space) return false;
  }
  return simple_and_ccw(polygon);
}

std::shared_ptr<const ParametricMesh> squares_over(const DomainLoops& outside,
                                                   const DomainTask& task) {
  const double h = rounded(task.edge / task.size);
  const Vec2 extent = outside.high() - outside.low();
  const double expected = 2 * extent.x() * extent.y() / (h * h);
  constexpr double most_triangles = 2e6;
  if (expected > most_triangles)
    throw InputError("edge_length = " + number(task.edge) + " on a region of size " +
                     number(task.size) + " means about " + number(expected) +
                     " triangles; at most " + number(most_triangles) +
                     " are allowed (is the unit right?)");
  const int columns = static_cast<int>(std::ceil(extent.x() / h)) + 2,
            rows = static_cast<int>(std::ceil(extent.y() / h)) + 2;
  const Vec2 origin =
      rounded(Vec2(0.5 * (outside.low() + outside.high()) - 0.5 * h * Vec2(columns, rows)));
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

namespace {

// The same way in the plane, travelled as fast as the curve is long: nearest points crowd where the
// curve bulges away from the surface, and the surface between two such lines would sag.
HermiteCurve as_even_as(const HermiteCurve& curve, const HermiteCurve& image) {
  constexpr int samples = 32;  // a segment
  std::vector<double> t{image.start()}, way{0}, length{0};
  for (int s = 0; s < curve.segment_count(); ++s)
    for (int k = 0; k < samples; ++k) {
      const double from = curve.parameters()[static_cast<size_t>(s)], h = curve.mesh().length(s);
      const CurveMesh::Where middle{s, (k + 0.5) / samples};
      t.push_back(from + h * (k + 1) / samples);
      way.push_back(way.back() + h / samples * image.evaluate(middle, 1).norm());
      length.push_back(length.back() + h / samples * curve.evaluate(middle, 1).norm());
    }
  const double scale = way.back() / length.back();
  Points dofs(image.dofs().rows(), 3);
  for (int i = 0; i < image.node_count(); ++i) {
    // Where the way has the share that the node has of the curve.
    const double target = scale * length[static_cast<size_t>(samples * i)];
    const auto above = std::upper_bound(way.begin(), way.end(), target);
    const auto k = static_cast<size_t>(
        std::clamp<long>(above - way.begin(), 1, static_cast<long>(way.size()) - 1));
    const double part =
        std::clamp((target - way[k - 1]) / std::max(way[k] - way[k - 1], 1e-300), 0.0, 1.0);
    const double at = i + 1 == image.node_count() && !image.closed()
                          ? image.end()
                          : t[k - 1] + part * (t[k] - t[k - 1]);
    const Vec3 c = image.evaluate(at), direction = image.evaluate(at, 1).normalized();
    const double span = curve.end() - curve.start();
    dofs.row(image.mesh().position_dof(i)) = rounded(c);
    dofs.row(image.mesh().slope_in(i)) =
        rounded_slope(scale * curve.slope_in(i).norm() * direction, span);
    dofs.row(image.mesh().slope_out(i)) =
        rounded_slope(scale * curve.slope_out(i).norm() * direction, span);
  }
  return {image.mesh(), dofs};
}

}  // namespace

void embed_on(const Surface& surface, const std::vector<Outline>& holes,
              const std::vector<Stretch>& inner, const DomainTask& task, RegionParts& parts) {
  const SurfaceProjector projector(surface);
  const auto add = [&](EmbeddedLine line, bool evenly) {
    // Nodes at the curve's own and at most an element apart; slopes by the surface's gradient.
    std::vector<double> between;
    const auto& u = line.fitted.parameters();
    for (size_t i = 0; i + 1 < u.size(); ++i) {
      const double length =
          (u[i + 1] - u[i]) * line.fitted.evaluate({static_cast<int>(i), 0.5}, 1).norm();
      const int cuts = static_cast<int>(std::ceil(length / task.edge));
      for (int k = 1; k < cuts; ++k) between.push_back(u[i] + (u[i + 1] - u[i]) * k / cuts);
    }
    const HermiteCurve nodes = line.fitted.with_nodes(between);
    Points dofs(nodes.dofs().rows(), 3);
    const double span = nodes.end() - nodes.start();
    std::optional<Surface::Closest> before;
    for (int i = 0; i < nodes.node_count(); ++i) {
      const Vec3 x = nodes.position(i);
      const Surface::Closest closest =
          before ? projector.nearest(x, before->where) : surface.closest_point(x);
      before = closest;
      constexpr double far = 0.5;
      if (closest.distance > far * task.size)
        throw InputError("line '" + line.line.name + "' is " + number(closest.distance) +
                         " away from the surface that the outline makes (the region's size is " +
                         number(task.size) + ")");
      const SurfaceJet jet = surface.jet(closest.where);
      const Vec2 uv = surface.mesh().shape(closest.where.triangle).point(closest.where.L);
      Eigen::Matrix<double, 3, 2> J;
      J << jet.x_u, jet.x_v;
      const auto pull = [&](const Vec3& slope) -> Vec3 {
        const Vec2 d = (J.transpose() * J).ldlt().solve(J.transpose() * slope);
        return rounded_slope({d.x(), d.y(), 0}, span);
      };
      dofs.row(nodes.mesh().position_dof(i)) << rounded(uv.x()), rounded(uv.y()), 0;
      dofs.row(nodes.mesh().slope_in(i)) = pull(nodes.slope_in(i));
      dofs.row(nodes.mesh().slope_out(i)) = pull(nodes.slope_out(i));
    }
    line.image = {nodes.mesh(), dofs};
    if (evenly) line.image = as_even_as(nodes, line.image);
    parts.embedded.push_back(std::move(line));
  };
  for (const Outline& hole : holes) {
    for (const auto& piece : hole.pieces)
      if (piece.stretch.treatment == CharacterLine::Treatment::Fitted)
        throw InputError("line '" + piece.stretch.name +
                         "' cannot be fitted: lines around holes are embedded");
    for (const bool turned : {false, true}) {
      const size_t first = parts.embedded.size();
      DomainLoops::Loop images;
      std::vector<BoundaryPiece> pieces;
      for (EmbeddedLine& line : embedded_loop(turned ? reversed(hole) : hole, task)) {
        pieces.push_back({BoundaryPiece::Kind::Embedded, static_cast<int>(parts.embedded.size())});
        add(std::move(line), false);
        images.push_back(parts.embedded.back().image);
      }
      // Each piece begins where the one before it ends, to the last bit.
      for (size_t k = 0; k < images.size() && images.size() > 1; ++k) {
        EmbeddedLine& line = parts.embedded[first + k];
        const HermiteCurve& before =
            parts.embedded[first + (k + images.size() - 1) % images.size()].image;
        Points dofs = line.image.dofs();
        dofs.row(line.image.mesh().position_dof(0)) = before.position(before.node_count() - 1);
        line.image = {line.image.mesh(), dofs};
        images[k] = line.image;
      }
      if (DomainLoops({images}).area() > 0 && !turned) {
        parts.embedded.resize(first);
        continue;
      }
      parts.boundary.push_back(pieces);
      break;
    }
  }
  const size_t before_inner = parts.embedded.size();
  for (size_t i = 0; i < inner.size(); ++i) {
    // Where lines cross, nearest points keep them together.
    const InputCurve& curve = *inner[i].curve;
    bool alone = true;
    for (size_t j = 0; j < before_inner; ++j)
      if (const CharacterLine& other = parts.embedded[j].line;
          other.role == CharacterLine::Role::Inner)
        alone = alone && !find_crossing(curve, *other.curve, 10 * task.join, {}, 0).found;
    for (size_t j = 0; j < inner.size() && alone; ++j)
      alone = j == i || !find_crossing(curve, *inner[j].curve, 10 * task.join, {}, 0).found;
    for (const LineRun& run : parts.runs)
      if (run.line.role == CharacterLine::Role::Inner)
        alone = alone && !find_crossing(curve, *run.line.curve, 10 * task.join, {}, 0).found;
    add(embedded_inner(inner[i], task), alone);
  }
}

}  // namespace batten
