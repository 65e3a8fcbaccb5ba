// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/surfaces/layout_candidate.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <optional>
#include <utility>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/log.h"
#include "batten/skinning/model/model_shapes.h"
#include "batten/skinning/region/skinned_region.h"
#include "batten/skinning/surfaces/surface_defects.h"

namespace batten {
namespace {

using Domain = SkinOptions::Domain;
constexpr double kMinJacobianRatio = 0.05, kMaxAreaRatio = 2;

// A way to lay out a region.
struct LayoutVariant {
  std::string description;
  Domain domain;
  bool minimize_distortion = false;
  double edge = 1;  // factor of the requested edge length
  bool convex = false;
  bool rest = true;
};

std::vector<LayoutVariant> variants_after(const RegionRequest& request, Domain first) {
  const LayoutVariant finer{"with half the edge length", request.skin.domain, false, 0.5};
  if (request.skin.domain != Domain::Auto) return {finer};
  std::vector<LayoutVariant> variants{
      {"on a polygon with minimum distortion", Domain::Polygon, true}};
  if (first != Domain::Projected) variants.push_back({"on a projected domain", Domain::Projected});
  if (first != Domain::Developable)
    variants.push_back({"on a developable domain", Domain::Developable});
  variants.push_back(finer);
  return variants;
}

struct ScoredCandidate {
  LayoutCandidate candidate;
  int defect_score = 0;
  std::string why;  // the most serious defect, for the user
};

// Fast check whether the full search for defects is needed: strongly sheared elements, elements
// inverted against their neighbours, or a too large area.
bool suspicious(const SkinnedRegion& region, double expected_area) {
  const Surface& surface = region.surface;
  const ParametricMesh& mesh = surface.mesh();
  const Trim* trim = surface.trim().get();
  const auto n = static_cast<size_t>(mesh.triangle_count());
  std::vector<Vec3> middle(n, Vec3::Zero());
  std::vector<double> sizes;
  double least = std::numeric_limits<double>::infinity(), area = 0;
  for (int t = 0; t < mesh.triangle_count(); ++t) {
    poll_every<2048>(t);
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
  std::nth_element(sizes.begin(), sizes.begin() + isize(sizes) / 2, sizes.end());
  constexpr double kLow = 0.15, kLarge = 1.8;  // stricter than the limits of a defect
  if (!(least > kLow * sizes[sizes.size() / 2])) return true;
  if (expected_area > 0 && area > kLarge * expected_area) return true;
  return std::any_of(mesh.edges().begin(), mesh.edges().end(), [&](const auto& edge) {
    if (edge.triangle[1] < 0) return false;
    const Vec3 &a = middle[edge.triangle[0]], &b = middle[edge.triangle[1]];
    return a.dot(b) < 0.5 * a.norm() * b.norm();  // angle above 60 degrees
  });
}

std::pair<int, const char*> defect_score_of(SurfaceDefect::Kind kind) {
  using Kind = SurfaceDefect::Kind;
  if (kind == Kind::Jacobian) return {4, "it is inverted"};
  if (kind == Kind::Fold) return {2, "it is folded"};
  if (kind == Kind::Crossing) return {2, "it intersects itself"};
  return {1, "its area is too large"};
}

// Scores the defects of a region on its own. Skipped for convex polygon layouts: their initial
// shape is not final.
void score(ScoredCandidate& made) {
  const double expected_area = made.candidate.expected_area;
  const RegionLayout& layout = *made.candidate.layout;
  if (made.candidate.strategy.skin.convex && layout.domain() == Domain::Polygon) return;
  const SkinnedRegion region = layout.region(made.candidate.shape);
  if (layout.embedded().empty() && !suspicious(region, expected_area)) return;
  SkinQuality quality = measure(region.surface);
  quality.max_line_gap = line_gap(region);
  constexpr double kFarOff = 20;  // times the expected area: the surface is unrelated to its lines
  if (!std::isfinite(quality.area) || (expected_area > 0 && quality.area > kFarOff * expected_area))
    throw NoSolutionError("the surface deviates far from its curves");
  const auto add = [&](int defect_score, const std::string& why) {
    made.defect_score += defect_score;
    if (made.why.empty()) made.why = why;
  };
  for (const SurfaceDefect& defect : find_defects({&region}, {quality}, {expected_area})) {
    const auto [defect_score, why] = defect_score_of(defect.kind);
    add(defect_score, why);
  }
  if (quality.min_jacobian_ratio < kMinJacobianRatio) add(1, "it is nearly inverted");
  if (quality.max_line_gap > layout.tolerance()) add(1, "it deviates from its curves");
}

RegionLayout layout_of(const RegionRequest& request, const LayoutStrategy& strategy) {
  std::vector<CharacterLine> lines = request.lines;
  if (!strategy.inner) lines.resize(lines.size() - static_cast<size_t>(request.inner));
  return {request.name, lines, strategy.skin};
}

LayoutCandidate laid_out(const RegionRequest& request, const SkinOptions& skin, bool inner,
                         const ModelMetadata& metadata, const SurfaceStiffness& material) {
  RegionLayout layout = layout_of(request, {skin, inner});
  // The mesh suits the shape of minimum bending without a rest shape; embedded lines may need more.
  constexpr int kMaxRounds = 8;
  double gap = std::numeric_limits<double>::infinity();
  for (int round = 0;; ++round) {
    LayoutCandidate candidate{std::make_shared<const RegionLayout>(layout),
                              {},
                              {},
                              {skin, inner},
                              {},
                              request.filling_area};
    const ModelLayout alone(metadata, {candidate.layout}, {});
    candidate.rest = rest_dofs(alone);
    if (request.filling_area > 0)
      candidate.expected_area =
          std::max(request.filling_area, reliable_rest_area(*candidate.layout, candidate.rest));
    candidate.shape = alone.minimize_energy(material, candidate.rest);
    if (layout.embedded().empty() || round == kMaxRounds) return candidate;
    const SkinnedRegion made = layout.region(candidate.shape);
    const double before = std::exchange(gap, line_gap(made));
    if (gap <= 0.9 * layout.tolerance() || !(gap < before) ||
        !layout.refine(made.surface, 0.5 * layout.tolerance()))
      return candidate;
  }
}

class CandidateSearch {
 public:
  CandidateSearch(const RegionRequest& request, const ModelMetadata& metadata,
                  const SurfaceStiffness& material)
      : request_(request), metadata_(metadata), material_(material) {}

  LayoutCandidate best() {
    for (const bool inner : {true, false}) {
      if (!inner && request_.inner == 0) break;
      if (attempt_both({"", request_.skin.domain}, inner)) return taken();
      const Domain first = best_ && best_->candidate.strategy.inner == inner
                               ? best_->candidate.layout->domain()
                               : Domain::Auto;
      const LayoutVariant convex{"on a convex polygon", request_.skin.domain, false, 1, true};
      if (request_.skin.convex && first != Domain::Polygon && attempt(convex, inner))
        return taken();
      for (const LayoutVariant& strategy : variants_after(request_, first))
        if (attempt_both(strategy, inner)) return taken();
    }
    if (!best_) std::rethrow_exception(first_error_);
    return taken();
  }

 private:
  // Tries a layout with its rest shape and, if the defects may be due to that, without. An area
  // that is merely too large is no reason.
  bool attempt_both(LayoutVariant strategy, bool inner) {
    if (attempt(strategy, inner)) return true;
    constexpr int kSeriousDefect = 2;
    if (!last_has_rest_shape_ || last_defect_score_ < kSeriousDefect) return false;
    strategy.rest = false;
    strategy.description = strategy.description.empty()
                               ? "without reference configuration"
                               : strategy.description + " without reference configuration";
    return attempt(strategy, inner);
  }

  // Tries one layout. Returns true if it has no defects.
  bool attempt(const LayoutVariant& strategy, bool inner) {
    if (best_ && spent_ > request_.max_triangles && !strategy.description.empty()) return false;
    ++count_;
    std::string why;
    last_has_rest_shape_ = false;
    try {
      SkinOptions skin = request_.skin;
      skin.domain = strategy.domain;
      skin.minimize_distortion = strategy.minimize_distortion;
      skin.convex = strategy.convex;
      skin.rest = strategy.rest;
      skin.edge_length *= strategy.edge;
      ScoredCandidate made{laid_out(request_, skin, inner, metadata_, material_), 0, ""};
      score(made);
      if (!inner) ++made.defect_score;
      why = made.why;
      spent_ += made.candidate.layout->mesh()->triangle_count();
      const bool well = made.defect_score == (inner ? 0 : 1);
      last_has_rest_shape_ = made.candidate.rest.rows() > 0;
      last_defect_score_ = made.defect_score;
      if (!best_ || made.defect_score < best_->defect_score) {
        best_ = std::move(made);
        best_variant_ = strategy.description;
      }
      if (well) return true;
    } catch (const CancelledError&) {
      throw;
    } catch (const std::runtime_error& e) {
      why = e.what();
      spent_ += kTrianglesALine * isize(request_.lines);
      if (!first_error_) first_error_ = std::current_exception();
    }
    if (count_ == 1) first_why_ = why;
    return false;
  }

  LayoutCandidate taken() {
    LayoutCandidate candidate = std::move(best_->candidate);
    candidate.strategy.defect_score = best_->defect_score;
    const int left = candidate.strategy.inner ? 0 : 1;
    if (!candidate.strategy.inner)
      candidate.warnings.push_back("its inner curves are ignored: " + first_why_);
    if (best_->defect_score > left)
      candidate.warnings.push_back(std::to_string(count_) +
                                   " layouts were tried; the best has a defect: " + best_->why);
    else if (candidate.strategy.inner && !best_variant_.empty())
      log(LogLevel::Info, [&] {
        return "'" + request_.name + "' is laid out " + best_variant_ +
               ", because the default layout failed: " + first_why_;
      });
    return candidate;
  }

  const RegionRequest& request_;
  const ModelMetadata& metadata_;
  const SurfaceStiffness& material_;
  static constexpr int kTrianglesALine = 60;  // approximate cost of a failed attempt
  int count_ = 0, spent_ = 0;
  bool last_has_rest_shape_ = false;  // whether the last attempt had a rest shape
  int last_defect_score_ = 0;
  std::optional<ScoredCandidate> best_;
  std::string best_variant_, first_why_;
  std::exception_ptr first_error_;
};

}  // namespace

bool is_inverted_or_sagging(const SkinnedRegion& region, double expected_area) {
  if (!suspicious(region, expected_area)) return false;
  const SkinQuality quality = measure(region.surface);
  return !(quality.min_jacobian_ratio >= kMinJacobianRatio) ||
         (expected_area > 0 && quality.area > kMaxAreaRatio * expected_area);
}

LayoutCandidate best_layout(const RegionRequest& request, const ModelMetadata& metadata,
                            const SurfaceStiffness& material) {
  return CandidateSearch(request, metadata, material).best();
}

std::shared_ptr<const RegionLayout> lay_out(const RegionRequest& request,
                                            const LayoutStrategy& strategy) {
  return std::make_shared<const RegionLayout>(layout_of(request, strategy));
}

std::optional<LayoutCandidate> try_other_domain(const RegionRequest& request, Domain was,
                                                const ModelMetadata& metadata,
                                                const SurfaceStiffness& material) {
  if (request.skin.domain != Domain::Auto) return std::nullopt;
  for (const Domain next : {Domain::Projected, Domain::Developable}) {
    if (was != Domain::Polygon && !(was == Domain::Projected && next == Domain::Developable))
      continue;
    SkinOptions skin = request.skin;
    skin.domain = next;
    skin.convex = false;
    try {
      ScoredCandidate made{laid_out(request, skin, true, metadata, material), 0, ""};
      score(made);
      if (made.defect_score > 0) continue;
      made.candidate.warnings.push_back(
          std::string("it is laid out on a ") +
          (next == Domain::Projected ? "projected" : "developable") +
          " domain: with the default layout it would be inverted or bulge at smooth edges");
      return std::move(made.candidate);
    } catch (const CancelledError&) {
      throw;
    } catch (const std::runtime_error&) {  // try the next one
    }
  }
  return std::nullopt;
}

std::optional<LayoutCandidate> retry_layout(const RegionRequest& request,
                                            const LayoutStrategy& strategy,
                                            const ModelMetadata& metadata,
                                            const SurfaceStiffness& material) {
  ScoredCandidate made{laid_out(request, strategy.skin, strategy.inner, metadata, material),
                       strategy.inner ? 0 : 1, ""};
  try {
    score(made);
  } catch (const NoSolutionError&) {  // the surface deviates far from its curves
    return std::nullopt;
  }
  if (made.defect_score > strategy.defect_score) return std::nullopt;
  made.candidate.strategy.defect_score = made.defect_score;
  return std::move(made.candidate);
}

}  // namespace batten
