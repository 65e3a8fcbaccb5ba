#include "batten/skinning/surfaces/region_trials.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <optional>
#include <utility>

#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/core/words.h"
#include "batten/skinning/model/rest_shape.h"
#include "batten/skinning/region/quality.h"
#include "batten/skinning/surfaces/wrong_surfaces.h"

namespace batten {
namespace {

using Domain = SkinOptions::Domain;
constexpr double kLeastJacobian = 0.05, kMostArea = 2;

// One way to lay a region out.
struct Way {
  std::string word;
  Domain domain;
  bool settle = false;
  double edge = 1;  // times the edge length that was asked for
  bool convex = false;
  bool rest = true;
};

std::vector<Way> ways_after(const RegionWish& wish, Domain first) {
  const Way finer{"with edges half as long", wish.skin.domain, false, 0.5};
  if (wish.skin.domain != Domain::Auto) return {finer};
  std::vector<Way> ways{{"as a settled polygon", Domain::Polygon, true}};
  if (first != Domain::Plane) ways.push_back({"on a plane", Domain::Plane});
  if (first != Domain::Sheet) ways.push_back({"as a sheet", Domain::Sheet});
  ways.push_back(finer);
  return ways;
}

struct Made {
  RegionTrial trial;
  int evil = 0;
  std::string why;  // the worst of it, for the user
};

// Whether a closer look is worth its time: elements that are sheared flat or turned against their
// neighbours, an area that is too large.
bool suspicious(const SkinnedRegion& region, double plain_area) {
  const Surface& surface = region.surface;
  const ParametricMesh& mesh = surface.mesh();
  const Trim* trim = surface.trim().get();
  const auto n = static_cast<size_t>(mesh.triangle_count());
  std::vector<Vec3> middle(n, Vec3::Zero());
  std::vector<double> sizes;
  double least = std::numeric_limits<double>::infinity(), area = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    if (trim && trim->side(t) == Trim::Side::Outside) continue;
    middle[t] = surface.area_vector({t, Vec3::Constant(1.0 / 3)});
    const double size = middle[t].norm();
    sizes.push_back(size);
    area += size * mesh.shape(t).area;
    for (int k = 0; k < 3; ++k) {
      const Vec3 corner = surface.area_vector({t, Vec3::Unit(k)});
      least = std::min(least, corner.dot(middle[t]) / size);
    }
  }
  if (sizes.empty() || !std::isfinite(area)) return true;
  std::nth_element(sizes.begin(), sizes.begin() + count_of(sizes) / 2, sizes.end());
  constexpr double low = 0.15, large = 1.8;  // above what is a flaw
  if (!(least > low * sizes[sizes.size() / 2])) return true;
  if (plain_area > 0 && area > large * plain_area) return true;
  return std::any_of(mesh.edges().begin(), mesh.edges().end(), [&](const auto& edge) {
    if (edge.triangle[1] < 0) return false;
    const Vec3 &a = middle[edge.triangle[0]], &b = middle[edge.triangle[1]];
    return a.dot(b) < 0.5 * a.norm() * b.norm();  // by more than 60 degrees
  });
}

std::pair<int, const char*> evil_of(SurfaceFlaw::Kind kind) {
  using Kind = SurfaceFlaw::Kind;
  if (kind == Kind::Jacobian) return {4, "it turns over"};
  if (kind == Kind::Fold) return {2, "it folds"};
  if (kind == Kind::Crossing) return {2, "it passes through itself"};
  return {1, "it sags"};
}

// What is wrong with a region by itself. The first shape of one that will be drawn to a face says nothing.
void judge(Made& made, double plain_area) {
  const RegionLayout& layout = *made.trial.layout;
  if (made.trial.way.skin.convex && layout.domain() == Domain::Polygon) return;
  const SkinnedRegion region = layout.region(made.trial.shape);
  if (layout.embedded().empty() && !suspicious(region, plain_area)) return;
  SkinQuality quality = measure(region.surface);
  for (const EmbeddedLine& line : region.embedded)
    quality.max_line_gap = std::max(quality.max_line_gap, line_gap(region.surface, line));
  constexpr double far_off = 20;  // plain fillings: this is no surface in these lines any more
  if (!std::isfinite(quality.area) || (plain_area > 0 && quality.area > far_off * plain_area))
    throw NoSolutionError("the surface runs far away from its lines");
  const auto add = [&](int evil, const std::string& why) {
    made.evil += evil;
    if (made.why.empty()) made.why = why;
  };
  for (const SurfaceFlaw& flaw : find_flaws({&region}, {quality}, {plain_area})) {
    const auto [evil, why] = evil_of(flaw.kind);
    add(evil, why);
  }
  if (quality.min_jacobian_ratio < kLeastJacobian) add(1, "it nearly turns over");
  if (quality.max_line_gap > layout.tolerance()) add(1, "it misses its lines");
}

RegionLayout layout_of(const RegionWish& wish, const RegionWay& way) {
  std::vector<CharacterLine> lines = wish.lines;
  if (!way.inner) lines.resize(lines.size() - static_cast<size_t>(wish.inner));
  return {wish.name, lines, way.skin, wish.progress};
}

RegionTrial laid_out(const RegionWish& wish, const SkinOptions& skin, bool inner,
                     const ModelFrame& frame, const SurfaceStiffness& material) {
  RegionLayout layout = layout_of(wish, {skin, inner});
  // Its mesh suits the shape that bends least from nothing: embedded lines may ask for more.
  constexpr int most_rounds = 8;
  double gap = std::numeric_limits<double>::infinity();
  for (int round = 0;; ++round) {
    RegionTrial trial{std::make_shared<const RegionLayout>(layout), {}, {}, {skin, inner}, {}};
    const ModelLayout alone(frame, {trial.layout}, {});
    trial.rest = rest_dofs(alone);
    trial.shape = alone.least_energy(material, trial.rest);
    if (layout.embedded().empty() || round == most_rounds) return trial;
    const SkinnedRegion made = layout.region(trial.shape);
    const double before = std::exchange(gap, 0);
    for (const EmbeddedLine& line : made.embedded)
      gap = std::max(gap, line_gap(made.surface, line));
    if (gap <= 0.9 * layout.tolerance() || !(gap < before) ||
        !layout.refine(made.surface, 0.5 * layout.tolerance()))
      return trial;
  }
}

class Trials {
 public:
  Trials(const RegionWish& wish, const ModelFrame& frame, const SurfaceStiffness& material)
      : wish_(wish), frame_(frame), material_(material) {}

