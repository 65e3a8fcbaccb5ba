#include "batten/skinning/network/join.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "batten/constraints/affine_reduction.h"
#include "batten/core/errors.h"
#include "batten/core/plane.h"
#include "batten/core/words.h"
#include "batten/elements/quadrature.h"
#include "batten/fem/assembly.h"
#include "batten/fem/triangle_locator.h"

namespace batten {
namespace {

using Entries = std::vector<ConstraintSet::Entry>;

// One side of a seam: where the line runs in (u, v) and how dofs make y. f: fraction of the line.
class Side {
 public:
  Side(const ParametricMesh& mesh, TriangleElement kind, const LineRun* run,
       const EmbeddedLine* line, bool left, const TriangleLocator* locator)
      : mesh_(&mesh), kind_(kind), run_(run), line_(line), locator_(locator), turn_(left ? 1 : -1) {
    const CharacterLine& character = run ? run->line : line->line;
    const HermiteCurve& curve = run ? run->fitted : line->fitted;
    start_ = curve.start();
    span_ = curve.end() - start_;
    t_ = character.given ? character.given->curve.end() - character.given->curve.start() : span_;
    if (!run) {
      against_ = runs_against_given(*line);
      return;
    }
    const Vec2 d = mesh.displacement(run->vertices);
    sigma_ = d.norm() / t_;
    inward_ = inward(d.normalized());
  }
  bool embedded() const { return !run_; }
  const LineRun& run() const { return *run_; }
  int count() const { return static_cast<int>(run_->vertices.size()); }
  int vertex(int k) const { return run_->vertices[static_cast<size_t>(k)]; }
  int end_vertex(int end) const { return vertex(end ? count() - 1 : 0); }
  bool closed() const {
    return run_ ? run_->vertices.front() == run_->vertices.back() : line_->fitted.closed();
  }
  double fraction(int k) const {
    return (run_->parameters[static_cast<size_t>(k)] - start_) / span_;
  }
  // Fractions of vertices or points.
  std::vector<double> stations() const {
    std::vector<double> f;
    for (const double p : run_ ? run_->parameters : line_->points) {
      const double along = (p - start_) / span_;
      f.push_back(against_ ? 1 - along : along);
    }
    std::sort(f.begin(), f.end());
    // A line much shorter than its elements has no point of its own.
    if (f.size() < 2) f = {0, 1};
    return f;
  }
  // dX/dt.
  Vec3 slope(double f) const {
    return (run_ ? run_->fitted : line_->fitted).evaluate(parameter(f), 1) * per_t();
  }

  Vec3 across(const Points& q, int k) const {
    const int v = 3 * vertex(k);
    return sigma_ * (inward_.x() * q.row(v + 1) + inward_.y() * q.row(v + 2)).transpose();
  }
  void add_vertex(int k, double factor, int offset, Entries& entries) const {
    const int v = offset + 3 * vertex(k);
    entries.push_back({v + 1, factor * sigma_ * inward_.x()});
    entries.push_back({v + 2, factor * sigma_ * inward_.y()});
  }
  void add_middle(int k, double factor, int offset, Entries& entries) const {
    const int e = run_->edges[static_cast<size_t>(k)];
    entries.push_back({offset + DofMap(*mesh_).edge(e),
                       factor * sigma_ * (mesh_->edge_normal(e).dot(inward_) > 0 ? 1 : -1)});
  }

