// Embeds holes and inner lines on a surface that is there already.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/core/words.h"
#include "batten/fem/surface_projector.h"
#include "batten/skinning/domains/crossing.h"
#include "batten/skinning/domains/domain_task.h"

namespace batten {
namespace {

// The same way in the plane, travelled as fast as the curve is long: nearest points crowd where the
// curve bulges away from the surface, and the surface between two such lines would sag.
HermiteCurve as_even_as(const HermiteCurve& curve, const HermiteCurve& image) {
  constexpr int samples = 32;  // a segment
  std::vector<double> t{image.start()}, way{0}, length{0};
  for (int s = 0; s < curve.segment_count(); ++s)
    for (int k = 0; k < samples; ++k) {
      const double from = curve.parameters()[s], h = curve.mesh().length(s);
      const CurveMesh::Where middle{s, (k + 0.5) / samples};
      t.push_back(from + h * (k + 1) / samples);
      way.push_back(way.back() + h / samples * image.evaluate(middle, 1).norm());
      length.push_back(length.back() + h / samples * curve.evaluate(middle, 1).norm());
    }
  const double scale = way.back() / length.back();
  Points dofs(image.dofs().rows(), 3);
  for (int i = 0; i < image.node_count(); ++i) {
    // Where the way has the share that the node has of the curve.
    const double target = scale * length[samples * i];
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

// The same curve with nodes at most an element apart.
HermiteCurve with_close_nodes(const HermiteCurve& curve, double edge) {
  std::vector<double> between;
  const auto& u = curve.parameters();
  for (size_t i = 0; i + 1 < u.size(); ++i) {
    const double length = (u[i + 1] - u[i]) * curve.evaluate({static_cast<int>(i), 0.5}, 1).norm();
    const int cuts = static_cast<int>(std::ceil(length / edge));
    for (int k = 1; k < cuts; ++k) between.push_back(u[i] + (u[i + 1] - u[i]) * k / cuts);
  }
  return curve.with_nodes(between);
}

class Embedder {
 public:
  Embedder(const Surface& surface, const DomainTask& task, RegionParts& parts)
      : surface_(surface), projector_(surface), task_(task), parts_(parts) {}

  /// Clockwise in the domain.
  void hole(const Outline& hole) {
    for (const auto& piece : hole.pieces)
      if (piece.stretch.treatment == CharacterLine::Treatment::Fitted)
        throw InputError("line '" + piece.stretch.name +
                         "' cannot be fitted: lines around holes are embedded");
    const size_t first = parts_.embedded.size();
    auto [pieces, area] = loop(hole);
    if (area > 0) {
      parts_.embedded.resize(first);
      pieces = loop(reversed(hole)).first;
    }
    parts_.boundary.push_back(std::move(pieces));
  }

  /// `evenly`: as fast as the curve is long.
  void line(EmbeddedLine line, bool evenly) {
    const HermiteCurve nodes = with_close_nodes(line.fitted, task_.edge);
    line.image = nearest(line, nodes);
    if (evenly) line.image = as_even_as(nodes, line.image);
    parts_.embedded.push_back(std::move(line));
  }

 private:
  // The boundary pieces of a loop, and the area that its image encloses.
  std::pair<std::vector<BoundaryPiece>, double> loop(const Outline& hole) {
    const size_t first = parts_.embedded.size();
    DomainLoops::Loop images;
    std::vector<BoundaryPiece> pieces;
    for (EmbeddedLine& piece : embedded_loop(hole, task_)) {
      pieces.push_back({BoundaryPiece::Kind::Embedded, count_of(parts_.embedded)});
      line(std::move(piece), false);
      images.push_back(parts_.embedded.back().image);
    }
    // Each piece begins where the one before it ends, to the last bit.
    for (size_t k = 0; k < images.size() && images.size() > 1; ++k) {
      EmbeddedLine& piece = parts_.embedded[first + k];
      const HermiteCurve& before =
          parts_.embedded[first + (k + images.size() - 1) % images.size()].image;
      Points dofs = piece.image.dofs();
      dofs.row(piece.image.mesh().position_dof(0)) = before.position(before.node_count() - 1);
      piece.image = {piece.image.mesh(), dofs};
      images[k] = piece.image;
    }
    const double area = DomainLoops({images}).area();
    return {std::move(pieces), area};
  }

  // The nearest points of the surface at the nodes; slopes by the surface's gradient.
  HermiteCurve nearest(const EmbeddedLine& line, const HermiteCurve& nodes) const {
    Points dofs(nodes.dofs().rows(), 3);
    const double span = nodes.end() - nodes.start();
    std::optional<Surface::Closest> before;
    for (int i = 0; i < nodes.node_count(); ++i) {
      const Vec3 x = nodes.position(i);
      const Surface::Closest closest =
          before ? projector_.nearest(x, before->where) : surface_.closest_point(x);
      before = closest;
      constexpr double far = 0.5;
      if (closest.distance > far * task_.size)
        throw InputError("line '" + line.line.name + "' is " + number(closest.distance) +
                         " away from the surface that the outline makes (the region's size is " +
                         number(task_.size) + ")");
      const SurfaceJet jet = surface_.jet(closest.where);
      const Vec2 uv = surface_.mesh().shape(closest.where.triangle).point(closest.where.L);
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
    return {nodes.mesh(), dofs};
  }

  const Surface& surface_;
  const SurfaceProjector projector_;
  const DomainTask& task_;
  RegionParts& parts_;
};

// Of the lines to be embedded: whether each crosses no other inner line.
std::vector<char> alone(const std::vector<Stretch>& inner, const RegionParts& parts,
                        double distance) {
  std::vector<BoxedCurve> others;
  for (const Stretch& s : inner) others.emplace_back(*s.curve);
  for (const EmbeddedLine& line : parts.embedded)
    if (line.line.role == CharacterLine::Role::Inner) others.emplace_back(*line.line.curve);
  for (const LineRun& run : parts.runs)
    if (run.line.role == CharacterLine::Role::Inner) others.emplace_back(*run.line.curve);
  std::vector<char> found(inner.size(), 1);
  for (size_t i = 0; i < inner.size(); ++i)
    for (size_t j = 0; j < others.size() && found[i]; ++j)
      found[i] = j == i || !others[i].crossing(others[j], distance, {}, 0).found;
  return found;
}

}  // namespace

void embed_on(const Surface& surface, const std::vector<Outline>& holes,
              const std::vector<Stretch>& inner, const DomainTask& task, RegionParts& parts) {
  // Where lines cross, nearest points keep them together.
  const std::vector<char> evenly = alone(inner, parts, 10 * task.join);
  Embedder embedder(surface, task, parts);
  for (const Outline& hole : holes) embedder.hole(hole);
  for (size_t i = 0; i < inner.size(); ++i)
    embedder.line(embedded_inner(inner[i], task), evenly[i]);
}

}  // namespace batten
