#include "batten/skinning/domains/ring.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/core/words.h"
#include "batten/skinning/domains/mesh_size.h"
#include "batten/skinning/domains/ring_rim.h"

namespace batten {
namespace {

// Sum of squared distances of points of rim A from those of B, which begins at k.
double apart(const std::vector<Vec3>& a, const std::vector<Vec3>& b, int k, int direction) {
  const int n = count_of(a);
  double sum = 0;
  for (int i = 0; i < n; ++i) sum += (a[i] - b[(k + direction * i + n) % n]).squaredNorm();
  return sum;
}

class Builder {
 public:
  Builder(const Outline& a, const Outline& b, const DomainTask& task)
      : task_(task), rim_{Rim(a), Rim(b)} {}

  RegionParts build() {
    for (const Rim& rim : rim_) require_smooth(rim.outline);
    match();
    for (Rim& rim : rim_) fit(rim);
    columns();
    RegionParts parts;
    parts.mesh = mesh();
    parts.boundary.resize(2);
    for (const int r : {0, 1})
      for (size_t i = 0; i < rim_[r].places.size(); ++i) {
        const int index = count_of(parts.runs);
        const bool flipped = rim_[r].outline.pieces[i].flipped;
        parts.boundary[r].push_back({BoundaryPiece::Kind::Run, index, flipped != (r == 1)});
        parts.runs.push_back(run(*parts.mesh, r, i));
      }
    // Rim B is run against u; its first line stays first.
    std::reverse(parts.boundary[1].begin() + 1, parts.boundary[1].end());
    return parts;
  }

 private:
  void require_smooth(const Outline& rim) const {
    if (rim.corners.empty()) return;
    const auto& piece = rim.pieces[rim.corners[0]];
    throw InputError(
        "the rims of a ring must be smooth, and one turns by more than " +
        number(task_.options.corner_angle) + " degrees where line '" + piece.stretch.name +
        "' begins, " + at(piece.start) +
        ". With a corner_angle above that turn it is rounded; or lines from rim to rim "
        "cut the ring into regions with corners");
  }

  // Direction and start of rim B against rim A.
  void match() {
    constexpr int n = 256;
    std::vector<Vec3> a(n), b(n);
    for (int i = 0; i < n; ++i) {
      a[i] = rim_[0].point(static_cast<double>(i) / n).x;
      b[i] = rim_[1].point(static_cast<double>(i) / n).x;
    }
    const int direction = rims_run_alike(a, b) ? 1 : -1;
    double least = std::numeric_limits<double>::infinity();
    int start = 0;
    for (int k = 0; k < n; ++k) {
      const double sum = apart(a, b, k, direction);
      // A tie stays with the first.
      if (sum < least - 1e-9 * n * task_.size * task_.size) {
        least = sum;
        start = k;
      }
    }
    if (direction < 0) {
      rim_[1] = Rim(reversed(rim_[1].outline));
      start = (n - start) % n;
    }
    // Between samples: where the sum's slope changes sign.
    const auto slope = [&](double phase) {
      double sum = 0;
      for (int i = 0; i < n; ++i) {
        const auto place = rim_[1].point(phase + static_cast<double>(i) / n);
        sum += (place.x - a[i]).dot(place.tangent);
      }
      return sum;
    };
    double low = (start - 1.0) / n, high = (start + 1.0) / n;
    double phase = static_cast<double>(start) / n;
    if (slope(low) < 0 && slope(high) > 0) {
      for (int step = 0; step < 48; ++step) {
        phase = 0.5 * (low + high);
        (slope(phase) < 0 ? low : high) = phase;
      }
    }
    phase = fraction_of(rounded(phase));

    double distance = 0;
    for (int i = 0; i < n; ++i)
      distance += (rim_[1].point(phase + static_cast<double>(i) / n).x - a[i]).norm() / n;
    U_ = rounded(0.5 * (rim_[0].length + rim_[1].length) / task_.size);
    V_ = rounded(distance / task_.size);
    if (!(V_ > 1e-6 * U_))
      throw InputError("the rims of a ring, with lines '" + rim_[0].outline.pieces[0].stretch.name +
                       "' and '" + rim_[1].outline.pieces[0].stretch.name + "', coincide");
    if (rim_[1].one_line() && !rim_[1].given()) {
      rim_[1] = rim_[1].cut_at(phase);
    } else if (rim_[0].one_line() && !rim_[0].given()) {
      rim_[0] = rim_[0].cut_at(-phase);
    } else {
      for (auto& place : rim_[1].places) place.from = fraction_of(place.from - phase);
    }
  }

  // The curves as they are given, so that the regions beyond carry the same.
  static void take_given(Rim& rim) {
    for (size_t i = 0; i < rim.places.size(); ++i) {
      const auto& piece = rim.outline.pieces[i];
      const HermiteCurve along = piece.stretch.given_along(piece.flipped);
      rim.places[i].fitted = rim.one_line() ? closed_curve(along) : along;
    }
  }