  RegionTrial best() {
    for (const bool inner : {true, false}) {
      if (!inner && wish_.inner == 0) break;
      if (attempt_both({"", wish_.skin.domain}, inner)) return taken();
      const Domain first =
          best_ && best_->trial.way.inner == inner ? best_->trial.layout->domain() : Domain::Auto;
      const Way convex{"with corners as its face has them", wish_.skin.domain, false, 1, true};
      if (wish_.skin.convex && first != Domain::Polygon && attempt(convex, inner)) return taken();
      for (const Way& way : ways_after(wish_, first))
        if (attempt_both(way, inner)) return taken();
    }
    if (!best_) std::rethrow_exception(first_error_);
    return taken();
  }

 private:
  // With the sweep between its sides and, since that may be what is wrong, without; but not where the
  // surface is only large.
  bool attempt_both(Way way, bool inner) {
    if (attempt(way, inner)) return true;
    constexpr int wrong = 2;
    if (!last_rests_ || last_evil_ < wrong) return false;
    way.rest = false;
    way.word = way.word.empty() ? "by least bending from nothing"
                                : way.word + ", by least bending from nothing";
    return attempt(way, inner);
  }

  // Whether there is nothing wrong with it.
  bool attempt(const Way& way, bool inner) {
    if (best_ && spent_ > wish_.most_triangles && !way.word.empty()) return false;
    ++count_;
    std::string why;
    last_rests_ = false;
    try {
      SkinOptions skin = wish_.skin;
      skin.domain = way.domain;
      skin.settle = way.settle;
      skin.convex = way.convex;
      skin.rest = way.rest;
      skin.edge_length *= way.edge;
      Made made{laid_out(wish_, skin, inner, frame_, material_), 0, ""};
      judge(made, wish_.plain_area);
      if (!inner) ++made.evil;
      why = made.why;
      spent_ += made.trial.layout->mesh()->triangle_count();
      const bool well = made.evil == (inner ? 0 : 1);
      last_rests_ = made.trial.rest.rows() > 0;
      last_evil_ = made.evil;
      if (!best_ || made.evil < best_->evil) {
        best_ = std::move(made);
        best_way_ = way.word;
      }
      if (well) return true;
    } catch (const CancelledError&) {
      throw;
    } catch (const std::runtime_error& e) {
      why = e.what();
      spent_ += triangles_a_line * count_of(wish_.lines);
      if (!first_error_) first_error_ = std::current_exception();
    }
    if (count_ == 1) first_why_ = why;
    return false;
  }

