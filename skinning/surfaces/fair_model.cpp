#include "batten/skinning/surfaces/fair_model.h"

#include <algorithm>
#include <set>

#include "batten/core/errors.h"
#include "batten/skinning/surfaces/skin_network.h"

namespace batten {
namespace {

using FlawKey = std::pair<SurfaceFlaw::Kind, std::vector<int>>;

FlawKey key_of(const SurfaceFlaw& flaw) {
  std::vector<int> regions = flaw.regions;
  std::sort(regions.begin(), regions.end());
  return {flaw.kind, std::move(regions)};
}

class ModelFairing {
 public:
  ModelFairing(const SurfaceModel& model, std::shared_ptr<const ModelLayout> layout,
               const Points& start)
      : model_(model), layout_(std::move(layout)), start_(start) {
    const bool measured =
        model_.layout == layout_ && model_.dofs.rows() == start.rows() && model_.dofs == start;
    if (!measured) take(start);
    for (const SurfaceFlaw& flaw : model_.flaws) {
      had_.insert(key_of(flaw));
      if (flaw.kind == SurfaceFlaw::Kind::Jacobian) keep(flaw, "its bending shape turns over");
    }
  }

  FairedModel run(VariationOptions options, const Progress& progress) {
    const ConstraintSet constraints = layout_->line_constraints();
    for (;;) {
      if (count_of(faired_.kept) == layout_->region_count())
        throw NoSolutionError(faired_.kept.front().why);
      if (!faired_.kept.empty()) options.still = still();
      try {
        faired_.surface = fair_shape(*layout_, start_, constraints, options, progress);
      } catch (const NoSolutionError&) {
        if (!keep_all_flawed()) throw;
        continue;
      }
      take(faired_.surface.dofs);
      if (!keep_spoiled()) return std::move(faired_);
    }
  }

 private:
  void take(const Points& dofs) {
    std::vector<SkinnedRegion> regions;
    for (int r = 0; r < layout_->region_count(); ++r) regions.push_back(layout_->skinned(r, dofs));
    reshape(model_, layout_, dofs, std::move(regions));
  }

  // Whether any of its regions was not kept before.
  bool keep(const SurfaceFlaw& flaw, const std::string& why) {
    bool any = false;
    for (const int r : flaw.regions) {
      const int own = model_.regions[r].in_layout;
      const bool known = std::any_of(faired_.kept.begin(), faired_.kept.end(),
                                     [&](const KeptRegion& kept) { return kept.region == own; });
      if (!known) faired_.kept.push_back({own, why});
      any = any || !known;
    }
    return any;
  }

  // Curvature may be too large there for any step.
  bool keep_all_flawed() {
    if (tried_flawed_) return false;
    tried_flawed_ = true;
    bool any = false;
    for (const SurfaceFlaw& flaw : model_.flaws)
      any = keep(flaw, "its bending shape is wrong: " + flaw.text) || any;
    return any;
  }

  bool keep_spoiled() {
    bool any = false;
    for (const SurfaceFlaw& flaw : model_.flaws)
      if (!had_.count(key_of(flaw)))
        any = keep(flaw, "it would come out wrong: " + flaw.text) || any;
    return any;
  }

  std::vector<char> still() const {
    std::vector<char> triangles(layout_->mesh()->triangle_count(), 0);
    for (const KeptRegion& kept : faired_.kept)
      std::fill_n(triangles.begin() + layout_->first_triangle(kept.region),
                  layout_->region(kept.region).mesh()->triangle_count(), 1);
    return triangles;
  }

  SurfaceModel model_;
  std::shared_ptr<const ModelLayout> layout_;
  const Points& start_;
  FairedModel faired_;
  std::set<FlawKey> had_;
  bool tried_flawed_ = false;
};

}  // namespace

FairedModel fair_model(const SurfaceModel& model, std::shared_ptr<const ModelLayout> layout,
                       const Points& start, const VariationOptions& options,
                       const Progress& progress) {
  return ModelFairing(model, std::move(layout), start).run(options, progress);
}

}  // namespace batten