  void fit(Rim& rim) const {
    if (rim.given()) return take_given(rim);
    FitOptions fit;
    fit.tolerance = task_.tolerance;
    fit.corner_angle = 180;
    fit.even = true;
    fit.halved = true;
    fit.closed = rim.one_line();
    const size_t n = rim.places.size();
    for (size_t i = 0; i < n; ++i) {
      if (n > 1) {
        const Joint start = joint_at(rim.outline, i), end = joint_at(rim.outline, (i + 1) % n);
        fit.start = {start.position, start.outgoing};
        fit.end = {end.position, end.incoming};
      }
      const Stretch& line = rim.outline.pieces[i].stretch;
      auto& place = rim.places[i];
      place.fitted = fit_curve(line.name, line.curve, fit);
      // Stretched by the hair by which the share is rounded: speed goes on from line to line.
      std::vector<double> u = place.fitted.parameters();
      const double stretch = place.share * rim.length / u.back();
      for (double& x : u) x *= stretch;
      place.fitted = {CurveMesh(std::move(u), rim.one_line()), place.fitted.dofs()};
    }
  }

  // Where the nodes of a rim, or the given vertices, lie, as fractions of it.
  static std::vector<double> nodes(const Rim& rim) {
    std::vector<double> all;
    for (size_t i = 0; i < rim.places.size(); ++i) {
      const Rim::Place& p = rim.places[i];
      const auto& piece = rim.outline.pieces[i];
      const double end = p.fitted.end();
      if (rim.given()) {
        for (const double vertex : piece.stretch.given->vertices)
          if (const double t = piece.flipped ? end - vertex : vertex; t < end)
            all.push_back(fraction_of(p.from + p.share * t / end));
      } else {
        for (int k = 0; k < p.fitted.segment_count(); ++k)
          all.push_back(fraction_of(p.from + p.share * rounded(p.fitted.parameters()[k] / end)));
      }
    }
    return all;
  }

  // A column of the mesh by its fractions on both rims; they may go past 1.
  struct Column {
    double at[2];
  };

  // A node on a rim, and the one on the other rim that shares its column.
  struct Node {
    double at;
    int rim;
    int partner;  // in the list of all nodes
  };

  // Width of columns, as a share of a rim: near-square cells, eight around at least.
  double column_width() const {
    const double h = std::min({task_.edge / task_.size, 2 * V_, U_ / 8}) / U_;
    const double expected = 2 * U_ * V_ * task_.size * task_.size / (task_.edge * task_.edge);
    require_mesh_size(std::max(expected, 2 / h), task_.edge, task_.size, "a ring");
    return h;
  }

  // Nodes of both rims. Neighbours on different rims share a column: those that coincide first,
  // then near ones.
  std::vector<Node> paired_nodes(double h) const {
    std::vector<Node> found;
    for (int r = 0; r < 2; ++r)
      for (const double f : nodes(rim_[r])) found.push_back({f, r, -1});
    std::sort(found.begin(), found.end(), [](const Node& a, const Node& b) {
      return a.at != b.at ? a.at < b.at : a.rim < b.rim;
    });
    const int n = count_of(found);
    constexpr double coincide = 1e-8;
    for (const double reach : {coincide, 0.5 * h})
      for (int i = 0; i < n; ++i) {
        const int j = (i + 1) % n;
        Node &a = found[i], &b = found[j];
        if (a.rim == b.rim || a.partner >= 0 || b.partner >= 0) continue;
        if (fraction_of(b.at - a.at) > reach) continue;
        a.partner = j;
        b.partner = i;
      }
    return found;
  }

  // Columns that end on nodes of both rims, the first again at the end.
  static std::vector<Column> shared_columns(const std::vector<Node>& found) {
    std::vector<Column> shared;
    for (const Node& node : found)
      if (node.rim == 0 && node.partner >= 0) {
        const double other = found[node.partner].at;
        shared.push_back({{node.at, node.at + std::remainder(other - node.at, 1.0)}});
      }
    if (shared.empty()) shared.push_back({{found[0].at, found[0].at}});
    shared.push_back({{shared[0].at[0] + 1, shared[0].at[1] + 1}});
    return shared;
  }

  void columns() {
    const double h = column_width();
    const std::vector<Node> found = paired_nodes(h);
    const std::vector<Column> shared = shared_columns(found);
    // Between two shared columns, nodes of one rim have their column's other end by proportion.
    for (size_t k = 0; k + 1 < shared.size(); ++k) {
      const Column &from = shared[k], &to = shared[k + 1];
      const auto between = [&](double t) {
        return Column{
            {from.at[0] + t * (to.at[0] - from.at[0]), from.at[1] + t * (to.at[1] - from.at[1])}};
      };
      std::vector<double> places = {0, 1};
      for (const Node& node : found) {
        if (node.partner >= 0) continue;
        const int r = node.rim;
        const double t = fraction_of(node.at - from.at[r]) / (to.at[r] - from.at[r]);
        if (t > 0 && t < 1) places.push_back(t);
      }
      std::sort(places.begin(), places.end());
      places.erase(std::unique(places.begin(), places.end()), places.end());
      for (size_t p = 0; p + 1 < places.size(); ++p) {
        const double width =
            (places[p + 1] - places[p]) * std::max(to.at[0] - from.at[0], to.at[1] - from.at[1]);
        const int cuts = std::max(1, static_cast<int>(std::ceil(width / h - 0.2)));
        for (int c = 0; c < cuts; ++c)
          columns_.push_back(between(places[p] + (places[p + 1] - places[p]) * c / cuts));
      }
    }
  }

