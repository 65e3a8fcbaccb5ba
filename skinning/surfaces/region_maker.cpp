// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/surfaces/region_maker.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/skinning/domains/mesher.h"
#include "batten/skinning/model/boundary_sweep.h"
#include "batten/skinning/surfaces/normal_side.h"

namespace batten {
namespace {

constexpr int kMaxModelTriangles = 100'000;  // approximate

// Minimum number of elements across a small region; fewer if there are many regions.
double min_edges_across(size_t regions) {
  return std::clamp(std::sqrt(kMaxModelTriangles / static_cast<double>(regions)), 6.0, 12.0);
}

double length_of(const CurveNetwork& network, const EdgeLoop& loop) {
  double sum = 0;
  for (const OrientedEdge& use : loop) sum += network.edges()[use.edge].length;
  return sum;
}

bool is_smooth(const CurveNetwork& network, const EdgeLoop& loop) {
  for (size_t i = 0; i < loop.size(); ++i) {
    const OrientedEdge &use = loop[i], &next = loop[(i + 1) % loop.size()];
    const NetworkEdge& edge = network.edges()[use.edge];
    if (edge.continuation[use.reversed ? 0 : 1] != EdgeEnd{next.edge, next.reversed}) return false;
  }
  return true;
}

bool open_slit(const CurveNetwork& network, NetworkRegion& plan, size_t l) {
  const EdgeLoop loop = plan.loops[l];
  for (size_t i = 0; i < loop.size(); ++i)
    for (size_t j = i + 1; j < loop.size(); ++j) {
      if (loop[i].edge != loop[j].edge || loop[i].reversed == loop[j].reversed) continue;
      const auto at = [&](size_t k) { return loop.begin() + static_cast<std::ptrdiff_t>(k); };
      EdgeLoop between(at(i + 1), at(j)), around(at(j + 1), loop.end());
      around.insert(around.end(), loop.begin(), at(i));
      if (length_of(network, around) < length_of(network, between)) std::swap(around, between);
      if (around.empty()) return false;
      plan.inner.push_back(loop[i].edge);
      plan.loops[l] = std::move(around);
      if (!between.empty()) plan.loops.push_back(std::move(between));
      return true;
    }
  return false;
}

// Resolves slits: if a loop passes an edge in both directions, the edge becomes an inner edge. The
// two remaining loops become the outline (the longer one) and a hole.
void open_slits(const CurveNetwork& network, NetworkRegion& plan) {
  if (plan.annulus) return;
  for (size_t l = 0; l < plan.loops.size(); ++l)
    while (open_slit(network, plan, l)) {
    }
  // A tube that was cut open along a line: two smooth loops, and the cut between them.
  plan.annulus = plan.loops.size() == 2 && !plan.inner.empty() &&
                 is_smooth(network, plan.loops[0]) && is_smooth(network, plan.loops[1]);
}

}  // namespace

RegionMaker::RegionMaker(const CurveNetwork& network, const FoundRegions& found,
                         const ModelOptions& options, const Progress& progress, SurfaceModel& model)
    : network_(network), options_(options), progress_(progress), model_(model) {
  std::vector<NetworkRegion> plans = found.regions;
  for (NetworkRegion& plan : plans) open_slits(network, plan);
  orientation_ = orient(network, plans);
  model_.shells = orientation_.shells;
  model_.regions.resize(plans.size());
  for (size_t r = 0; r < plans.size(); ++r) {
    model_.regions[r].plan = std::move(plans[r]);
    model_.regions[r].filling_area = orientation_.filling_areas[r];
  }
  const double edges_per_size =
      plans.size() == 1 ? 20 : 40;  // a single region has no joins to resolve
  edge_ = options.skin.edge_length > 0 ? options.skin.edge_length : network.size() / edges_per_size;
  tolerance_ = options.skin.tolerance > 0 ? options.skin.tolerance : 1e-4 * network.size();
  require_tolerance(tolerance_, network.size());
  for (const NetworkNode& node : network.nodes())
    origin_ += node.position / static_cast<double>(network.nodes().size());
  require_memory_for_all();
  distribute_vertices();
  strategies_.resize(model_.regions.size());
  layouts_.resize(model_.regions.size());
  initial_shapes_.resize(model_.regions.size());
  rest_shapes_.resize(model_.regions.size());
  sizes_.resize(model_.regions.size());
}

double RegionMaker::element_edge(int region) const {
  return std::min(edge_of(region),
                  orientation_.sizes[region] / min_edges_across(model_.regions.size()));
}

void RegionMaker::require_memory_for_all() const {
  if (model_.regions.size() == 1) return;  // the estimate of the region itself is more accurate
  double triangles = 0;
  for (int r = 0; r < isize(model_.regions); ++r)
    triangles += orientation_.filling_areas[r] / (0.433 * std::pow(element_edge(r), 2));
  require_model_size(triangles, edge_, network_.size());
}

double RegionMaker::edge_of(int region) const {
  const double own = model_.regions[region].plan.skin.edge_length;
  return own > 0 ? own : edge_;
}

// Distributes the mesh vertices on each network edge.
void RegionMaker::distribute_vertices() {
  prescribed_.resize(network_.edges().size());
  for (size_t a = 0; a < network_.edges().size(); ++a) {
    const NetworkEdge& edge = network_.edges()[a];
    double spacing = orientation_.sides[a].empty() ? edge_ : network_.size();
    for (const EdgeUse& side : orientation_.sides[a]) {
      const double across = 2.0 / 3 * min_edges_across(model_.regions.size());
      spacing = std::min({spacing, edge_of(side.region), orientation_.sizes[side.region] / across});
    }
    spacing = std::min(spacing, 0.5 * edge.length);
    if (const double count = edge.length / spacing; !(count <= kMaxTriangles))
      throw InputError("the edge length " + format_number(spacing) + " on curve '" + edge.name +
                       "' of length " + format_number(edge.length) + " creates " +
                       format_number(count) + " element edges, expected at most " +
                       format_number(kMaxTriangles) + "; check the points and the unit");
    auto prescribed = std::make_shared<PrescribedCurve>();
    prescribed->curve = edge.curve;
    const auto& nodes = edge.curve.parameters();
    const double per_length = edge.curve.end() / edge.length;
    prescribed->vertices.push_back(nodes.front());
    for (size_t i = 0; i + 1 < nodes.size(); ++i) {
      const double span = nodes[i + 1] - nodes[i];
      const int cuts =
          std::max(1, static_cast<int>(std::ceil(span / (spacing * per_length) - 0.2)));
      for (int c = 1; c <= cuts; ++c)
        prescribed->vertices.push_back(c == cuts ? nodes[i + 1] : nodes[i] + span * c / cuts);
    }
    prescribed_[a] = std::move(prescribed);
  }
}

// Refines regions until their meshes resolve the rest shapes that follow from their sides. The nose
// of a wing, for example, is as curved at mid-span as at the ribs, where vertices are dense. Sizes
// are found on layouts without a shape; the changed ones are solved afterwards.
std::set<int> RegionMaker::refine_for_rest_shapes(std::set<int> examine) {
  std::set<int> beside;
  if (!options_.rest || options_.skin.edge_length > 0) return beside;
  constexpr int kMaxRounds = 8;
  constexpr double kToleranceFraction =
      0.4;  // of the tolerance: fitted curves use up some of it, too
  // Waves of hand-drawn curves do not justify more elements; noses of wings do.
  constexpr double kMinError = 10;  // of the tolerance
  // Triangles added to all of these regions together, bounded so that drawings with many regions
  // stay fast.
  const int more = std::min(10'000, 40'000 / isize(model_.regions));
  int each = more;
  std::vector<std::shared_ptr<const RegionLayout>> now(model_.regions.size());
  std::vector<int> before(now.size(), 0);  // number of triangles
  std::vector<int> in_vain(now.size(), 0);
  std::vector<double> least_error(now.size(), std::numeric_limits<double>::infinity());
  for (const int r : examine) sizes_[r].reset();
  for (int round = 0; round < kMaxRounds && !examine.empty(); ++round) {
    const std::vector<int> which(examine.begin(), examine.end());
    std::vector<std::shared_ptr<const SizeField>> sizes(which.size());
    parallel_for(isize(which), [&](int i) {
      const int r = which[i];
      if (model_.regions[r].plan.skin.edge_length > 0) return;
      const auto layout = plain_layout(r);
      if (!layout || layout->domain() != SkinOptions::Domain::Polygon) return;
      const int triangles = layout->mesh()->triangle_count();
      if (round == 0) before[r] = triangles;
      if (triangles > before[r] + each) return;
      const RestShapeError error =
          rest_shape_error(*layout, kToleranceFraction * tolerance_, sizes_[r].get());
      if (round == 0 && !(error.largest > kMinError * tolerance_)) return;
      // If shorter edges do not help twice, the shape itself has a corner.
      constexpr double kWorthwhileRatio = 0.8;
      in_vain[r] = error.largest <= kWorthwhileRatio * least_error[r] ? 0 : in_vain[r] + 1;
      if (in_vain[r] == (error.largest <= tolerance_ ? 1 : 2)) return;
      least_error[r] = std::min(least_error[r], error.largest);
      sizes[i] = error.size_field;
      now[r] = layout;
    });
    examine.clear();
    if (round == 0)
      each /= std::max(1, static_cast<int>(std::count_if(sizes.begin(), sizes.end(),
                                                         [](const auto& s) { return s; })));
    for (size_t i = 0; i < which.size(); ++i) {
      if (!sizes[i]) continue;
      sizes_[which[i]] = sizes[i];
      examine.insert(which[i]);
      const std::set<int> divided = divide_sides(*now[which[i]], *sizes[i]);
      examine.insert(divided.begin(), divided.end());
      beside.insert(divided.begin(), divided.end());
    }
  }
  return beside;
}

// The default layout of a region without a shape; null if it fails.
std::shared_ptr<const RegionLayout> RegionMaker::plain_layout(int r) const {
  const RegionRequest request = request_of(static_cast<size_t>(r));
  try {
    return batten::lay_out(request, {request.skin});
  } catch (const CancelledError&) {
    throw;
  } catch (const std::runtime_error&) {
    return nullptr;
  }
}

// Distributes vertices on the edges of a region according to its target sizes. Returns the adjacent
// regions.
std::set<int> RegionMaker::divide_sides(const RegionLayout& layout, const SizeField& sizes) {
  std::set<int> beside;
  for (const EdgeAlignedLine& aligned_line : layout.edge_aligned()) {
    const auto& edges = network_.edges();
    const auto edge = std::find_if(edges.begin(), edges.end(), [&](const NetworkEdge& a) {
      return a.name == aligned_line.line.name;
    });
    if (edge == edges.end() || !aligned_line.line.prescribed) continue;
    const auto a = static_cast<size_t>(edge - edges.begin());
    const double per_length = edge->curve.end() / edge->length;
    const PrescribedCurve& prescribed = *prescribed_[a];  // may have more vertices than the line
    auto finer = std::make_shared<PrescribedCurve>(PrescribedCurve{prescribed.curve, {}});
    const auto& of_run = aligned_line.line.prescribed->vertices;
    for (size_t i = 0;; ++i) {
      finer->vertices.push_back(prescribed.vertices[i]);
      if (i + 1 == prescribed.vertices.size()) break;
      const double span = prescribed.vertices[i + 1] - prescribed.vertices[i];
      const auto after =
          std::upper_bound(of_run.begin(), of_run.end(), prescribed.vertices[i] + 0.5 * span);
      const auto k = static_cast<size_t>(after - of_run.begin());
      const double wanted = layout.size() * std::min(sizes.at_vertex(aligned_line.vertices[k - 1]),
                                                     sizes.at_vertex(aligned_line.vertices[k]));
      const int cuts = static_cast<int>(std::ceil(span / (wanted * per_length) - 0.2));
      for (int c = 1; c < cuts; ++c)
        finer->vertices.push_back(prescribed.vertices[i] + span * c / cuts);
    }
    if (finer->vertices.size() == prescribed.vertices.size()) continue;
    prescribed_[a] = std::move(finer);
    for (const EdgeUse& side : orientation_.sides[a]) beside.insert(side.region);
  }
  return beside;
}

std::vector<CharacterLine> RegionMaker::lines_of(const NetworkRegion& plan) const {
  std::vector<CharacterLine> lines;
  const auto add = [&](int a, CharacterLine::Role role) {
    const NetworkEdge& edge = network_.edges()[a];
    CharacterLine line{edge.name, edge.input, role};
    line.constrains_surface = network_.lines()[edge.line].constrains_surface;
    if (role == CharacterLine::Role::Inner)
      line.curve = curve_from_hermite(edge.curve);
    else
      line.prescribed = prescribed_[a];
    lines.push_back(std::move(line));
  };
  for (size_t l = 0; l < plan.loops.size(); ++l)
    for (const OrientedEdge& use : plan.loops[l])
      add(use.edge,
          l == 0 || plan.annulus ? CharacterLine::Role::Outline : CharacterLine::Role::Hole);
  for (const int a : plan.inner) add(a, CharacterLine::Role::Inner);
  return lines;
}

void RegionMaker::lay_out(const std::vector<int>& which, double from, double to) {
  progress_.update("skinning faces", from);
  parallel_for(isize(which), [&](int i) {
    const auto r = static_cast<size_t>(which[i]);
    ModelRegion& region = model_.regions[r];
    region.rejection_reason.clear();
    try {
      lay_out_one(r);
    } catch (const CancelledError&) {
      throw;
    } catch (const std::runtime_error& e) {
      // Laid out again for its joins only: keep the previous layout.
      if (layouts_[r]) return;
      region.rejection_reason = e.what();
      if (dynamic_cast<const NoSolutionError*>(&e) || dynamic_cast<const MeshError*>(&e))
        region.rejection_reason =
            "its curves leave too little space for elements (" + region.rejection_reason + ")";
    }
  });
  progress_.update("skinning faces", to);
}

void RegionMaker::orient_normals() {
  std::vector<int> turned;
  for (const OrientedPatch& patch : orientation_.patches) {
    if (!patch.orientable) continue;
    std::vector<const SkinnedRegion*> made;
    for (const int r : patch.regions)
      if (model_.regions[r].skinned) made.push_back(&*model_.regions[r].skinned);
    const bool closed = patch.closed && made.size() == patch.regions.size();
    if (made.empty() || normal_side(side_integrals(made), closed).agrees) continue;
    for (const int r : patch.regions) {
      flip_region(r, model_.regions[r].plan, orientation_);
      // Do not keep the previous layout if it fails.
      layouts_[r] = nullptr;
      model_.regions[r].skinned.reset();
      turned.push_back(r);
    }
  }
  if (turned.empty()) return;
  // Orientation changes the domains.
  for (const int r : refine_for_rest_shapes({turned.begin(), turned.end()}))
    if (std::find(turned.begin(), turned.end(), r) == turned.end()) turned.push_back(r);
  for (const int r : turned) {
    if (!strategies_[r]) continue;
    strategies_[r]->skin.reverse_orientation = model_.regions[r].plan.loops[0][0].reversed;
    strategies_[r]->skin.size_field = sizes_[r];
  }
  lay_out(turned, 0.4, 0.4);
  // If a layout that worked before fails now, try the other candidates.
  std::erase_if(turned, [&](int r) { return layouts_[r] || !strategies_[r]; });
  for (const int r : turned) strategies_[r].reset();
  if (!turned.empty()) lay_out(turned, 0.4, 0.4);
}

RegionRequest RegionMaker::request_of(size_t r) const {
  const NetworkRegion& plan = model_.regions[r].plan;
  SkinOptions skin = options_.skin;
  skin.edge_length = element_edge(static_cast<int>(r));
  skin.size_field = sizes_[r];
  skin.tolerance = tolerance_;
  skin.domain = plan.annulus ? SkinOptions::Domain::Annulus : plan.skin.domain;
  skin.convex = plan.skin.convex;
  skin.reverse_orientation = plan.loops[0][0].reversed;
  // Triangle budget of the candidates; smaller for models with many regions.
  constexpr int kMinTrialTriangles = 1'000, kMaxTrialTriangles = 8'000;
  const int budget = std::clamp(kMaxModelTriangles / isize(model_.regions), kMinTrialTriangles,
                                kMaxTrialTriangles);
  return {plan.name, lines_of(plan), isize(plan.inner), skin, orientation_.filling_areas[r],
          budget};
}

void RegionMaker::take(size_t r, LayoutCandidate candidate) {
  strategies_[r] = candidate.strategy;
  model_.regions[r].expected_area = candidate.expected_area;
  model_.regions[r].skinned = candidate.layout->region(candidate.shape);
  layouts_[r] = std::move(candidate.layout);
  initial_shapes_[r] = std::move(candidate.shape);
  rest_shapes_[r] = std::move(candidate.rest);
}

// An annulus whose loops are far from concentric has strongly sheared elements: a face with a hole
// is better.
void RegionMaker::try_as_hole(size_t r, LayoutCandidate& annulus) {
  const NetworkRegion before = model_.regions[r].plan;
  NetworkRegion& plan = model_.regions[r].plan;
  const auto length = [&](const EdgeLoop& loop) {
    double sum = 0;
    for (const OrientedEdge& use : loop) sum += network_.edges()[use.edge].length;
    return sum;
  };
  plan.annulus = false;
  if (length(plan.loops[0]) < length(plan.loops[1])) std::swap(plan.loops[0], plan.loops[1]);
  try {
    LayoutCandidate with_hole = best_layout(request_of(r), metadata(), options_.material);
    if (with_hole.strategy.defect_score < annulus.strategy.defect_score) {
      annulus = std::move(with_hole);
      return;
    }
  } catch (const CancelledError&) {
    throw;
  } catch (const std::runtime_error&) {
    // The annulus remains.
  }
  plan = before;
}

void RegionMaker::lay_out_one(size_t r) {
  const RegionRequest request = request_of(r);
  std::optional<LayoutCandidate> candidate;
  if (strategies_[r])
    candidate = retry_layout(request, *strategies_[r], metadata(), options_.material);
  if (!candidate) {
    candidate = best_layout(request, metadata(), options_.material);
    if (candidate->strategy.defect_score > 0 && model_.regions[r].plan.annulus)
      try_as_hole(r, *candidate);
    model_.regions[r].warnings = candidate->warnings;
  }
  take(r, std::move(*candidate));
}

bool RegionMaker::lay_out_alternative(int region) {
  const auto r = static_cast<size_t>(region);
  if (strategies_[r]->skin.convex) return false;  // its inversion in this shape is meaningless
  auto candidate =
      try_other_domain(request_of(r), layouts_[r]->domain(), metadata(), options_.material);
  if (!candidate) return false;
  model_.regions[r].warnings = candidate->warnings;
  take(r, std::move(*candidate));
  return true;
}

bool RegionMaker::lay_out_without_rest_shape(int region) {
  const auto r = static_cast<size_t>(region);
  if (rest_shapes_[r].rows() == 0) return false;
  strategies_[r]->skin.rest = false;
  lay_out({region}, 0.5, 0.5);
  model_.regions[r].warnings.push_back(
      "it has no reference configuration: the sweep between its sides would be inverted or bulge "
      "at smooth edges");
  return true;
}

bool RegionMaker::drop_rest_shape_if_better(
    int region, const std::function<double(const SkinnedRegion&)>& misfit) {
  constexpr double kBetter = 0.8, kNotMuchWorse = 2;
  const auto r = static_cast<size_t>(region);
  if (rest_shapes_[r].rows() == 0) return false;
  LayoutStrategy strategy = *strategies_[r];
  strategy.skin.rest = false;
  std::optional<LayoutCandidate> candidate;
  try {
    candidate = retry_layout(request_of(r), strategy, metadata(), options_.material);
  } catch (const NoSolutionError&) {
    return false;
  }
  if (!candidate) return false;
  const double limit = layouts_[r]->corners().size() == 2 ? kNotMuchWorse : kBetter;
  if (!(misfit(candidate->layout->region(candidate->shape)) <
        limit * misfit(*model_.regions[r].skinned)))
    return false;
  take(r, std::move(*candidate));
  return true;
}

void RegionMaker::exclude(int r, const std::string& why) {
  ModelRegion& region = model_.regions[r];
  region.rejection_reason = why;
  region.skinned.reset();
  region.layout_index = -1;
  layouts_[r] = nullptr;
}

ModelMetadata RegionMaker::metadata() const {
  return {options_.name, network_.size(), tolerance_, origin_, options_.join_tolerance_deg,
          options_.rest};
}

std::optional<JoinSide> RegionMaker::side_of(const EdgeUse& use, int edge) const {
  const auto& made = model_.regions[use.region].skinned;
  return made ? batten::side_of(*made, use.region, network_.edges()[edge].name) : std::nullopt;
}

void RegionMaker::halve(int a) {
  const PrescribedCurve& prescribed = *prescribed_[a];
  auto finer = std::make_shared<PrescribedCurve>(PrescribedCurve{prescribed.curve, {}});
  for (size_t i = 0; i + 1 < prescribed.vertices.size(); ++i) {
    finer->vertices.push_back(prescribed.vertices[i]);
    finer->vertices.push_back(0.5 * (prescribed.vertices[i] + prescribed.vertices[i + 1]));
  }
  finer->vertices.push_back(prescribed.vertices.back());
  prescribed_[a] = std::move(finer);
}

}  // namespace batten
