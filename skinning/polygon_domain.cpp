#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>

#include "batten/core/errors.h"
#include "batten/core/plane.h"
#include "batten/core/words.h"
#include "batten/skinning/mesher.h"
#include "batten/skinning/region_parts.h"

namespace batten {
namespace {

// A piece of line on its straight stretch of the domain, from `from` to `to`; fractions run 0 … 1
// with the parameter of the fitted curve.
struct Strip {
  CharacterLine line;
  bool flipped = false;
  HermiteCurve fitted;
  Vec2 from, to;
  std::vector<double> nodes;  // fractions that must be mesh vertices, 0 and 1 included
  std::vector<int> points;    // of a given curve: its vertices in the mesh, by `nodes`
  bool given() const { return line.given != nullptr; }
  double fraction(double u) const { return (u - fitted.start()) / (fitted.end() - fitted.start()); }
  Vec2 at(double fraction) const { return from + fraction * (to - from); }
};

HermiteCurve stretched(const HermiteCurve& curve, double factor) {
  std::vector<double> u = curve.parameters();
  for (double& x : u) x *= factor;
  return {CurveMesh(u), curve.dofs()};
}

bool segments_cross(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  constexpr double margin = 1e-9;
  const double det = cross(b - a, d - c);
  if (std::abs(det) < 1e-14) return false;
  const double s = cross(c - a, d - c) / det, t = cross(c - a, b - a) / det;
  return s > margin && s < 1 - margin && t > margin && t < 1 - margin;
}

class PolygonBuilder {
 public:
  PolygonBuilder(const Outline& loop, const DomainTask& task)
      : options_(task.options),
        size_(task.size),
        tolerance_(task.tolerance),
        edge_(task.edge),
        join_(task.join),
        outline_(loop),
        given_(loop.pieces[0].stretch.given != nullptr) {}

  void build_outline(const std::vector<Vec2>* given, std::vector<std::string>& warnings) {
    // Decided first: the fan needs lines that are cut evenly.
    if (options_.mesher == SkinOptions::Mesher::Delaunay && !have_delaunay_mesher()) {
      warnings.push_back("this build has no CGAL: the fan mesher is used instead");
      options_.mesher = SkinOptions::Mesher::Fan;
    }
    const size_t sides = outline_.corners.size(), n = outline_.pieces.size();
    if (sides < 3)
      throw InputError("the outline has " + std::to_string(sides) +
                       " corner(s) that turn by more than " + number(options_.corner_angle) +
                       " degrees, and a polygon needs three or more");
    constexpr size_t most_corners = 100;
    if (sides > most_corners)
      throw InputError("the outline turns by more than " + number(options_.corner_angle) +
                       " degrees at " + std::to_string(sides) +
                       " places, and a region has at most " + std::to_string(most_corners) +
                       " corners: are the points noisy? (raise corner_angle, or smooth the line)");
    line_angles_ = corner_angles(outline_);
    // The polygon is fitted to rounded numbers of the region scaled to size 1.
    std::vector<double> lengths, scaled_lengths, angles;
    std::vector<Vec3> corners;
    const Vec3 origin = outline_.pieces[outline_.corners[0]].start;
    for (size_t c = 0; c < sides; ++c) {
      double length = 0;
      for (const size_t p : side(c)) length += outline_.pieces[p].length;
      lengths.push_back(length);
      scaled_lengths.push_back(rounded(length / size_));
      angles.push_back(rounded(line_angles_[c]));
      corners.push_back(
          rounded(Vec3((outline_.pieces[outline_.corners[c]].start - origin) / size_)));
    }
    const Vec3 normal = rounded(loop_normal(outline_));
    polygon_ = given ? *given : fit_polygon(scaled_lengths, angles, corners, normal);
    require_room(scaled_lengths);
    // u runs along the side of the first line, from the middle of the corners.
    size_t first = 0;
    for (size_t c = 0; c < sides; ++c)
      for (const size_t p : side(c))
        if (p == 0) first = c;
    const Vec2 u = (polygon_[(first + 1) % sides] - polygon_[first]).normalized();
    Vec2 middle = Vec2::Zero();
    for (const Vec2& p : polygon_) middle += p / static_cast<double>(sides);
    for (Vec2& p : polygon_) {
      const Vec2 d = p - middle;
      p = Vec2(rounded(d.dot(u)), rounded(u.x() * d.y() - u.y() * d.x()));
    }

    warn_of_smoothed_joints(outline_, options_.corner_angle, warnings);
    strips_.resize(n);
    for (size_t c = 0; c < sides; ++c) {
      const auto pieces = side(c);
      const Vec2 &a = polygon_[c], &b = polygon_[(c + 1) % sides];
      double before = 0, fraction = 0;
      if (given_) {
        place_given(pieces, a, b);
        continue;
      }
      for (const size_t p : pieces) {
        const auto& piece = outline_.pieces[p];
        Strip& strip = strips_[p];
        strip.line.name = piece.stretch.name;
        strip.line.curve = piece.flipped ? reversed(piece.stretch.curve) : piece.stretch.curve;
        strip.flipped = piece.flipped;
        strip.fitted = fit(piece.stretch, joint_at(outline_, p), joint_at(outline_, (p + 1) % n),
                           pieces.size() == 1);
        // The piece's share of the side is rounded, and its parameter stretched by the same hair,
        // so that speed stays continuous where pieces meet.
        before += piece.length;
        const double next = p == pieces.back() ? 1 : rounded(before / lengths[c]);
        strip.fitted = stretched(strip.fitted, (next - fraction) * lengths[c] / strip.fitted.end());
        strip.from = a + fraction * (b - a);
        strip.to = a + next * (b - a);
        fraction = next;
      }
    }
  }

