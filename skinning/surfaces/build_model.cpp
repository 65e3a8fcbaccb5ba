// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/surfaces/build_model.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <optional>
#include <utility>

#include "batten/core/cancellation.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/log.h"
#include "batten/skinning/domains/outline.h"
#include "batten/skinning/model/model_shapes.h"
#include "batten/skinning/search/find_regions.h"
#include "batten/skinning/surfaces/loft_plan.h"
#include "batten/skinning/surfaces/normal_side.h"
#include "batten/skinning/surfaces/section_region.h"
#include "batten/skinning/surfaces/skin_network.h"

namespace batten {
namespace {

double sampled_size(const std::vector<CharacterLine>& lines) {
  constexpr int samples = 16;  // per line
  std::vector<Vec3> points;
  for (const CharacterLine& line : lines)
    for (int i = 0; i <= samples; ++i)
      points.push_back(line.curve->evaluate(
          line.curve->start() + (line.curve->end() - line.curve->start()) * i / samples));
  return bounding_box(points).diagonal().norm();
}

/// Builds the model of one call of build_model().
class ModelBuilder {
 public:
  ModelBuilder(const std::vector<CharacterLine>& lines, const ModelBuildOptions& options,
               const Progress& progress)
      : lines_(lines), options_(options), skin_(options.model.skin), progress_(progress) {}

  BuiltModel build() const {
    if (options_.single_face) {
      if (options_.sections.size() > 1) {
        const CurveNetwork network = build_network(lines_, options_, progress_);
        if (const auto plan = loft_through(network, options_.sections))
          if (auto made = between_sections(network, *plan)) return std::move(*made);
      }
      return one_region(specified_sections());
    }
    progress_.update("network", 0);
    const bool specs = !options_.search.specs.empty() || !options_.model.joins.empty() ||
                       !options_.model.neighbours.empty();
    if (!specs && outlines_bound_one_region()) return one_region({});
    BuiltModel made;
    made.network.emplace(build_network(lines_, options_, progress_));
    if (!specs)
      if (const auto plan = find_loft(*made.network))
        if (auto loft = between_sections(*made.network, *plan)) return std::move(*loft);
    if (!specs)
      if (const std::vector<CharacterLine> row = ordered_sections(*made.network); !row.empty()) {
        made = one_region(row);
        made.sections = {};
        for (const CharacterLine& section : row) made.sections.push_back(section.name);
        return made;
      }
    progress_.update("faces", 0);
    made.found.emplace(require_regions(*made.network, options_, progress_));
    // A single surface gets the name of the model.
    std::vector<NetworkRegion>& regions = made.found->regions;
    if (regions.size() == 1 && !regions[0].requested) regions[0].name = options_.model.name;
    skin(made);
    // If there is only one region, its failure is the error of the model.
    if (regions.size() == 1 && !made.model.layout)
      throw InputError(options_.where + made.model.regions[0].rejection_reason);
    return made;
  }

 private:
  // The lines of a model that consists of sections only, in order; else empty.
  std::vector<CharacterLine> specified_sections() const {
    const auto& sections = options_.sections;
    if (sections.size() < 2 || sections.size() != lines_.size()) return {};
    std::vector<CharacterLine> in_order;
    for (const std::string& section : sections) {
      const auto it = std::find_if(lines_.begin(), lines_.end(),
                                   [&](const CharacterLine& l) { return l.name == section; });
      if (it == lines_.end()) return {};  // loft_shape() reports which one
      in_order.push_back(*it);
    }
    return in_order;
  }

  // Creates the layout of a region, with normals on the side defined in normal_side.h.
  RegionLayout oriented_layout(const std::vector<CharacterLine>& sections) const {
    const auto layout = [&](const SkinOptions& options) {
      return sections.empty() ? RegionLayout(options_.model.name, lines_, options, progress_)
                              : section_region(options_.model.name, sections, options, progress_);
    };
    SkinOptions options = skin_;
    // The default mesh suffices for the side.
    const double stated = std::exchange(options.edge_length, 0);
    const RegionLayout usual = layout(options);
    try {
      const ModelLayout model(usual);
      const Points rest = options_.model.rest ? rest_dofs(model) : Points();
      const Points shape =
          rest.rows() > 0 ? rest : model.minimize_energy(options_.model.material, Points());
      const SkinnedRegion region = usual.region(shape);
      options.reverse_orientation = !normal_side(side_integrals({&region}), false).agrees;
    } catch (const CancelledError&) {
      throw;
    } catch (const Error&) {
      // Errors of the shape are reported when it is solved.
    }
    options.edge_length = stated;
    return stated > 0 || options.reverse_orientation ? layout(options) : usual;
  }

  // Builds the model of a single region.
  BuiltModel one_region(const std::vector<CharacterLine>& sections) const {
    BuiltModel made;
    try {
      made.model.layout = std::make_shared<const ModelLayout>(oriented_layout(sections));
    } catch (const InputError& e) {
      std::string text = e.what();
      const size_t named = options_.sections.size();
      const auto* crossing = dynamic_cast<const OutlineIntersection*>(&e);
      if (!sections.empty() && crossing && std::ranges::any_of(crossing->curves(), is_rail))
        text += "; rails run through the ends of the sections in their order";
      else if (sections.empty() && named > 1)
        text +=
            "; " + std::to_string(named) + " of " + std::to_string(lines_.size()) +
            " curves are sections: a loft without boundary curves needs all of them as sections";
      throw InputError(options_.where + text);
    }
    made.fit_tolerance = made.model.layout->tolerance();
    ModelRegion& region = made.model.regions.emplace_back();
    region.plan.name = options_.model.name;
    region.layout_index = 0;
    region.warnings = made.model.layout->warnings();
    return made;
  }

