// Edits of a model's layout: made on copies of the regions, which take their places when nothing
// was thrown.
#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/fem/surface_projector.h"
#include "batten/fem/surface_transfer.h"
#include "batten/skinning/model/model_layout.h"

namespace batten {
namespace {

using Marks = std::vector<std::vector<char>>;

// Marks the triangles at edges of one run that another run of the same line has halved.
void mark_longer_edges(const RegionLayout& mine, const EdgeAlignedLine& aligned_line,
                       const EdgeAlignedLine& other, std::vector<char>& marks) {
  constexpr double kSameTolerance = 1e-9;
  const double near =
      kSameTolerance * (aligned_line.parameters.back() - aligned_line.parameters.front());
  for (size_t k = 0; k + 1 < aligned_line.parameters.size(); ++k) {
    const auto inside =
        std::find_if(other.parameters.begin(), other.parameters.end(), [&](double t) {
          return t > aligned_line.parameters[k] + near && t < aligned_line.parameters[k + 1] - near;
        });
    if (inside == other.parameters.end()) continue;
    const auto& edge = mine.mesh()->edges()[aligned_line.edges[k]];
    marks[edge.triangle[0]] = 1;
  }
}

}  // namespace

bool ModelLayout::refine(const std::vector<char>& marked) {
  if (isize(marked) != mesh_->triangle_count())
    throw InputError(std::to_string(marked.size()) + " marks for " +
                     std::to_string(mesh_->triangle_count()) + " triangles");
  ModelLayout finer = *this;
  Marks marks;
  for (int r = 0; r < region_count(); ++r)
    marks.emplace_back(marked.begin() + first_triangle(r), marked.begin() + first_triangle(r + 1));
  bool any = false;
  // Halves of halves: each round brings the sides of a line nearer to each other.
  constexpr int kMaxRounds = 60;
  for (int round = 0;; ++round) {
    bool halved = false;
    for (int r = 0; r < region_count(); ++r) {
      auto& region = finer.regions_[r];
      RegionLayout copy = *region;
      if (!copy.refine(marks[r])) continue;
      region = std::make_shared<const RegionLayout>(std::move(copy));
      halved = true;
    }
    any = any || halved;
    if (!halved) break;
    if (round == kMaxRounds)
      throw InputError("the regions of model '" + name() + "' cannot be refined alike");
    for (int r = 0; r < region_count(); ++r)
      marks[r].assign(static_cast<size_t>(finer.region(r).mesh()->triangle_count()), 0);
    for (const ModelLine& line : lines_)
      for (const LineSide& a : line.sides)
        for (const LineSide& b : line.sides) {
          if (a.embedded || b.embedded || (a.region == b.region && a.index == b.index)) continue;
          mark_longer_edges(finer.region(a.region), finer.region(a.region).edge_aligned()[a.index],
                            finer.region(b.region).edge_aligned()[b.index], marks[a.region]);
        }
  }
  if (!any) return false;
  finer.assign_dof_offsets();
  *this = std::move(finer);
  return true;
}

void ModelLayout::set_line(const std::string& name, const HermiteCurve& curve) {
  const ModelLine& line = model_line(name);
  ModelLayout changed = *this;
  for (const LineSide& side : line.sides) {
    auto& region = changed.regions_[side.region];
    RegionLayout copy = *region;
    copy.set_line(name, against(line, side) ? curve.backwards() : curve);
    region = std::make_shared<const RegionLayout>(std::move(copy));
  }
  *this = std::move(changed);
}

void ModelLayout::add_inner_line(const CharacterLine& line, const Points& shape) {
  if (has_line(line.name)) throw InputError("two lines have the name '" + line.name + "'");
  int nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int r = 0; r < region_count() && region_count() > 1 && line.curve; ++r) {
    const Surface surface = skinned(r, shape).surface;
    const SurfaceProjector projector(surface);
    double farthest = 0;
    constexpr int kSamples = 16;
    for (int i = 0; i <= kSamples; ++i) {
      const double t =
          line.curve->start() + (line.curve->end() - line.curve->start()) * i / kSamples;
      farthest = std::max(farthest, projector.nearest(line.curve->evaluate(t)).distance);
    }
    if (!(farthest < least)) continue;
    least = farthest;
    nearest = r;
  }
  RegionLayout copy = region(nearest);
  copy.add_inner_line(
      line, Surface(copy.mesh(), copy.element(), region_dofs(nearest, shape), copy.trim()));
  regions_[nearest] = std::make_shared<const RegionLayout>(std::move(copy));
  assign_dof_offsets();
}

void ModelLayout::remove_inner_line(const std::string& name) {
  if (region_count() > 1 && model_line(name).sides.size() > 1)
    throw InputError("line '" + name + "' cannot be taken out: it bounds regions");
  const int r = region_count() == 1 ? 0 : model_line(name).sides.front().region;
  RegionLayout copy = region(r);
  copy.remove_inner_line(name);
  regions_[r] = std::make_shared<const RegionLayout>(std::move(copy));
  assign_dof_offsets();
}

void ModelLayout::plan_joins(const Points& shape) {
  std::vector<JoinLine> join_lines;
  std::vector<size_t> index;
  for (size_t s = 0; s < join_plans_.size(); ++s) {
    if (join_plans_[s].rejected()) continue;
    join_lines.push_back(join_plans_[s].join_line);
    index.push_back(s);
  }
  const auto plans =
      batten::plan_joins(layouts(), of_regions(shape), join_lines, metadata_.max_plane_angle_deg);
  for (size_t i = 0; i < plans.size(); ++i) {
    const JoinPlan was = std::move(join_plans_[index[i]]);
    join_plans_[index[i]] = plans[i];
    for (size_t e = 0; e < 2; ++e)
      if (was.ends[e].creased) join_plans_[index[i]].ends[e] = was.ends[e];
  }
}

void ModelLayout::reject_join(const std::string& line, const std::string& why) {
  for (JoinPlan& plan : join_plans_)
    if (plan.join_line.name == line) plan.rejection_reason = why;
}

double ModelLayout::gluing_change(const Points& shape) const {
  ModelLayout anew = *this;
  anew.plan_joins(shape);
  double misfit = 0;
  for (size_t s = 0; s < join_plans_.size(); ++s) {
    const JoinPlan &was = join_plans_[s], &is = anew.join_plans_[s];
    if (was.rejected() || !was.at.empty()) continue;
    if (is.rejected()) return std::numeric_limits<double>::infinity();
    for (size_t e = 0; e < 2; ++e) {
      const JoinEnd &old = was.ends[e], &now = is.ends[e];
      if (old.open != now.open) return std::numeric_limits<double>::infinity();
      if (old.open || old.undetermined) continue;
      misfit = std::max({misfit, std::abs(now.gamma / old.gamma - 1),
                         std::abs(now.delta - old.delta) / (1 + std::abs(old.delta))});
    }
  }
  return misfit;
}

}  // namespace batten