  std::shared_ptr<const ParametricMesh> mesh() const {
    const int n = count_of(columns_);
    const int rows = std::max(1, static_cast<int>(std::lround(V_ * task_.size / task_.edge)));
    std::vector<Vec2> vertices;
    for (int j = 0; j <= rows; ++j)
      for (const Column& c : columns_) {
        const double s = static_cast<double>(j) / rows;
        const double f = fraction_of((1 - s) * c.at[0] + s * c.at[1]);
        vertices.emplace_back(f * U_ < U_ ? f * U_ : 0, j == rows ? V_ : s * V_);
      }
    std::vector<ParametricMesh::Triangle> triangles;
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < n; ++i) {
        const int a = j * n + i, b = j * n + (i + 1) % n, c = a + n, d = b + n;
        if ((i + j) % 2) {
          triangles.push_back({a, b, c});
          triangles.push_back({b, d, c});
        } else {
          triangles.push_back({a, b, d});
          triangles.push_back({a, d, c});
        }
      }
    return std::make_shared<ParametricMesh>(std::move(vertices), std::move(triangles), U_);
  }

  LineRun run(const ParametricMesh& mesh, int r, size_t index) const {
    const auto& line = rim_[r].outline.pieces[index];
    const Rim::Place& p = rim_[r].places[index];
    const int n = count_of(columns_);
    const int row = r == 0 ? 0 : mesh.vertex_count() - n;
    // The column of a joint, by its place on the rim.
    const auto column_at = [&](double fraction) {
      int best = 0;
      for (int i = 1; i < n; ++i)
        if (std::abs(std::remainder(columns_[i].at[r] - fraction, 1.0)) <
            std::abs(std::remainder(columns_[best].at[r] - fraction, 1.0)))
          best = i;
      return best;
    };
    LineRun run;
    run.line = {line.stretch.name, line.flipped ? reversed(line.stretch.curve) : line.stretch.curve,
                line.stretch.role};
    run.fitted = line.flipped ? p.fitted.backwards() : p.fitted;
    const int first = column_at(p.from), last = column_at(p.from + p.share);
    const int count = last > first ? last - first : last - first + n;
    for (int k = 0; k <= count; ++k) {
      const int i = (first + k) % n;
      run.vertices.push_back(row + i);
      const double f = k == 0       ? 0
                       : k == count ? 1
                                    : fraction_of(columns_[i].at[r] - p.from) / p.share;
      run.parameters.push_back((line.flipped ? 1 - f : f) * p.fitted.end());
    }
    if (line.flipped) {
      std::reverse(run.vertices.begin(), run.vertices.end());
      std::reverse(run.parameters.begin(), run.parameters.end());
    }
    for (size_t k = 0; k + 1 < run.vertices.size(); ++k)
      run.edges.push_back(mesh.edge_between(run.vertices[k], run.vertices[k + 1]));
    return run;
  }

  const DomainTask& task_;
  Rim rim_[2];
  double U_ = 0, V_ = 0;
  std::vector<Column> columns_;
};

}  // namespace

bool rims_run_alike(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  const auto n = static_cast<double>(a.size());
  const auto middle = [n](const std::vector<Vec3>& points) {
    Vec3 sum = Vec3::Zero();
    for (const Vec3& p : points) sum += p / n;
    return sum;
  };
  const auto area = [](const std::vector<Vec3>& p, const Vec3& about) {
    Vec3 sum = Vec3::Zero();
    for (size_t i = 0; i < p.size(); ++i)
      sum += (p[i] - about).cross(p[(i + 1) % p.size()] - about);
    return sum;
  };
  const Vec3 ma = middle(a), mb = middle(b), way = mb - ma, na = area(a, ma), nb = area(b, mb);
  constexpr double clear = 0.2;
  const double sa = na.dot(way), sb = nb.dot(way);
  if (std::abs(sa) > clear * na.norm() * way.norm() &&
      std::abs(sb) > clear * nb.norm() * way.norm())
    return sa * sb > 0;
  const auto least = [&](int direction) {
    double sum = std::numeric_limits<double>::infinity();
    for (int k = 0; k < count_of(a); ++k) sum = std::min(sum, apart(a, b, k, direction));
    return sum;
  };
  const double alike = least(1), against = least(-1);
  constexpr double tie = 1e-6;
  if (std::abs(alike - against) < tie * (alike + against)) return na.dot(nb) >= 0;
  return alike < against;
}

RegionParts ring_parts(const Outline& a, const Outline& b, const DomainTask& task) {
  return Builder(a, b, task).build();
}

}  // namespace batten