  // True if the outlines alone bound one region, on which all curves with another role lie.
  bool outlines_bound_one_region() const {
    std::vector<CharacterLine> outlines;
    std::copy_if(
        lines_.begin(), lines_.end(), std::back_inserter(outlines),
        [](const CharacterLine& line) { return line.role == CharacterLine::Role::Outline; });
    if (outlines.size() == lines_.size() && !options_.fix_corners_only) return false;
    if (outlines.empty()) return true;  // the error of the single region explains what is missing
    const CurveNetwork network = build_network(outlines, options_, progress_);
    const FoundRegions found = find_regions(network, {}, progress_);
    return found.regions.empty() || (found.regions.size() == 1 && found.unused_edges.empty());
  }

  // Skins the regions of the network.
  void skin(BuiltModel& made, const std::vector<JoinSpec>& more_joins = {}) const {
    ModelOptions options = options_.model;
    options.joins.insert(options.joins.end(), more_joins.begin(), more_joins.end());
    if (options_.tolerance)
      options.skin.tolerance = options_.tolerance(sampled_size(made.network->lines()));
    made.model = skin_network(*made.network, *made.found, options, progress_);
    constexpr double usual = 1e-4;  // of the size
    made.fit_tolerance = options_.tolerance    ? options_.tolerance(made.network->size())
                         : skin_.tolerance > 0 ? skin_.tolerance
                                               : usual * made.network->size();
  }

  // Surfaces between sections with corners, bounded by guides and by rails through corresponding
  // points. Nullopt if the sections have no rails.
  std::optional<BuiltModel> between_sections(const CurveNetwork& network,
                                             const LoftPlan& plan) const {
    auto loft = loft_network(network, plan, options_, progress_);
    if (!loft) return std::nullopt;
    BuiltModel made;
    made.network = std::move(loft->network);
    made.found = std::move(loft->found);
    made.added_curves = std::move(loft->rails);
    std::vector<JoinSpec> creases;
    for (const std::string& rail : loft->creases)
      creases.push_back({rail, JoinSpec::Kind::Crease, ""});
    skin(made, creases);
    return made;
  }

  const std::vector<CharacterLine>& lines_;
  const ModelBuildOptions& options_;
  const SkinOptions& skin_;
  const Progress& progress_;
};

}  // namespace

std::vector<std::string> BuiltModel::region_names() const {
  std::vector<std::string> names;
  for (const ModelRegion& region : model.regions)
    if (region.layout_index >= 0) names.push_back(region.plan.name);
  return names;
}

CurveNetwork build_network(const std::vector<CharacterLine>& lines,
                           const ModelBuildOptions& options, const Progress& progress) {
  NetworkOptions network = options.network;
  network.fit_tolerance =
      options.tolerance ? options.tolerance(sampled_size(lines)) : options.model.skin.tolerance;
  network.corner_angle = options.model.skin.corner_angle;
  try {
    return CurveNetwork(lines, network, progress);
  } catch (const InputError& e) {
    throw InputError(options.network_where + e.what());
  }
}

FoundRegions require_regions(const CurveNetwork& network, const ModelBuildOptions& options,
                             const Progress& progress) {
  FoundRegions found = find_regions(network, options.search, progress);
  if (!found.regions.empty()) return found;
  std::string text = options.network_where + "found no closed loop of curves that " +
                     "bounds a face, expected at least one (gap tolerance " +
                     format_number(network.tolerance()) +
                     (options.unit.empty() ? "" : " " + options.unit) + ")";
  int more = 0;
  for (const NetworkDiagnostic& diagnostic : network.diagnostics()) {
    if (diagnostic.repaired) continue;
    constexpr int most = 5;
    if (++more <= most) text += "; " + diagnostic.text;
  }
  throw InputError(text);
}

std::optional<LoftNetwork> loft_network(const CurveNetwork& network, const LoftPlan& plan,
                                        const ModelBuildOptions& options,
                                        const Progress& progress) {
  const std::vector<CharacterLine> rails = loft_rails(network, plan);
  if (rails.empty() && plan.guides.size() < 2) return std::nullopt;
  std::vector<CharacterLine> lines = network.lines();
  lines.insert(lines.end(), rails.begin(), rails.end());
  ModelBuildOptions finer = options;
  finer.network.tolerance = std::min(network.tolerance(), rail_tolerance(rails));
  LoftNetwork loft{build_network(lines, finer, progress), {}, {}, {}};
  for (const CharacterLine& rail : rails) loft.rails.push_back(rail.name);
  loft.creases = rails_at_corners(network, plan, rails);
  if (auto faces = loft_faces(loft.network, network, plan, rails))
    loft.found = std::move(*faces);
  else
    loft.found = require_regions(loft.network, finer, progress);
  return loft;
}

namespace {

void log_model(const SurfaceModel& model) {
  log(LogLevel::Info, [&] {
    const auto count = [](size_t n, const std::string& what) {
      return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
    };
    return "model of " + count(model.regions.size(), "face") + ", " +
           count(model.layout ? static_cast<size_t>(model.layout->mesh()->triangle_count()) : 0,
                 "element");
  });
  for (const std::string& warning : model.warnings) log(LogLevel::Warning, [&] { return warning; });
  for (const ModelRegion& region : model.regions)
    for (const std::string& warning : region.warnings)
      log(LogLevel::Warning, [&] { return "face '" + region.plan.name + "': " + warning; });
}

}  // namespace

BuiltModel build_model(const std::vector<CharacterLine>& lines, const ModelBuildOptions& options,
                       const Progress& progress) {
  const ProgressScope scope(progress);
  BuiltModel built = ModelBuilder(lines, options, progress).build();
  log_model(built.model);
  return built;
}

}  // namespace batten
