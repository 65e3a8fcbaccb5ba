// Where embedded lines meet each other and the runs.
#include <algorithm>
#include <cmath>
#include <optional>

#include "batten/core/box.h"
#include "batten/core/errors.h"
#include "batten/core/plane.h"
#include "batten/core/words.h"
#include "batten/skinning/domains/domain_task.h"

namespace batten {
namespace {

HermiteCurve shifted(const HermiteCurve& image, double du) {
  Points dofs = image.dofs();
  for (int i = 0; i < image.node_count(); ++i) dofs(image.mesh().position_dof(i), 0) += du;
  return {image.mesh(), std::move(dofs)};
}

struct Chord {
  double t0, t1;
  Vec2 p, q;
  bool box_meets(const Chord& other) const {
    return std::max(p.x(), q.x()) >= std::min(other.p.x(), other.q.x()) &&
           std::max(other.p.x(), other.q.x()) >= std::min(p.x(), q.x()) &&
           std::max(p.y(), q.y()) >= std::min(other.p.y(), other.q.y()) &&
           std::max(other.p.y(), other.q.y()) >= std::min(p.y(), q.y());
  }
};

// A segment of a curve as chords, and their box.
struct ChordRow {
  Box2 box;
  std::vector<Chord> chords;
  bool box_meets(const ChordRow& other) const { return box.intersects(other.box); }
};

std::vector<ChordRow> chord_rows(const HermiteCurve& c) {
  constexpr int cuts = 16;
  const auto& u = c.parameters();
  std::vector<ChordRow> rows;
  for (int s = 0; s < c.segment_count(); ++s) {
    ChordRow row;
    Vec2 p = flat(c.evaluate({s, 0.0}));
    row.box.extend(p);
    for (int k = 0; k < cuts; ++k) {
      const double t0 = u[s] + c.mesh().length(s) * k / cuts,
                   t1 = u[s] + c.mesh().length(s) * (k + 1) / cuts;
      const Vec2 q = flat(c.evaluate({s, static_cast<double>(k + 1) / cuts}));
      row.chords.push_back({t0, t1, p, q});
      row.box.extend(q);
      p = q;
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

// Where the images of two lines cross, by their parameters.
struct Meeting {
  double s, t;
};

// Newton's method from where two chords cross, or nearly so.
std::optional<Meeting> meeting_near(const HermiteCurve& a, const Chord& x, const HermiteCurve& b,
                                    const Chord& y) {
  const Vec2 d = x.q - x.p, e = y.q - y.p, r = y.p - x.p;
  const double det = cross(d, e);
  if (std::abs(det) < 1e-12 * d.norm() * e.norm()) return std::nullopt;
  const double i = cross(r, e) / det, j = cross(r, d) / det;
  if (i < -0.01 || i > 1.01 || j < -0.01 || j > 1.01) return std::nullopt;
  double s = x.t0 + i * (x.t1 - x.t0), t = y.t0 + j * (y.t1 - y.t0);
  for (int step = 0; step < 8; ++step) {
    const Vec2 gap = flat(b.evaluate(t)) - flat(a.evaluate(s));
    const Vec2 ds = flat(a.evaluate(s, 1)), dt = flat(b.evaluate(t, 1));
    const double D = cross(ds, dt);
    if (std::abs(D) < 1e-12 * ds.norm() * dt.norm()) break;
    s = std::clamp(s + cross(gap, dt) / D, a.start(), a.end());
    t = std::clamp(t + cross(gap, ds) / D, b.start(), b.end());
  }
  if ((flat(b.evaluate(t)) - flat(a.evaluate(s))).norm() > 1e-9) return std::nullopt;
  return Meeting{s, t};
}

std::vector<Meeting> meetings(const HermiteCurve& a, const HermiteCurve& b) {
  std::vector<Meeting> found;
  const auto known = [&](double s) {
    return std::any_of(found.begin(), found.end(), [&](const Meeting& m) {
      return (flat(a.evaluate(m.s)) - flat(a.evaluate(s))).norm() < 1e-7;
    });
  };
  const auto of_a = chord_rows(a), of_b = chord_rows(b);
  for (const ChordRow& i : of_a)
    for (const ChordRow& j : of_b) {
      if (!i.box_meets(j)) continue;
      for (const Chord& x : i.chords)
        for (const Chord& y : j.chords) {
          if (!x.box_meets(y)) continue;
          const auto m = meeting_near(a, x, b, y);
          if (m && !known(m->s)) found.push_back(*m);
        }
    }
  return found;
}

// The same on a mesh that may be periodic: a line also meets the other's images.
std::vector<Meeting> meetings(const ParametricMesh& mesh, const HermiteCurve& a,
                              const HermiteCurve& b) {
  if (mesh.period() == 0) return meetings(a, b);
  const auto reach = [](const HermiteCurve& c) {
    Vec2 range(c.position(0).x(), c.position(0).x());
    for (const PlanarCubic& arc : planar_arcs(c))
      for (const Vec2& p : arc.b) range = {std::min(range[0], p.x()), std::max(range[1], p.x())};
    return range;
  };
  const Vec2 of_a = reach(a), of_b = reach(b);
  const double period = mesh.period();
  std::vector<Meeting> found;
  for (double k = std::ceil((of_a[0] - of_b[1]) / period - 1e-9);
       of_b[0] + k * period <= of_a[1] + 1e-9 * period; ++k)
    for (const Meeting& m : meetings(a, shifted(b, k * period))) {
      const bool known = std::any_of(found.begin(), found.end(), [&](const Meeting& other) {
        return domain_distance(mesh, flat(a.evaluate(m.s)), flat(a.evaluate(other.s))) < 1e-7;
      });
      if (!known) found.push_back(m);
    }
  return found;
}

class Junctions {
 public:
  Junctions(RegionParts& parts, const DomainTask& task)
      : parts_(parts),
        task_(task),
        bounds_(boundary_lines(parts)),
        always_(parts.embedded.size()) {}

  std::vector<std::vector<double>> find() {
    for (size_t i = 0; i < always_.size(); ++i) {
      if (bounds_[i]) continue;
      if (!parts_.embedded[i].fitted.closed())
        for (const bool last : {false, true}) move_end(i, last);
      find_crossings(i);
    }
    return std::move(always_);
  }

 private:
  // Inner lines look at boundary lines, and at inner lines before them.
  bool looks_at(size_t i, size_t j) const { return j != i && (bounds_[j] || j < i); }

  // An end that lies on another line moves onto it.
  void move_end(size_t i, bool last) {
    const HermiteCurve& fitted = parts_.embedded[i].fitted;
    const Vec3 end = fitted.position(last ? fitted.node_count() - 1 : 0);
    for (const LineRun& run : parts_.runs) {
      const auto near = run.fitted.closest_point(end);
      if (near.distance > task_.join) continue;
      move_to(i, last, run.fitted.evaluate(near.u), run_image(*parts_.mesh, run).evaluate(near.u));
      return;
    }
    for (size_t j = 0; j < always_.size(); ++j) {
      if (!looks_at(i, j)) continue;
      const EmbeddedLine& other = parts_.embedded[j];
      const auto near = other.fitted.closest_point(end);
      if (near.distance > task_.join) continue;
      move_to(i, last, other.fitted.evaluate(near.u), other.image.evaluate(near.u));
      always_[j].push_back(near.u);
      return;
    }
  }

  void move_to(size_t i, bool last, const Vec3& position, const Vec3& uv) {
    EmbeddedLine& line = parts_.embedded[i];
    const int node = last ? line.fitted.node_count() - 1 : 0,
              image_node = last ? line.image.node_count() - 1 : 0;
    Points x = line.fitted.dofs(), c = line.image.dofs();
    x.row(line.fitted.mesh().position_dof(node)) = position;
    const Vec2 there = parts_.mesh->image_near(flat(uv), flat(line.image.position(image_node)));
    c.row(line.image.mesh().position_dof(image_node)) << there.x(), there.y(), 0;
    line.fitted = {line.fitted.mesh(), x};
    line.image = {line.image.mesh(), c};
  }

  void find_crossings(size_t i) {
    const EmbeddedLine& line = parts_.embedded[i];
    for (const LineRun& run : parts_.runs)
      for (const Meeting& m : meetings(*parts_.mesh, run_image(*parts_.mesh, run), line.image))
        require_near(line, run.line.name, run.fitted.evaluate(m.s), line.fitted.evaluate(m.t));
    for (size_t j = 0; j < always_.size(); ++j) {
      if (!looks_at(i, j)) continue;
      const EmbeddedLine& other = parts_.embedded[j];
      for (const Meeting& m : meetings(*parts_.mesh, other.image, line.image)) {
        require_near(line, other.line.name, other.fitted.evaluate(m.s), line.fitted.evaluate(m.t));
        always_[j].push_back(m.s);
        always_[i].push_back(m.t);
      }
    }
  }

  void require_near(const EmbeddedLine& line, const std::string& other, const Vec3& p,
                    const Vec3& q) const {
    const double away = (p - q).norm();
    if (away > task_.tolerance)
      throw InputError("lines '" + other + "' and '" + line.line.name +
                       "' cross in the flat domain near " + at(p) + ", but are " + number(away) +
                       " apart there (tolerance " + number(task_.tolerance) +
                       "): a surface cannot be on both");
  }

  RegionParts& parts_;
  const DomainTask& task_;
  std::vector<char> bounds_;
  std::vector<std::vector<double>> always_;
};

}  // namespace

std::vector<std::vector<double>> junctions(RegionParts& parts, const DomainTask& task) {
  return Junctions(parts, task).find();
}

}  // namespace batten
