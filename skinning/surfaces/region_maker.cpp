#include "batten/skinning/surfaces/region_maker.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "batten/core/errors.h"
#include "batten/core/index.h"
#include "batten/core/parallel.h"
#include "batten/core/words.h"
#include "batten/skinning/domains/mesh_size.h"
#include "batten/skinning/model/rest_error.h"
#include "batten/skinning/surfaces/normal_side.h"

namespace batten {
namespace {

constexpr int kMostOfModel = 100'000;  // triangles, about

// Elements across a small region: of many regions each has fewer.
double least_across(size_t regions) {
  return std::clamp(std::sqrt(kMostOfModel / static_cast<double>(regions)), 6.0, 12.0);
}

double length_of(const CharacterLineNetwork& network, const ArcLoop& loop) {
  double sum = 0;
  for (const ArcUse& use : loop) sum += network.arcs()[use.arc].length;
  return sum;
}

bool is_smooth(const CharacterLineNetwork& network, const ArcLoop& loop) {
  for (size_t i = 0; i < loop.size(); ++i) {
    const ArcUse &use = loop[i], &next = loop[(i + 1) % loop.size()];
    const NetworkArc& arc = network.arcs()[use.arc];
    if (arc.on[use.reversed ? 0 : 1] != ArcEnd{next.arc, next.reversed}) return false;
  }
  return true;
}

bool open_slit(const CharacterLineNetwork& network, NetworkRegion& plan, size_t l) {
  const ArcLoop loop = plan.loops[l];
  for (size_t i = 0; i < loop.size(); ++i)
    for (size_t j = i + 1; j < loop.size(); ++j) {
      if (loop[i].arc != loop[j].arc || loop[i].reversed == loop[j].reversed) continue;
      const auto at = [&](size_t k) { return loop.begin() + static_cast<std::ptrdiff_t>(k); };
      ArcLoop between(at(i + 1), at(j)), around(at(j + 1), loop.end());
      around.insert(around.end(), loop.begin(), at(i));
      if (length_of(network, around) < length_of(network, between)) std::swap(around, between);
      if (around.empty()) return false;
      plan.inner.push_back(loop[i].arc);
      plan.loops[l] = std::move(around);
      if (!between.empty()) plan.loops.push_back(std::move(between));
      return true;
    }
  return false;
}

// A loop that goes along an arc and comes back on it: the arc lies inside then, and what is left
// are two loops, the longer of which is the outline.
void open_slits(const CharacterLineNetwork& network, NetworkRegion& plan) {
  if (plan.ring) return;
  for (size_t l = 0; l < plan.loops.size(); ++l)
    while (open_slit(network, plan, l)) {
    }
  // A tube that was cut open along a line: two smooth loops and the cut between them.
  plan.ring = plan.loops.size() == 2 && !plan.inner.empty() && is_smooth(network, plan.loops[0]) &&
              is_smooth(network, plan.loops[1]);
}

}  // namespace

RegionMaker::RegionMaker(const CharacterLineNetwork& network, const FoundRegions& found,
                         const ModelOptions& options, const Progress& progress, SurfaceModel& model)
    : network_(network), options_(options), progress_(progress), model_(model) {
  std::vector<NetworkRegion> plans = found.regions;
  for (NetworkRegion& plan : plans) open_slits(network, plan);
  orientation_ = orient(network, plans);
  model_.shells = orientation_.shells;
  model_.regions.resize(plans.size());
  for (size_t r = 0; r < plans.size(); ++r) {
    model_.regions[r].plan = std::move(plans[r]);
    model_.regions[r].plain_area = orientation_.plain_areas[r];
  }
  const double share = plans.size() == 1 ? 20 : 40;  // a region by itself has no neighbours to meet
  edge_ = options.skin.edge_length > 0 ? options.skin.edge_length : network.size() / share;
  tolerance_ = options.skin.tolerance > 0 ? options.skin.tolerance : 1e-4 * network.size();
  require_tolerance(tolerance_, network.size());
  for (const NetworkNode& node : network.nodes())
    origin_ += node.position / static_cast<double>(network.nodes().size());
  require_memory_for_all();
  place_vertices();
  ways_.resize(model_.regions.size());
  layouts_.resize(model_.regions.size());
  first_.resize(model_.regions.size());
  rests_.resize(model_.regions.size());
  sizes_.resize(model_.regions.size());
}

double RegionMaker::element_edge(int region) const {
  return std::min(edge_of(region),
                  orientation_.sizes[region] / least_across(model_.regions.size()));
}

void RegionMaker::require_memory_for_all() const {
  if (model_.regions.size() == 1) return;  // a region knows its own need better
  double triangles = 0;
  for (int r = 0; r < count_of(model_.regions); ++r)
    triangles += orientation_.plain_areas[r] / (0.433 * std::pow(element_edge(r), 2));
  require_model_size(triangles, edge_, network_.size());
}

double RegionMaker::edge_of(int region) const {
  const double own = model_.regions[region].plan.skin.edge_length;
  return own > 0 ? own : edge_;
}

// Where meshes have their vertices on each arc.
void RegionMaker::place_vertices() {
  given_.resize(network_.arcs().size());
  for (size_t a = 0; a < network_.arcs().size(); ++a) {
    const NetworkArc& arc = network_.arcs()[a];
    double spacing = orientation_.sides[a].empty() ? edge_ : network_.size();
    for (const ArcSide& side : orientation_.sides[a]) {
      const double across = 2.0 / 3 * least_across(model_.regions.size());
      spacing = std::min({spacing, edge_of(side.region), orientation_.sizes[side.region] / across});
    }
    spacing = std::min(spacing, 0.5 * arc.length);
    if (const double count = arc.length / spacing; !(count <= most_triangles))
      throw InputError("elements of " + number(spacing) + " on line '" + arc.name + "' of length " +
                       number(arc.length) + " mean " + number(count) + " of their edges; at most " +
                       number(most_triangles) + " are allowed (is a point wrong, or the unit?)");
    auto given = std::make_shared<GivenCurve>();
    given->curve = arc.curve;
    const auto& nodes = arc.curve.parameters();
    const double per_length = arc.curve.end() / arc.length;
    given->vertices.push_back(nodes.front());
    for (size_t i = 0; i + 1 < nodes.size(); ++i) {
      const double span = nodes[i + 1] - nodes[i];
      const int cuts =
          std::max(1, static_cast<int>(std::ceil(span / (spacing * per_length) - 0.2)));
      for (int c = 1; c <= cuts; ++c)
        given->vertices.push_back(c == cuts ? nodes[i + 1] : nodes[i] + span * c / cuts);
    }
    given_[a] = std::move(given);
  }
}

// Meshes resolve what the sides of their regions mean: a nose is as curved in the middle of its span as at
// the ribs, where vertices are dense. Sizes are found on layouts without a shape; at the end those that
// changed get one.
std::set<int> RegionMaker::resolve_rests(std::set<int> look_at) {
  std::set<int> beside;
  if (!options_.rest || options_.skin.edge_length > 0) return beside;
  constexpr int most_rounds = 8;
  constexpr double share = 0.4;  // of the tolerance: fitted curves take some, too
  // Waves of curves that were drawn by hand are not worth their elements, noses of wings are.
  constexpr double least_error = 10;  // of the tolerance
  // Triangles that come to all of these regions. Drawings of many regions are not to be much slower.
  const int more = std::min(10'000, 40'000 / count_of(model_.regions));
  int each = more;
  std::vector<std::shared_ptr<const RegionLayout>> now(model_.regions.size());
  std::vector<int> before(now.size(), 0);  // triangles
  std::vector<int> in_vain(now.size(), 0);
  std::vector<double> least(now.size(), std::numeric_limits<double>::infinity());
  for (const int r : look_at) sizes_[r].reset();
  for (int round = 0; round < most_rounds && !look_at.empty(); ++round) {
    const std::vector<int> which(look_at.begin(), look_at.end());
    std::vector<std::shared_ptr<const ElementSizes>> sizes(which.size());
    parallel_parts(count_of(which), [&](int i) {
      const int r = which[i];
      if (model_.regions[r].plan.skin.edge_length > 0) return;
      const auto layout = plain_layout(r);
      if (!layout || layout->domain() != SkinOptions::Domain::Polygon) return;
      const int triangles = layout->mesh()->triangle_count();
      if (round == 0) before[r] = triangles;
      if (triangles > before[r] + each) return;
      const RestError error = rest_error(*layout, share * tolerance_, sizes_[r].get());
      if (round == 0 && !(error.largest > least_error * tolerance_)) return;
      // Where shorter edges do not help twice, the shape itself has a corner.
      constexpr double helps = 0.8;
      in_vain[r] = error.largest <= helps * least[r] ? 0 : in_vain[r] + 1;
      if (in_vain[r] == (error.largest <= tolerance_ ? 1 : 2)) return;
      least[r] = std::min(least[r], error.largest);
      sizes[i] = error.sizes;
      now[r] = layout;
    });
    look_at.clear();
    if (round == 0)
      each /= std::max(1, static_cast<int>(std::count_if(sizes.begin(), sizes.end(),
                                                         [](const auto& s) { return s; })));
    for (size_t i = 0; i < which.size(); ++i) {
      if (!sizes[i]) continue;
      sizes_[which[i]] = sizes[i];
      look_at.insert(which[i]);
      const std::set<int> divided = divide_sides(*now[which[i]], *sizes[i]);
      look_at.insert(divided.begin(), divided.end());
      beside.insert(divided.begin(), divided.end());
    }
  }
  return beside;
}

// Null where it cannot be laid out as its lines ask for.
std::shared_ptr<const RegionLayout> RegionMaker::plain_layout(int r) const {
  const RegionWish wish = wish_of(static_cast<size_t>(r));
  try {
    return batten::lay_out(wish, {wish.skin});
  } catch (const CancelledError&) {
    throw;
  } catch (const std::runtime_error&) {
    return nullptr;
  }
}

// Gives the arcs of a region vertices as dense as its elements are to be. Regions beside these.
std::set<int> RegionMaker::divide_sides(const RegionLayout& layout, const ElementSizes& sizes) {
  std::set<int> beside;
  for (const LineRun& run : layout.runs()) {
    const auto& arcs = network_.arcs();
    const auto arc = std::find_if(arcs.begin(), arcs.end(),
                                  [&](const NetworkArc& a) { return a.name == run.line.name; });
    if (arc == arcs.end() || !run.line.given) continue;
    const auto a = static_cast<size_t>(arc - arcs.begin());
    const double per_length = arc->curve.end() / arc->length;
    const GivenCurve& given = *given_[a];  // may have more vertices than the run has
    auto finer = std::make_shared<GivenCurve>(GivenCurve{given.curve, {}});
    const auto& of_run = run.line.given->vertices;
    for (size_t i = 0;; ++i) {
      finer->vertices.push_back(given.vertices[i]);
      if (i + 1 == given.vertices.size()) break;
      const double span = given.vertices[i + 1] - given.vertices[i];
      const auto after =
          std::upper_bound(of_run.begin(), of_run.end(), given.vertices[i] + 0.5 * span);
      const auto k = static_cast<size_t>(after - of_run.begin());
      const double wanted = layout.size() * std::min(sizes.at_vertex(run.vertices[k - 1]),
                                                     sizes.at_vertex(run.vertices[k]));
      const int cuts = static_cast<int>(std::ceil(span / (wanted * per_length) - 0.2));
      for (int c = 1; c < cuts; ++c) finer->vertices.push_back(given.vertices[i] + span * c / cuts);
    }
    if (finer->vertices.size() == given.vertices.size()) continue;
    given_[a] = std::move(finer);
    for (const ArcSide& side : orientation_.sides[a]) beside.insert(side.region);
  }
  return beside;
}

std::vector<CharacterLine> RegionMaker::lines_of(const NetworkRegion& plan) const {
  std::vector<CharacterLine> lines;
  const auto add = [&](int a, CharacterLine::Role role) {
    const NetworkArc& arc = network_.arcs()[a];
    CharacterLine line{arc.name, arc.input, role};
    line.holds = network_.lines()[arc.line].holds;
    if (role == CharacterLine::Role::Inner)
      line.curve = curve_from_hermite(arc.curve);
    else
      line.given = given_[a];
    lines.push_back(std::move(line));
  };
  for (size_t l = 0; l < plan.loops.size(); ++l)
    for (const ArcUse& use : plan.loops[l])
      add(use.arc, l == 0 || plan.ring ? CharacterLine::Role::Outline : CharacterLine::Role::Hole);
  for (const int a : plan.inner) add(a, CharacterLine::Role::Inner);
  return lines;
}

void RegionMaker::lay_out(const std::vector<int>& which, double from, double to) {
  progress_.at("skinning regions", from);
  parallel_parts(count_of(which), [&](int i) {
    const auto r = static_cast<size_t>(which[i]);
    ModelRegion& region = model_.regions[r];
    region.why_not.clear();
    try {
      lay_out_one(r);
    } catch (const CancelledError&) {
      throw;
    } catch (const std::runtime_error& e) {
      // Made once more for its joins only: then it stays as it was.
      if (layouts_[r]) return;
      region.why_not = e.what();
      if (dynamic_cast<const NoSolutionError*>(&e) || dynamic_cast<const MeshError*>(&e))
        region.why_not = "its lines leave too little room for elements (" + region.why_not + ")";
    }
  });
  progress_.at("skinning regions", to);
}

void RegionMaker::turn_normals() {
  std::vector<int> turned;
  for (const OrientedSheet& sheet : orientation_.sheets) {
    if (!sheet.orientable) continue;
    std::vector<const SkinnedRegion*> made;
    for (const int r : sheet.regions)
      if (model_.regions[r].skinned) made.push_back(&*model_.regions[r].skinned);
    const bool closed = sheet.closed && made.size() == sheet.regions.size();
    if (made.empty() || normal_side(side_integrals(made), closed).agrees) continue;
    for (const int r : sheet.regions) {
      turn_over(r, model_.regions[r].plan, orientation_);
      // It is not to stay as it was.
      layouts_[r] = nullptr;
      model_.regions[r].skinned.reset();
      turned.push_back(r);
    }
  }
  if (turned.empty()) return;
  // The domains are others now.
  for (const int r : resolve_rests({turned.begin(), turned.end()}))
    if (std::find(turned.begin(), turned.end(), r) == turned.end()) turned.push_back(r);
  for (const int r : turned) {
    if (!ways_[r]) continue;
    ways_[r]->skin.against_first = model_.regions[r].plan.loops[0][0].reversed;
    ways_[r]->skin.sizes = sizes_[r];
  }
  lay_out(turned, 0.4, 0.4);
  // What could be laid out before is tried in other ways.
  std::erase_if(turned, [&](int r) { return layouts_[r] || !ways_[r]; });
  for (const int r : turned) ways_[r].reset();
  if (!turned.empty()) lay_out(turned, 0.4, 0.4);
}

RegionWish RegionMaker::wish_of(size_t r) const {
  const NetworkRegion& plan = model_.regions[r].plan;
  SkinOptions skin = options_.skin;
  skin.edge_length = element_edge(static_cast<int>(r));
  skin.sizes = sizes_[r];
  skin.tolerance = tolerance_;
  skin.domain = plan.ring ? SkinOptions::Domain::Ring : plan.skin.domain;
  skin.convex = plan.skin.convex;
  skin.against_first = plan.loops[0][0].reversed;
  // Triangles that trials may take: of large regions and of large models fewer are made.
  constexpr int least = 1'000, most = 8'000;
  const int budget = std::clamp(kMostOfModel / count_of(model_.regions), least, most);
  return {plan.name,
          lines_of(plan),
          count_of(plan.inner),
          skin,
          orientation_.plain_areas[r],
          budget,
          {.report = {}, .cancelled = progress_.cancelled}};
}

void RegionMaker::take(size_t r, RegionTrial trial) {
  ways_[r] = trial.way;
  model_.regions[r].skinned = trial.layout->region(trial.shape);
  layouts_[r] = std::move(trial.layout);
  first_[r] = std::move(trial.shape);
  rests_[r] = std::move(trial.rest);
}

void RegionMaker::lay_out_one(size_t r) {
  const RegionWish wish = wish_of(r);
  std::optional<RegionTrial> trial;
  if (ways_[r]) trial = try_again(wish, *ways_[r], frame(), options_.material);
  if (!trial) {
    trial = try_region(wish, frame(), options_.material);
    model_.regions[r].warnings = trial->warnings;
  }
  take(r, std::move(*trial));
}

bool RegionMaker::lay_out_otherwise(int region) {
  const auto r = static_cast<size_t>(region);
  if (ways_[r]->skin.convex) return false;  // how it turns there means nothing
  auto trial = try_other(wish_of(r), layouts_[r]->domain(), frame(), options_.material);
  if (!trial) return false;
  model_.regions[r].warnings = trial->warnings;
  take(r, std::move(*trial));
  return true;
}

bool RegionMaker::lay_out_bending(int region) {
  const auto r = static_cast<size_t>(region);
  if (rests_[r].rows() == 0) return false;
  ways_[r]->skin.rest = false;
  lay_out({region}, 0.5, 0.5);
  model_.regions[r].warnings.push_back(
      "it bends from nothing: the sweep between its sides would turn over or sag where it goes on "
      "smoothly in its neighbours");
  return true;
}

void RegionMaker::leave_out(int r, const std::string& why) {
  ModelRegion& region = model_.regions[r];
  region.why_not = why;
  region.skinned.reset();
  region.in_layout = -1;
  layouts_[r] = nullptr;
}

ModelFrame RegionMaker::frame() const {
  return {options_.name, network_.size(), tolerance_, origin_, options_.join_tolerance_deg,
          options_.rest};
}

std::optional<JoinSide> RegionMaker::side_of(const ArcSide& use, int arc) const {
  const auto& made = model_.regions[use.region].skinned;
  return made ? batten::side_of(*made, use.region, network_.arcs()[arc].name) : std::nullopt;
}

void RegionMaker::halve(int a) {
  const GivenCurve& given = *given_[a];
  auto finer = std::make_shared<GivenCurve>(GivenCurve{given.curve, {}});
  for (size_t i = 0; i + 1 < given.vertices.size(); ++i) {
    finer->vertices.push_back(given.vertices[i]);
    finer->vertices.push_back(0.5 * (given.vertices[i] + given.vertices[i + 1]));
  }
  finer->vertices.push_back(given.vertices.back());
  given_[a] = std::move(finer);
}

}  // namespace batten