  /// "" when the line became a straight run across the polygon, otherwise why it cannot.
  std::string add_inner(const Stretch& s) {
    const InputCurve& curve = *s.curve;
    const Vec3 ends[2] = {curve.evaluate(curve.start()), curve.evaluate(curve.end())};
    if ((ends[0] - ends[1]).norm() <= join_) return "it is closed";
    Strip strip;
    strip.line = s.line(false);
    Vec3 on_outline[2];
    std::array<std::optional<Junction>, 2> junctions;
    for (int e = 0; e < 2; ++e) {
      std::string reason;
      junctions[e] = junction(e, ends[e], reason);
      if (!junctions[e]) return reason;
      const Junction& j = *junctions[e];
      const size_t n = outline_.pieces.size();
      if ((j.fraction <= 0 && outline_.is_corner(j.strip)) ||
          (j.fraction >= 1 && outline_.is_corner((j.strip + 1) % n)))
        return "it ends at a corner, where the two sides fix the surface's slopes already";
      (e ? strip.to : strip.from) = junctions[e]->uv;
      on_outline[e] = junctions[e]->position;
    }
    if (const std::string reason = why_not_inside(s, strip); !reason.empty()) return reason;
    const Vec3 t0 = curve.evaluate(curve.start(), 1).normalized(),
               t1 = curve.evaluate(curve.end(), 1).normalized();
    strip.fitted =
        s.given ? s.given->curve : fit(s, {on_outline[0], t0, t0}, {on_outline[1], t1, t1}, true);
    for (const auto& j : junctions) strips_[j->strip].nodes.push_back(j->fraction);
    fitted_inner_.push_back(s);
    strips_.push_back(std::move(strip));
    return "";
  }