  RegionTrial taken() {
    RegionTrial trial = std::move(best_->trial);
    trial.way.evil = best_->evil;
    const int left = trial.way.inner ? 0 : 1;
    if (!trial.way.inner) trial.warnings.push_back("its inner lines are left out: " + first_why_);
    if (best_->evil > left)
      trial.warnings.push_back(std::to_string(count_) +
                               " ways to make it were tried, and in the best " + best_->why);
    else if (trial.way.inner && !best_way_.empty())
      trial.warnings.push_back("it is made " + best_way_ +
                               ", since the usual way failed: " + first_why_);
    return trial;
  }

  const RegionWish& wish_;
  const ModelFrame& frame_;
  const SurfaceStiffness& material_;
  static constexpr int triangles_a_line = 60;  // of a region that failed, about
  int count_ = 0, spent_ = 0;
  bool last_rests_ = false;  // of the last attempt: whether it had a rest shape
  int last_evil_ = 0;
  std::optional<Made> best_;
  std::string best_way_, first_why_;
  std::exception_ptr first_error_;
};

}  // namespace

bool turns_or_sags(const SkinnedRegion& region, double plain_area) {
  if (!suspicious(region, plain_area)) return false;
  const SkinQuality quality = measure(region.surface);
  return !(quality.min_jacobian_ratio >= kLeastJacobian) ||
         (plain_area > 0 && quality.area > kMostArea * plain_area);
}

RegionTrial try_region(const RegionWish& wish, const ModelFrame& frame,
                       const SurfaceStiffness& material) {
  return Trials(wish, frame, material).best();
}

std::shared_ptr<const RegionLayout> lay_out(const RegionWish& wish, const RegionWay& way) {
  return std::make_shared<const RegionLayout>(layout_of(wish, way));
}

std::optional<RegionTrial> try_other(const RegionWish& wish, Domain was, const ModelFrame& frame,
                                     const SurfaceStiffness& material) {
  if (wish.skin.domain != Domain::Auto) return std::nullopt;
  for (const Domain next : {Domain::Plane, Domain::Sheet}) {
    if (was != Domain::Polygon && !(was == Domain::Plane && next == Domain::Sheet)) continue;
    SkinOptions skin = wish.skin;
    skin.domain = next;
    skin.convex = false;
    try {
      Made made{laid_out(wish, skin, true, frame, material), 0, ""};
      judge(made, wish.plain_area);
      if (made.evil > 0) continue;
      made.trial.warnings.push_back(std::string("it is made ") +
                                    (next == Domain::Plane ? "on a plane" : "as a sheet") +
                                    ": in the usual way it would turn over or sag where it goes on "
                                    "smoothly in its neighbours");
      return std::move(made.trial);
    } catch (const CancelledError&) {
      throw;
    } catch (const std::runtime_error&) {  // the next one, then
    }
  }
  return std::nullopt;
}

std::optional<RegionTrial> try_again(const RegionWish& wish, const RegionWay& way,
                                     const ModelFrame& frame, const SurfaceStiffness& material) {
  Made made{laid_out(wish, way.skin, way.inner, frame, material), way.inner ? 0 : 1, ""};
  try {
    judge(made, wish.plain_area);
  } catch (const NoSolutionError&) {  // it ran far away
    return std::nullopt;
  }
  if (made.evil > way.evil) return std::nullopt;
  made.trial.way.evil = made.evil;
  return std::move(made.trial);
}

}  // namespace batten