  // Anywhere on the line.
  Location where(double f) const {
    const double p = parameter(f);
    if (line_) {
      const Vec3 c = line_->image.evaluate(line_->image.mesh().wrapped(p));
      return locator_->locate({c.x(), c.y()});
    }
    const auto& at = run_->parameters;
    const auto above = std::upper_bound(at.begin() + 1, at.end() - 1, p);
    const auto k = static_cast<size_t>(above - at.begin()) - 1;
    const auto& e = mesh_->edges()[static_cast<size_t>(run_->edges[k])];
    const int t = e.triangle[0], i = e.local[0];
    const bool next = mesh_->triangles()[static_cast<size_t>(t)][(i + 1) % 3] == run_->vertices[k];
    const int first = next ? (i + 1) % 3 : (i + 2) % 3;
    Location found{t, Vec3::Zero()};
    found.L[3 - i - first] = std::clamp((p - at[k]) / (at[k + 1] - at[k]), 0.0, 1.0);
    found.L[first] = 1 - found.L[3 - i - first];
    return found;
  }
  // y = grad x · direction(f).
  Vec2 direction(double f) const {
    if (run_) return sigma_ * inward_;
    const Vec3 c = line_->image.evaluate(line_->image.mesh().wrapped(parameter(f)), 1) * per_t();
    return inward({c.x(), c.y()});
  }
  Vec3 across_at(const Points& q, double f) const {
    Entries entries;
    add_at(f, 1, 0, entries);
    Vec3 y = Vec3::Zero();
    for (const auto& e : entries) y += e.coefficient * q.row(e.dof).transpose();
    return y;
  }
  void add_at(double f, double factor, int offset, Entries& entries) const {
    const Location at = where(f);
    const Vec2 d = factor * direction(f);
    const Tabulation N = C1Triangle(kind_, mesh_->shape(at.triangle)).evaluate(at.L);
    const auto dofs = DofMap(*mesh_).triangle(*mesh_, at.triangle);
    for (int m = 0; m < 12; ++m)
      entries.push_back(
          {offset + dofs[static_cast<size_t>(m)], d.x() * N(m, kU) + d.y() * N(m, kV)});
  }

 private:
  double parameter(double f) const { return start_ + (against_ ? 1 - f : f) * span_; }
  double per_t() const { return (against_ ? -1 : 1) * span_ / t_; }
  Vec2 inward(const Vec2& along) const { return turn_ * Vec2(-along.y(), along.x()); }

  const ParametricMesh* mesh_;
  TriangleElement kind_;
  const LineRun* run_;
  const EmbeddedLine* line_;
  const TriangleLocator* locator_;
  double turn_, start_ = 0, span_ = 1, t_ = 1, sigma_ = 1;
  bool against_ = false;
  Vec2 inward_ = Vec2::Zero();
};

// Sides of seams, with one locator for each region that needs one.
class Sides {
 public:
  explicit Sides(const std::vector<JoinRegion>& regions) {
    for (const JoinRegion& r : regions)
      items_.push_back(r.layout ? Item{r.layout->mesh().get(),
                                       r.layout->element(),
                                       &r.layout->runs(),
                                       &r.layout->embedded(),
                                       {}}
                                : Item{});
  }
  explicit Sides(const std::vector<const SkinnedRegion*>& regions) {
    for (const SkinnedRegion* r : regions)
      items_.push_back(r ? Item{&r->surface.mesh(), r->surface.kind(), &r->runs, &r->embedded, {}}
                         : Item{});
  }
  Side operator()(const JoinSide& j) {
    Item& item = items_[static_cast<size_t>(j.region)];
    if (j.embedded && !item.locator) item.locator = std::make_unique<TriangleLocator>(*item.mesh);
    const auto i = static_cast<size_t>(j.line);
    return {*item.mesh,
            item.kind,
            j.embedded ? nullptr : &(*item.runs)[i],
            j.embedded ? &(*item.lines)[i] : nullptr,
            j.left,
            item.locator.get()};
  }