  ParametricMesh mesh() {
    double area = 0;
    for (size_t i = 0, n = polygon_.size(); i < n; ++i)
      area += 0.5 * cross(polygon_[i], polygon_[(i + 1) % n]);
    // Equilateral triangles of that edge, or the fan's.
    const bool counted =
        options_.mesher == SkinOptions::Mesher::Fan && options_.fan_refinements >= 0;
    const double expected =
        counted ? static_cast<double>(polygon_.size()) * std::pow(4.0, options_.fan_refinements)
                : area * size_ * size_ / (std::sqrt(3.0) / 4 * edge_ * edge_);
    constexpr double most_triangles = 2e6;
    if (counted && expected > most_triangles)
      throw InputError("a fan refined " + std::to_string(options_.fan_refinements) + " times has " +
                       number(expected) + " triangles; at most " + number(most_triangles) +
                       " are allowed");
    if (expected > most_triangles)
      throw InputError("edge_length = " + number(edge_) + " on a region of size " + number(size_) +
                       " means about " + number(expected) + " triangles; at most " +
                       number(most_triangles) + " are allowed (is the unit right?)");
    for (Strip& s : strips_) {
      if (s.given()) {
        fix_nodes(s);
        continue;
      }
      for (const double u : s.fitted.parameters()) s.nodes.push_back(u / s.fitted.end());
      std::sort(s.nodes.begin(), s.nodes.end());
    }
    return options_.mesher == SkinOptions::Mesher::Fan ? fan() : delaunay();
  }

  LineRun run(const ParametricMesh& mesh, const Strip& strip) const {
    if (strip.given()) {
      LineRun run{
          strip.line, strip.line.given->curve, strip.points, strip.line.given->vertices, {}};
      if (strip.flipped) std::reverse(run.vertices.begin(), run.vertices.end());
      find_edges(mesh, run);
      return run;
    }
    // Vertices on the strip, by their fraction along it.
    const Vec2 d = strip.to - strip.from;
    const double length = d.norm();
    std::vector<std::pair<double, int>> on_strip;
    for (int v = 0; v < mesh.vertex_count(); ++v) {
      const Vec2 p = mesh.vertices()[v] - strip.from;
      const double fraction = p.dot(d) / (length * length);
      constexpr double near = 1e-11;
      if (std::abs(cross(p, d)) / length < near && fraction > -near && fraction < 1 + near)
        on_strip.emplace_back(std::clamp(fraction, 0.0, 1.0), v);
    }
    std::sort(on_strip.begin(), on_strip.end());
    LineRun run;
    run.line = strip.line;
    run.fitted = strip.flipped ? strip.fitted.backwards() : strip.fitted;
    if (strip.flipped) {
      std::reverse(on_strip.begin(), on_strip.end());
      for (auto& [fraction, v] : on_strip) fraction = 1 - fraction;
    }
    for (const auto& [fraction, v] : on_strip) {
      run.vertices.push_back(v);
      run.parameters.push_back(fraction * strip.fitted.end());
    }
    find_edges(mesh, run);
    return run;
  }

  const std::vector<Vec2>& polygon() const { return polygon_; }
  const std::vector<Strip>& strips() const { return strips_; }
  const std::vector<double>& line_angles() const { return line_angles_; }

 private:
  void require_room(const std::vector<double>& lengths) const {
    double area = 0, around = 0;
    for (size_t i = 0, n = polygon_.size(); i < n; ++i) {
      area += 0.5 * cross(polygon_[i], polygon_[(i + 1) % n]);
      around += lengths[i];
    }
    constexpr double least = 1e-6, least_share = 0.25;
    const double seen = enclosed_area(outline_) / (size_ * size_);
    if (area < least * around * around ||
        (options_.domain == SkinOptions::Domain::Auto && area < least_share * seen))
      throw NoPolygon(
          "the polygon with these sides and corners has no room inside: the outline's sides bend "
          "much more than its corners turn");
  }

  static void find_edges(const ParametricMesh& mesh, LineRun& run) {
    for (size_t i = 0; i + 1 < run.vertices.size(); ++i) {
      const int e = mesh.edge_between(run.vertices[i], run.vertices[i + 1]);
      if (e < 0)
        throw NoSolutionError("the mesher left line '" + run.line.name + "' without an edge at (" +
                              number(mesh.vertices()[run.vertices[i]].x()) + ", " +
                              number(mesh.vertices()[run.vertices[i]].y()) + ")");
      run.edges.push_back(e);
    }
  }

