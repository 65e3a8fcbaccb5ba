// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/model/model_layout.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "batten/constraints/constrained_solver.h"
#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/fem/parametric_mesh.h"
#include "batten/fem/refinement.h"
#include "batten/fem/surface_assembler.h"
#include "batten/fem/surface_projector.h"

namespace batten {

ModelLayout::ModelLayout(RegionLayout region)
    : metadata_{region.name(), region.size(), region.tolerance(), region.origin()},
      regions_{std::make_shared<const RegionLayout>(std::move(region))} {
  assign_dof_offsets();
}

ModelLayout::ModelLayout(ModelMetadata metadata,
                         std::vector<std::shared_ptr<const RegionLayout>> regions,
                         std::vector<JoinPlan> join_lines)
    : metadata_(std::move(metadata)),
      regions_(std::move(regions)),
      join_plans_(std::move(join_lines)) {
  if (regions_.empty()) throw InputError("model '" + metadata_.name + "' has no faces");
  for (const auto& region : regions_)
    if (region->element() != element())
      throw InputError("all faces of model '" + metadata_.name +
                       "' must have the same type of element");
  assign_dof_offsets();
}

void ModelLayout::assign_dof_offsets() {
  dof_offsets_.clear();
  first_triangle_ = {0};
  std::vector<const ParametricMesh*> meshes;
  std::vector<const Trim*> trims;
  int vertices = 0, edges = 0;
  bool trimmed = false;
  for (const auto& region : regions_) {
    const ParametricMesh& mesh = *region->mesh();
    meshes.push_back(&mesh);
    trims.push_back(region->trim().get());
    trimmed = trimmed || region->trim();
    dof_offsets_.push_back(
        {3 * mesh.vertex_count(), 3 * vertices, edges - 3 * mesh.vertex_count()});
    vertices += mesh.vertex_count();
    edges += mesh.edge_count();
    first_triangle_.push_back(first_triangle_.back() + mesh.triangle_count());
  }
  for (DofOffsets& n : dof_offsets_) n.edges += 3 * vertices;
  if (regions_.size() == 1) {
    mesh_ = region(0).mesh();
    trim_ = region(0).trim();
  } else {
    mesh_ = std::make_shared<const ParametricMesh>(ParametricMesh::concatenated(meshes));
    trim_ = trimmed ? std::make_shared<const Trim>(Trim::concatenated(trims, meshes)) : nullptr;
  }
  domain_scale_ = VecX();
  if (std::any_of(regions_.begin(), regions_.end(),
                  [&](const auto& region) { return region->size() != size(); })) {
    domain_scale_.resize(first_triangle_.back());
    for (int r = 0; r < region_count(); ++r) {
      const double ratio = region(r).size() / size();
      domain_scale_.segment(first_triangle(r), region(r).mesh()->triangle_count())
          .setConstant(ratio * ratio);
    }
  }

  lines_.clear();
  std::map<std::string, size_t> index;
  const auto add = [&](const std::string& name, const LineSide& side) {
    const auto [it, fresh] = index.emplace(name, lines_.size());
    if (fresh) lines_.push_back({name, {}});
    lines_[it->second].sides.push_back(side);
  };
  for (int r = 0; r < region_count(); ++r) {
    for (size_t i = 0; i < region(r).edge_aligned().size(); ++i)
      add(region(r).edge_aligned()[i].line.name, {r, false, static_cast<int>(i)});
    for (size_t i = 0; i < region(r).embedded().size(); ++i)
      add(region(r).embedded()[i].line.name, {r, true, static_cast<int>(i)});
  }
  for (ModelLine& line : lines_)
    std::stable_partition(line.sides.begin(), line.sides.end(),
                          [](const LineSide& side) { return !side.embedded; });
}

namespace {

[[noreturn]] void no_such(const std::string& who, const std::string& what, const std::string& name,
                          const std::vector<std::string>& names) {
  throw InputError(who + " has no " + what + " '" + name + "'" + did_you_mean(name, names));
}

}  // namespace

int ModelLayout::region_named(const std::string& name) const {
  std::vector<std::string> names;
  for (int r = 0; r < region_count(); ++r) {
    if (region(r).name() == name) return r;
    names.push_back(region(r).name());
  }
  no_such("model '" + this->name() + "'", "face", name, names);
}

std::vector<std::string> ModelLayout::warnings() const {
  if (region_count() == 1) return region(0).warnings();
  std::vector<std::string> all;
  for (const auto& region : regions_)
    for (const std::string& warning : region->warnings())
      all.push_back("face '" + region->name() + "': " + warning);
  return all;
}

// -- lines ----------------------------------------------------------------------------------------

bool ModelLayout::has_line(const std::string& name) const {
  return std::any_of(lines_.begin(), lines_.end(),
                     [&](const ModelLine& line) { return line.name == name; });
}

const ModelLine& ModelLayout::model_line(const std::string& name) const {
  std::vector<std::string> names;
  for (const ModelLine& line : lines_) {
    if (line.name == name) return line;
    names.push_back(line.name);
  }
  no_such((region_count() == 1 ? "face '" : "model '") + this->name() + "'", "curve", name, names);
}

const HermiteCurve& ModelLayout::line(const std::string& name) const {
  return curve(model_line(name).sides.front());
}

const HermiteCurve& ModelLayout::curve(const LineSide& side) const {
  const auto i = static_cast<size_t>(side.index);
  return side.embedded ? region(side.region).embedded()[i].fitted
                       : region(side.region).edge_aligned()[i].fitted;
}

HermiteCurve ModelLayout::pcurve(const LineSide& side) const {
  const auto i = static_cast<size_t>(side.index);
  const RegionLayout& of = region(side.region);
  return side.embedded ? of.embedded()[i].pcurve
                       : edge_aligned_pcurve(*of.mesh(), of.edge_aligned()[i]);
}

bool ModelLayout::against(const ModelLine& line, const LineSide& side) const {
  const auto runs_against = [&](const LineSide& s) {
    return s.embedded && region(s.region).embedded()[s.index].opposite_to_prescribed;
  };
  return runs_against(side) != runs_against(line.sides.front());
}

JoinPenalty ModelLayout::join_penalty() const {
  return batten::join_penalty(layouts(), dof_offsets_, join_plans_, size(),
                              DofMap(*mesh_).count());
}

const JoinPlan* ModelLayout::join_plan(const std::string& line) const {
  for (const JoinPlan& plan : join_plans_)
    if (plan.join_line.name == line && !plan.rejected()) return &plan;
  return nullptr;
}

// -- constraints and numbering ----------------------------------------------------------------

std::vector<const RegionLayout*> ModelLayout::layouts() const {
  std::vector<const RegionLayout*> all;
  for (const auto& region : regions_) all.push_back(region.get());
  return all;
}

ConstraintSet ModelLayout::gather(ConstraintSet (RegionLayout::*rows)() const,
                                  bool name_regions) const {
  ConstraintSet all(DofMap(*mesh_).count());
  for (int r = 0; r < region_count(); ++r) {
    if (name_regions && region(r).corners().empty()) continue;
    const ConstraintSet own = (region(r).*rows)();
    long next = 0;
    for (const auto& row : own.constraints()) {
      poll_every<4096>(next++);
      std::vector<ConstraintSet::Entry> entries = row.entries;
      for (auto& e : entries) e.dof = dof_offsets(r)(e.dof);
      const std::string& name = own.names()[row.name];
      all.add(name_regions ? region(r).name() + " " + name : name, std::move(entries), row.value);
    }
  }
  return all;
}

ConstraintSet ModelLayout::line_constraints() const {
  if (region_count() == 1 && join_plans_.empty()) return region(0).line_constraints();
  ConstraintSet all = gather(&RegionLayout::line_constraints, false);
  add_join_constraints(layouts(), dof_offsets_, join_plans_, false, all);
  return all;
}

ConstraintSet ModelLayout::corner_constraints() const {
  if (region_count() == 1 && join_plans_.empty()) return region(0).corner_constraints();
  ConstraintSet all = gather(&RegionLayout::corner_constraints, true);
  if (all.constraints().empty())
    throw InputError("model '" + name() + "' has no corners; boundary = \"corners\" needs some");
  for (const JoinLine& line : shared_lines()) add_line_ties(layouts(), dof_offsets_, line, all);
  add_join_constraints(layouts(), dof_offsets_, join_plans_, true, all);
  return all;
}

std::vector<JoinLine> ModelLayout::shared_lines() const {
  std::vector<JoinLine> all;
  for (const ModelLine& line : lines_)
    for (size_t s = 1; s < line.sides.size(); ++s) {
      const LineSide &a = line.sides[0], &b = line.sides[s];
      all.push_back({line.name,
                     {JoinSide{a.region, a.embedded, a.index, true},
                      JoinSide{b.region, b.embedded, b.index, false}}});
    }
  return all;
}

VecX ModelLayout::position_dofs() const {
  const DofMap dofs(*mesh_);
  VecX ones = VecX::Zero(dofs.count());
  for (int v = 0; v < mesh_->vertex_count(); ++v) ones[dofs.vertex(v)] = 1;
  return ones;
}

std::vector<int> ModelLayout::dof_order() const {
  if (region_count() == 1) return nested_dissection_order(*mesh_);
  if (std::any_of(join_plans_.begin(), join_plans_.end(),
                  [](const JoinPlan& plan) {
                    return !plan.rejected() && !plan.join_line.neighbour();
                  }))
    return {};
  std::vector<int> order;
  for (int r = 0; r < region_count(); ++r)
    for (const int dof : nested_dissection_order(*region(r).mesh()))
      order.push_back(dof_offsets(r)(dof));
  return order;
}

std::vector<SurfaceStiffness> ModelLayout::scale_to_regions(
    std::vector<SurfaceStiffness> materials) const {
  if (domain_scale_.size() == 0) return materials;
  if (materials.size() == 1)
    materials.resize(static_cast<size_t>(domain_scale_.size()), materials[0]);
  for (size_t t = 0; t < materials.size(); ++t) {
    const double scale = domain_scale_[static_cast<long>(t)];
    materials[t].beta /= scale;
    materials[t].beta_mixed /= scale;
  }
  return materials;
}

VecX ModelLayout::spread(int r, const VecX& own) const {
  if (region_count() == 1) return own;
  VecX all = VecX::Zero(DofMap(*mesh_).count());
  const DofOffsets& n = dof_offsets(r);
  all.segment(n.vertices, n.vertex_dofs) = own.head(n.vertex_dofs);
  const long edges = own.size() - n.vertex_dofs;
  all.segment(n(n.vertex_dofs), edges) = own.tail(edges);
  return all;
}

int ModelLayout::region_of(int triangle) const {
  const auto after = std::upper_bound(first_triangle_.begin(), first_triangle_.end(), triangle);
  return static_cast<int>(after - first_triangle_.begin()) - 1;
}

Location ModelLayout::to_model_location(int r, Location where) const {
  where.triangle += first_triangle(r);
  return where;
}

// -- shapes ---------------------------------------------------------------------------------------

Points ModelLayout::region_dofs(int r, const Points& all) const {
  if (region_count() == 1) return all;
  const DofOffsets& n = dof_offsets(r);
  const int edges = region(r).mesh()->edge_count();
  Points own(n.vertex_dofs + edges, 3);
  own.topRows(n.vertex_dofs) = all.middleRows(n.vertices, n.vertex_dofs);
  own.bottomRows(edges) = all.middleRows(n(n.vertex_dofs), edges);
  return own;
}

Points ModelLayout::all_dofs(const std::vector<Points>& of_regions) const {
  if (region_count() == 1) return of_regions.front();
  Points all(DofMap(*mesh_).count(), 3);
  for (int r = 0; r < region_count(); ++r) {
    const DofOffsets& n = dof_offsets(r);
    const Points& own = of_regions[r];
    const long edges = own.rows() - n.vertex_dofs;
    all.middleRows(n.vertices, n.vertex_dofs) = own.topRows(n.vertex_dofs);
    all.middleRows(n(n.vertex_dofs), edges) = own.bottomRows(edges);
  }
  return all;
}

std::vector<Points> ModelLayout::of_regions(const Points& all) const {
  std::vector<Points> each;
  for (int r = 0; r < region_count(); ++r) each.push_back(region_dofs(r, all));
  return each;
}

Surface ModelLayout::surface(Points all) const { return {mesh_, element(), std::move(all), trim_}; }

SkinnedRegion ModelLayout::skinned(int r, const Points& all) const {
  return region(r).region(region_dofs(r, all));
}

Points ModelLayout::minimize_energy(const SurfaceStiffness& material, const Points& rest) const {
  return nearest_shape(
      {material}, rest.rows() > 0 ? rest : Points(Points::Zero(position_dofs().size(), 3)));
}

Points ModelLayout::nearest(const Points& wanted) const {
  return nearest_shape({SurfaceStiffness::isotropic(0, 1)}, wanted);
}

Points ModelLayout::nearest_shape(const std::vector<SurfaceStiffness>& materials,
                                  const Points& wanted) const {
  const SurfaceAssembler assembler(*mesh_, element(), trim_);
  SparseMatrix K = assembler.pattern();
  const std::vector<SurfaceStiffness> scaled = scale_to_regions(materials);
  if (scaled.size() == 1)
    assembler.stiffness(scaled[0], K);
  else
    assembler.stiffness(scaled, K);
  const VecX ones = position_dofs();
  const Points about_origin = ones * origin().transpose();
  Points F = Points::Zero(ones.size(), 3);
  if (!wanted.isZero(0)) F = K.selfadjointView<Eigen::Lower>() * Points(wanted - about_origin);
  // The join penalty applies to the shape itself, so it is added after the load is computed.
  double beta = 0;
  for (const SurfaceStiffness& m : materials) beta = std::max(beta, (m.beta[0] + m.beta[2]) / 2);
  if (const JoinPenalty joins = join_penalty(); joins.stiffness.nonZeros() > 0) {
    K += beta * joins.stiffness;
    F += beta * joins.load;
  }
  const ConstrainedSolver solver(line_constraints().translated(ones, origin()), std::move(K),
                                 dof_order());
  return solver.solve(F) + about_origin;
}

// Edits are made on copies of the regions, which replace the originals only if nothing was thrown.

namespace {

using Marks = std::vector<std::vector<char>>;

// Marks the triangles at edges of an edge-aligned line that another region has bisected on the same
// line.
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
    throw InputError("found " + std::to_string(marked.size()) + " refinement marks for " +
                     std::to_string(mesh_->triangle_count()) + " triangles, expected one for each");
  ModelLayout finer = *this;
  Marks marks;
  for (int r = 0; r < region_count(); ++r)
    marks.emplace_back(marked.begin() + first_triangle(r), marked.begin() + first_triangle(r + 1));
  bool any = false;
  // Repeated: each round brings the subdivisions of the sides closer to each other.
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
      throw InputError("the faces of model '" + name() + "' cannot be refined to matching edges");
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
  if (has_line(line.name)) throw InputError("two curves have the name '" + line.name + "'");
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
    throw InputError("curve '" + name + "' cannot be removed: it bounds faces");
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

GapRefinement::GapRefinement(const ModelLayout& layout) {
  constexpr int usual = 20'000, times = 4;
  max_triangles_ = std::max(usual, times * layout.mesh()->triangle_count());
}

bool GapRefinement::bisect(ModelLayout& layout, const std::vector<SkinnedRegion>& regions) {
  // The rest of the tolerance is left to the deviation of curves from the given ones.
  constexpr double max_gap = 0.7;  // of the tolerance
  if (exhausted() || max_line_gap(regions) <= max_gap * layout.tolerance()) return false;
  std::vector<char> marks(static_cast<size_t>(layout.mesh()->triangle_count()), 0);
  for (size_t r = 0; r < regions.size(); ++r)
    mark_gaps(regions[r], 0.5 * layout.tolerance(),
              marks.data() + layout.first_triangle(static_cast<int>(r)));
  const auto more = std::count(marks.begin(), marks.end(), 1);
  if (layout.mesh()->triangle_count() + more > max_triangles_ || !layout.refine(marks))
    return false;
  ++rounds_;
  return true;
}

}  // namespace batten