 private:
  struct Item {
    const ParametricMesh* mesh = nullptr;
    TriangleElement kind = TriangleElement::HCT;
    const std::vector<LineRun>* runs = nullptr;
    const std::vector<EmbeddedLine>* lines = nullptr;
    std::unique_ptr<TriangleLocator> locator;
  };
  std::vector<Item> items_;
};

// Vertices of a region at which lines of two directions meet: x_u and x_v are given there.
std::vector<char> cornered(const RegionLayout& layout) {
  const ParametricMesh& mesh = *layout.mesh();
  std::vector<char> corner(static_cast<size_t>(mesh.vertex_count()), 0);
  std::map<int, Vec2> seen;
  for (const LineRun& run : layout.runs()) {
    const Vec2 d = mesh.displacement(run.vertices).normalized();
    for (const int v : run.vertices) {
      const auto [it, first] = seen.emplace(v, d);
      constexpr double straight = 1e-9;
      if (!first && std::abs(cross(it->second, d)) > straight) corner[static_cast<size_t>(v)] = 1;
    }
  }
  return corner;
}

double share(double a, double b, double f) { return a + f * (b - a); }

}  // namespace

bool runs_against_given(const EmbeddedLine& line) {
  if (!line.line.given) return false;
  const HermiteCurve& given = line.line.given->curve;
  const double f = 0.25;  // ends may be one point
  const auto at = [f](const HermiteCurve& c, double s) {
    return c.evaluate(c.start() + (s < 0 ? 1 - f : f) * (c.end() - c.start()));
  };
  const Vec3 p = at(line.fitted, 1);
  return (p - at(given, -1)).norm() < (p - at(given, 1)).norm();
}

bool SeamPlan::constant() const {
  constexpr double same = 1e-7;  // below 1e-5 degrees
  return at.empty() && !ends[0].open && !ends[1].open &&
         std::abs(ends[0].gamma - ends[1].gamma) < same &&
         std::abs(ends[0].delta - ends[1].delta) < same;
}

namespace {

// γ and δ that change two shapes least, and the angle between their planes.
struct Glue {
  double gamma, delta, apart_deg;
  Glue(const Vec3& slope, const Vec3& a, const Vec3& b) {
    const double s2 = slope.squaredNorm();
    const Vec3 across_a = a - a.dot(slope) / s2 * slope, across_b = b - b.dot(slope) / s2 * slope;
    gamma = across_a.norm() / across_b.norm();
    delta = (a + gamma * b).dot(slope) / s2;
    apart_deg = degrees_between(across_a, -across_b);
  }
  // "" or why the seam has to be given up.
  std::string wrong(const std::string& where) const {
    constexpr double most_gamma = 50, most_apart = 90;
    if (gamma > 1 / most_gamma && gamma < most_gamma && std::isfinite(delta) &&
        apart_deg <= most_apart)
      return "";
    return "the surfaces beside it do not go on into each other " + where +
           ": their planes differ by " + number(apart_deg) + " degrees";
  }
};

void plan_embedded(SeamPlan& plan, const Side& a, const Side& b, const Points& qa,
                   const Points& qb) {
  // The hats of the coarser side.
  plan.at = a.embedded() ? a.stations() : b.stations();
  if (a.embedded() && b.embedded() && b.stations().size() < plan.at.size()) plan.at = b.stations();
  if (a.closed() && plan.at.back() < 1) plan.at.push_back(1);
  for (const double f : plan.at) {
    const Glue glue(a.slope(f), a.across_at(qa, f), b.across_at(qb, f));
    plan.gamma.push_back(glue.gamma);
    plan.delta.push_back(glue.delta);
    // Ends lie at corners, where an embedded line holds slopes only roughly.
    const bool end = f == plan.at.front() || f == plan.at.back();
    if (!end && plan.why_not.empty()) plan.why_not = glue.wrong("everywhere");
  }
  if (plan.at.size() < 4) plan.why_not = "it is shorter than the elements that it is embedded in";
}

}  // namespace

std::vector<SeamPlan> plan_seams(const std::vector<JoinRegion>& regions,
                                 const std::vector<Seam>& seams, double most_apart_deg) {
  std::vector<std::vector<char>> corner;
  for (const JoinRegion& region : regions)
    corner.push_back(region.layout ? cornered(*region.layout) : std::vector<char>());
  const auto first = [&](const JoinSide& j) -> const Points& {
    return regions[static_cast<size_t>(j.region)].first;
  };

  Sides sides(regions);
  std::vector<SeamPlan> plans;
  for (const Seam& seam : seams) {
    SeamPlan plan;
    plan.seam = seam;
    const Side a = sides(seam.sides[0]), b = sides(seam.sides[1]);
    if (a.embedded() || b.embedded()) {
      plan_embedded(plan, a, b, first(seam.sides[0]), first(seam.sides[1]));
    } else {
      bool same = a.count() == b.count() && a.closed() == b.closed();
      for (int k = 0; same && k < a.count(); ++k)
        same = std::abs(a.fraction(k) - b.fraction(k)) < 1e-9;
      if (!same) plan.why_not = "the regions beside it have different vertices on it";
    }
    plans.push_back(std::move(plan));
  }

  const auto is_free = [&](const JoinSide& j, int v) {
    return !corner[static_cast<size_t>(j.region)][static_cast<size_t>(v)];
  };
  // What the neighbours want of y at vertices where it is free.
  std::map<std::pair<int, int>, std::pair<Vec3, int>> wanted;
  for (const SeamPlan& plan : plans) {
    if (!plan.why_not.empty() || !plan.at.empty()) continue;
    for (int s = 0; s < 2; ++s) {
      const JoinSide &mine = plan.seam.sides[s], &other = plan.seam.sides[1 - s];
      const Side a = sides(mine), b = sides(other);
      for (int end = 0; end < 2; ++end) {
        const int v = a.end_vertex(end);
        if (!is_free(mine, v) || is_free(other, b.end_vertex(end))) continue;
        auto& [sum, count] = wanted.try_emplace({mine.region, v}, Vec3::Zero(), 0).first->second;
        sum -= b.across(first(other), end ? b.count() - 1 : 0);
        ++count;
      }
    }
  }

  for (SeamPlan& plan : plans) {
    if (!plan.why_not.empty() || !plan.at.empty()) continue;
    for (int end = 0; end < 2; ++end) {
      SeamEnd& at_end = plan.ends[static_cast<size_t>(end)];
      std::array<Vec3, 2> y;
      int loose = 0;
      for (int s = 0; s < 2; ++s) {
        const JoinSide& j = plan.seam.sides[s];
        const Side side = sides(j);
        const int v = side.end_vertex(end);
        y[s] = side.across(first(j), end ? side.count() - 1 : 0);
        if (!is_free(j, v)) continue;
        const auto it = wanted.find({j.region, v});
        if (it == wanted.end()) {
          ++loose;
          continue;
        }
        y[s] = it->second.first / it->second.second;
        at_end.set[static_cast<size_t>(s)] = y[s];
      }
      at_end.loose = loose > 0;
      if (loose > 0) continue;
      const Glue glue(sides(plan.seam.sides[0]).slope(end), y[0], y[1]);
      at_end.gamma = glue.gamma;
      at_end.delta = glue.delta;
      at_end.apart_deg = glue.apart_deg;
      at_end.open = !(glue.apart_deg <= most_apart_deg);
      plan.why_not = glue.wrong(end ? "at its end" : "at its start");
      if (!plan.why_not.empty()) break;
    }
  }
  return plans;
}

namespace {

// (1) at the vertices and in the middles of the edges of two runs.
void tie_runs(const SeamPlan& plan, const std::string& name, const Side& a, const Side& b, int oa,
              int ob, std::map<std::pair<int, int>, bool>& done, ConstraintSet& set) {
  double gamma[2], delta[2];
  for (int e = 0; e < 2; ++e) {
    gamma[e] = std::log(plan.ends[static_cast<size_t>(e)].gamma);
    delta[e] = plan.ends[static_cast<size_t>(e)].delta;
  }
  if (plan.constant()) {
    gamma[0] = gamma[1] = 0.5 * (gamma[0] + gamma[1]);
    delta[0] = delta[1] = 0.5 * (delta[0] + delta[1]);
  }
  const auto tie = [&](double f, const auto& add) {
    Entries row;
    add(a, 1.0, oa, row);
    add(b, std::exp(share(gamma[0], gamma[1], f)), ob, row);
    set.add(name, std::move(row), share(delta[0], delta[1], f) * a.slope(f));
  };
  const auto tie_vertex = [&](int k) {
    tie(a.fraction(k), [k](const Side& s, double factor, int o, Entries& row) {
      s.add_vertex(k, factor, o, row);
    });
  };
  const int last = a.count() - 1;
  for (int k = 1; k < last; ++k) tie_vertex(k);
  for (int k = 0; k < last; ++k)
    tie(0.5 * (a.fraction(k) + a.fraction(k + 1)),
        [k](const Side& s, double factor, int o, Entries& row) {
          s.add_middle(k, factor, o, row);
        });
  for (int e = 0; e < 2; ++e) {
    const SeamEnd& end = plan.ends[static_cast<size_t>(e)];
    const int k = e ? last : 0;
    const int va = oa + a.vertex(k), vb = ob + b.vertex(k);
    if (end.loose && done.emplace(std::minmax(va, vb), true).second) tie_vertex(k);
    for (size_t s = 0; s < 2; ++s)
      if (end.set[s] && done.emplace(std::pair(s ? vb : va, -1), true).second) {
        Entries row;
        (s ? b : a).add_vertex(k, 1, s ? ob : oa, row);
        set.add(name, std::move(row), *end.set[s]);
      }
  }
}

// (1) on the average under each hat.
void tie_hats(const SeamPlan& plan, const std::string& name, const Side& a, const Side& b, int oa,
              int ob, ConstraintSet& set) {
  const SegmentRule gauss = gauss_legendre(6);
  const auto intervals = static_cast<int>(plan.at.size()) - 1;
  // The hats at the ends of an open line reach into corners, which its lines hold already.
  const int hats = a.closed() ? intervals : intervals - 1;
  for (int h = 0; h < hats; ++h) {
    std::map<int, double> sum;
    Vec3 value = Vec3::Zero();
    double weight = 0;
    for (int half = 0; half < 2; ++half) {
      const int i = a.closed() ? (half ? h : (h + intervals - 1) % intervals) : h + half;
      const double from = plan.at[static_cast<size_t>(i)], to = plan.at[static_cast<size_t>(i) + 1];
      for (long g = 0; g < gauss.weights.size(); ++g) {
        const double s = gauss.s[g], f = from + s * (to - from);
        const double w = gauss.weights[g] * (to - from) * (half ? 1 - s : s);
        const auto between = [&](const std::vector<double>& of) {
          return share(of[static_cast<size_t>(i)], of[static_cast<size_t>(i) + 1], s);
        };
        Entries row;
        a.add_at(f, w, oa, row);
        b.add_at(f, w * between(plan.gamma), ob, row);
        for (const auto& e : row) sum[e.dof] += e.coefficient;
        value += w * between(plan.delta) * a.slope(f);
        weight += w;
      }
    }
    Entries row;
    for (const auto& [dof, coefficient] : sum) row.push_back({dof, coefficient / weight});
    set.add(name, std::move(row), value / weight);
  }
}

}  // namespace

std::vector<Points> solve_joined(const std::vector<JoinRegion>& regions,
                                 const std::vector<SeamPlan>& seams, const Vec3& origin) {
  std::vector<int> offset{0};
  for (const JoinRegion& region : regions)
    offset.push_back(offset.back() + DofMap(*region.layout->mesh()).count());
  const int n = offset.back();

  VecX ones = VecX::Zero(n);
  std::vector<SparseMatrix> blocks;
  ConstraintSet set(n);
  long entries = 0;
  for (size_t r = 0; r < regions.size(); ++r) {
    const RegionLayout& layout = *regions[r].layout;
    const SurfaceAssembler assembler(*layout.mesh(), layout.element(), layout.trim());
    for (int v = 0; v < layout.mesh()->vertex_count(); ++v)
      ones[offset[r] + assembler.dofs().vertex(v)] = 1;
    blocks.push_back(assembler.stiffness(regions[r].material));
    entries += blocks.back().nonZeros();
    const ConstraintSet lines = layout.line_constraints();
    for (const auto& row : lines.rows()) {
      std::vector<ConstraintSet::Entry> shifted = row.entries;
      for (auto& e : shifted) e.dof += offset[r];
      set.add(lines.names()[static_cast<size_t>(row.name)], std::move(shifted), row.value);
    }
  }
  SparseMatrix K(n, n);
  K.reserve(entries);
  for (size_t r = 0; r < regions.size(); ++r)
    for (int c = 0; c < blocks[r].cols(); ++c) {
      K.startVec(offset[r] + c);
      for (SparseMatrix::InnerIterator it(blocks[r], c); it; ++it)
        K.insertBack(offset[r] + it.row(), offset[r] + c) = it.value();
    }
  K.finalize();

  Sides sides(regions);
  std::map<std::pair<int, int>, bool> done;  // vertices whose y is set, pairs that are tied
  for (const SeamPlan& plan : seams) {
    if (!plan.why_not.empty()) continue;
    const std::string name = "smooth line " + plan.seam.name;
    const JoinSide &ja = plan.seam.sides[0], &jb = plan.seam.sides[1];
    const Side a = sides(ja), b = sides(jb);
    const int oa = offset[static_cast<size_t>(ja.region)],
              ob = offset[static_cast<size_t>(jb.region)];
    if (plan.at.empty())
      tie_runs(plan, name, a, b, oa, ob, done, set);
    else
      tie_hats(plan, name, a, b, oa, ob, set);
  }

  const ConstrainedSolver solver(set.moved(ones, origin), std::move(K));
  const Points all = solver.solve(Points::Zero(n, 3)) + ones * origin.transpose();
  std::vector<Points> dofs;
  for (size_t r = 0; r < regions.size(); ++r)
    dofs.push_back(all.middleRows(offset[r], offset[r + 1] - offset[r]));
  return dofs;
}

SeamAngle seam_angle(const std::vector<const SkinnedRegion*>& regions, const Seam& seam,
                     const std::array<bool, 2>& open, int samples) {
  Sides sides(regions);
  const Side side[2] = {sides(seam.sides[0]), sides(seam.sides[1])};
  const auto normal = [&](int s, double f) {
    const JoinSide& j = seam.sides[static_cast<size_t>(s)];
    const Vec3 n = regions[static_cast<size_t>(j.region)]->surface.jet(side[s].where(f)).normal();
    return Vec3(j.left ? n : -n);
  };
  std::vector<double> at = side[side[0].embedded() ? 1 : 0].stations();
  if (at.back() < 1) at.push_back(1);
  SeamAngle angle;
  double sum = 0;
  long count = 0;
  const size_t edges = at.size() - 1;
  for (size_t k = 0; k < edges; ++k)
    for (int j = 0; j <= samples; ++j) {
      const double f = share(at[k], at[k + 1], static_cast<double>(j) / samples);
      // Seen along the line, one side is to its left and the other to its right: their normals
      // agree where they point to the same side of the surface.
      const Vec3 na = normal(0, f), nb = -normal(1, f);
      const double deg = na.isZero() || nb.isZero() ? std::numeric_limits<double>::quiet_NaN()
                                                    : degrees_between(na, nb);
      const auto raise = [deg](double& most) {
        if (!(deg <= most) && !std::isnan(most)) most = deg;
      };
      raise(angle.max_deg);
      if (!(open[0] && k == 0) && !(open[1] && k + 1 == edges)) raise(angle.max_inside_deg);
      if (k == 0 && j == 0) angle.end_deg[0] = deg;
      if (k + 1 == edges && j == samples) angle.end_deg[1] = deg;
      sum += deg;
      ++count;
    }
  angle.mean_deg = count ? sum / static_cast<double>(count) : 0;
  return angle;
}

}  // namespace batten