  // Given curves share a side by their parameters, so that the speed along it goes on.
  void place_given(const std::vector<size_t>& pieces, const Vec2& a, const Vec2& b) {
    double whole = 0, before = 0;
    for (const size_t p : pieces) {
      const HermiteCurve& curve = outline_.pieces[p].stretch.given->curve;
      whole += curve.end() - curve.start();
    }
    for (const size_t p : pieces) {
      const auto& piece = outline_.pieces[p];
      Strip& strip = strips_[p];
      strip.line = piece.stretch.line(piece.flipped);
      strip.flipped = piece.flipped;
      strip.fitted = piece.stretch.given_along(piece.flipped);
      strip.from = a + before / whole * (b - a);
      before += strip.fitted.end() - strip.fitted.start();
      strip.to = p == pieces.back() ? b : Vec2(a + before / whole * (b - a));
    }
  }

  // Exactly the given vertices, in the strip's direction.
  static void fix_nodes(Strip& strip) {
    const HermiteCurve& curve = strip.line.given->curve;
    const double span = curve.end() - curve.start();
    strip.nodes.clear();
    for (const double u : strip.line.given->vertices) {
      const double fraction = (u - curve.start()) / span;
      strip.nodes.push_back(strip.flipped ? 1 - fraction : fraction);
    }
    if (strip.flipped) std::reverse(strip.nodes.begin(), strip.nodes.end());
  }

  std::vector<size_t> side(size_t c) const {
    const size_t n = outline_.pieces.size();
    std::vector<size_t> pieces;
    size_t p = static_cast<size_t>(outline_.corners[c]);
    do {
      pieces.push_back(p);
      p = (p + 1) % n;
    } while (!outline_.is_corner(p));
    return pieces;
  }

  HermiteCurve fit(const Stretch& s, const Joint& start, const Joint& end, bool alone) const {
    const bool evenly_cut = options_.mesher == SkinOptions::Mesher::Fan;
    if (alone) {
      constexpr double shortest_edge = 0.3;  // of the target: shorter pieces would crowd the mesh
      const auto exact = kept_as_given(s, shortest_edge * edge_, start.position, end.position);
      if (exact && (exact->segment_count() == 1 || !evenly_cut)) return *exact;
    }
    FitOptions fit;
    fit.tolerance = tolerance_;
    fit.corner_angle = 180;
    fit.closed = false;
    fit.start = {start.position, start.outgoing};
    fit.end = {end.position, end.incoming};
    fit.even = true;
    fit.halved = evenly_cut;
    return fit_curve(s.name, s.curve, fit);
  }

  // Where an inner line's end meets the outline: a node of a piece, new unless one is near.
  struct Junction {
    size_t strip;
    double fraction;
    Vec2 uv;
    Vec3 position;
  };
  std::optional<Junction> junction(int end, const Vec3& p, std::string& reason) const {
    double nearest = std::numeric_limits<double>::infinity(), fraction = 0;
    size_t found = 0;
    for (size_t i = 0; i < outline_.pieces.size(); ++i) {
      const auto closest = strips_[i].fitted.closest_point(p);
      if (closest.distance < nearest) {
        nearest = closest.distance;
        found = i;
        fraction = strips_[i].fraction(closest.u);
      }
    }
    const Strip& strip = strips_[found];
    if (nearest > join_) {
      reason = std::string("its ") + (end ? "end " : "start ") + at(p) + " is " + number(nearest) +
               " away from line '" + strip.line.name + "' (ends meet within " + number(join_) + ")";
      return std::nullopt;
    }
    if (strip.given()) return on_vertex(found, fraction, p, reason);
    const double snap = std::min(join_, 0.05 * edge_) / strip.fitted.end();
    fraction = rounded(fraction);
    for (const double u : strip.fitted.parameters())
      if (std::abs(u / strip.fitted.end() - fraction) < snap) fraction = u / strip.fitted.end();
    // The same number that the outline's own node gets.
    return Junction{found, fraction, strip.at(rounded(fraction)),
                    strip.fitted.evaluate(rounded(fraction) * strip.fitted.end())};
  }

  std::optional<Junction> on_vertex(size_t piece, double fraction, const Vec3& p,
                                    std::string& reason) const {
    const Strip& strip = strips_[piece];
    const HermiteCurve& curve = strip.line.given->curve;
    for (const double u : strip.line.given->vertices) {
      const double along = (u - curve.start()) / (curve.end() - curve.start());
      const double there = strip.flipped ? 1 - along : along;
      const Vec3 position = curve.evaluate(u);
      if ((position - p).norm() <= join_) return Junction{piece, there, strip.at(there), position};
    }
    reason = "it ends between two vertices of line '" + strip.line.name + "', at " +
             number(fraction) + " of it";
    return std::nullopt;
  }

  std::string why_not_inside(const Stretch& s, const Strip& strip) const {
    const InputCurve& curve = *s.curve;
    const std::vector<Vec3> ends = {curve.evaluate(curve.start()), curve.evaluate(curve.end())};
    if (find_self_crossing(curve, 1e-7 * size_).found) return "it crosses itself";
    for (const Stretch& other : fitted_inner_)
      if (const auto c = find_crossing(curve, *other.curve, 1e-7 * size_, ends, 0.02 * size_);
          c.found)
        return "it crosses line '" + other.name + "' near " + at(c.where);
    for (const Strip& other : strips_)
      if (segments_cross(strip.from, strip.to, other.from, other.to))
        return "it would cross line '" + other.line.name + "' in the flat domain";
    const Vec2 middle = 0.5 * (strip.from + strip.to);
    bool inside = false;
    for (size_t i = 0, n = polygon_.size(); i < n; ++i) {
      const Vec2 &a = polygon_[i], &b = polygon_[(i + 1) % n];
      if ((a.y() > middle.y()) != (b.y() > middle.y()) &&
          middle.x() < a.x() + (middle.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
        inside = !inside;
    }
    if (!inside) return "it would run along or outside the outline of the flat domain";
    return "";
  }

  ParametricMesh delaunay() {
    MeshTask task;
    task.edge_length = rounded(edge_ / size_);
    task.keep_segments = given_;
    // Points that strips share (corners, joints, junctions) are one point.
    std::map<std::pair<long long, long long>, int> known;
    const auto add = [&](const Vec2& p) {
      constexpr double cell = 1e11;
      const std::pair key(std::llround(p.x() * cell), std::llround(p.y() * cell));
      for (long long dx = -1; dx <= 1; ++dx)
        for (long long dy = -1; dy <= 1; ++dy)
          if (const auto it = known.find({key.first + dx, key.second + dy}); it != known.end())
            return it->second;
      task.points.push_back(p);
      return known[key] = static_cast<int>(task.points.size()) - 1;
    };
    for (const Vec2& corner : polygon_) add(corner);
    for (size_t i = 0; i < strips_.size(); ++i) {
      Strip& s = strips_[i];
      auto& segments = i < outline_.pieces.size() ? task.outline : task.inner;
      int last = add(s.from);
      if (s.given()) {
        s.points = {last};
        for (size_t k = 1; k < s.nodes.size(); ++k) {
          const int next = add(k + 1 == s.nodes.size() ? s.to : s.at(s.nodes[k]));
          if (next == last || (k > 1 && next == s.points.front()))
            throw InputError("line '" + s.line.name +
                             "' is given with vertices that lie on each other, near " +
                             at(s.fitted.evaluate(s.fitted.start())));
          segments.push_back({last, next});
          s.points.push_back(last = next);
        }
        continue;
      }
      for (size_t k = 0; k + 1 < s.nodes.size(); ++k) {
        const double a = s.nodes[k], b = s.nodes[k + 1];
        const int cuts = std::max(
            1,
            static_cast<int>(std::ceil((b - a) * (s.to - s.from).norm() / task.edge_length - 0.2)));
        for (int c = 1; c <= cuts; ++c) {
          const double fraction = a + (b - a) * c / cuts;
          const int next = fraction >= 1 ? add(s.to) : add(s.at(rounded(fraction)));
          if (next == last) continue;
          segments.push_back({last, next});
          last = next;
        }
      }
    }
    return delaunay_mesh(task);
  }

  ParametricMesh fan() const {
    if (given_) throw InputError("the fan mesher takes no given curves: use mesher = \"delaunay\"");
    MeshTask task;
    task.points = polygon_;
    const int n = static_cast<int>(polygon_.size());
    double longest = 0;
    for (int i = 0; i < n; ++i) {
      task.outline.push_back({i, (i + 1) % n});
      longest = std::max(longest, (polygon_[(i + 1) % n] - polygon_[i]).norm());
    }
    if (!fitted_inner_.empty())
      throw InputError("the fan mesher takes no inner lines: use mesher = \"delaunay\"");
    if (outline_.pieces.size() != polygon_.size())
      throw InputError(
          "the fan mesher needs one line for each side between corners, and there are " +
          std::to_string(outline_.pieces.size()) + " lines for " + std::to_string(n) +
          " sides: use mesher = \"delaunay\"");
    int refinements = options_.fan_refinements;
    if (refinements < 0) {
      refinements = 0;
      while (longest > 1.3 * rounded(edge_ / size_) * std::pow(2.0, refinements) && refinements < 9)
        ++refinements;
      for (const Strip& s : strips_)
        while (!cut_evenly(s, refinements) && refinements < 9) ++refinements;
    }
    for (const Strip& s : strips_)
      if (!cut_evenly(s, refinements))
        throw InputError("line '" + s.line.name + "' needs nodes that a fan refined " +
                         std::to_string(refinements) +
                         " times does not have: raise the tolerance or the refinements, or use "
                         "mesher = \"delaunay\"");
    return fan_mesh(task, refinements);
  }

  static bool cut_evenly(const Strip& s, int refinements) {
    return std::all_of(s.nodes.begin(), s.nodes.end(), [&](double fraction) {
      const double place = std::ldexp(fraction, refinements);
      return std::abs(place - std::round(place)) < 1e-6;
    });
  }

  SkinOptions options_;
  double size_, tolerance_, edge_, join_;
  Outline outline_;
  bool given_;  // all outline lines have given curves
  std::vector<double> line_angles_;
  std::vector<Stretch> fitted_inner_;
  std::vector<Vec2> polygon_;
  std::vector<Strip> strips_;  // outline pieces in loop order, then inner lines
};

}  // namespace

RegionParts polygon_parts(const Outline& loop, const std::vector<Stretch>& inner,
                          const DomainTask& task, const std::vector<Vec2>* polygon,
                          std::vector<Stretch>& others) {
  RegionParts parts;
  PolygonBuilder builder(loop, task);
  builder.build_outline(polygon, parts.warnings);
  using Treatment = CharacterLine::Treatment;
  for (const Stretch& s : inner) {
    std::string reason;
    if (s.treatment != Treatment::Embedded) reason = builder.add_inner(s);
    if (s.treatment == Treatment::Fitted && !reason.empty())
      throw InputError("inner line '" + s.name + "' cannot be fitted: " + reason +
                       "; with treatment = \"embedded\" it may");
    if (s.treatment == Treatment::Embedded || !reason.empty()) others.push_back(s);
  }
  parts.mesh = std::make_shared<ParametricMesh>(builder.mesh());
  for (const Strip& s : builder.strips()) parts.runs.push_back(builder.run(*parts.mesh, s));
  parts.boundary.resize(1);
  for (size_t p = 0; p < loop.pieces.size(); ++p)
    parts.boundary[0].push_back(
        {BoundaryPiece::Kind::Run, static_cast<int>(p), builder.strips()[p].flipped});

  const auto& corners = builder.polygon();
  for (size_t i = 0, n = corners.size(); i < n; ++i) {
    const Vec2 a = corners[i] - corners[(i + n - 1) % n], b = corners[(i + 1) % n] - corners[i];
    constexpr double degrees = 180 / std::numbers::pi;
    parts.corners.push_back({corners[i], 180 - std::atan2(cross(a, b), a.dot(b)) * degrees,
                             builder.line_angles()[i] * degrees});
  }
  return parts;
}

}  // namespace batten
