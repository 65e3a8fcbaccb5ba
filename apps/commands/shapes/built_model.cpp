#include "batten/apps/commands/shapes/built_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <string>
#include <utility>

#include "batten/apps/commands/lines/scene_lines.h"
#include "batten/apps/commands/shapes/scene_target.h"
#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/skinning/model/model_shapes.h"
#include "batten/skinning/search/find_regions.h"
#include "batten/skinning/surfaces/normal_side.h"
#include "batten/skinning/surfaces/section_region.h"
#include "batten/skinning/surfaces/skin_network.h"

namespace batten {
namespace {

double fit_tolerance(const Scene& scene, double size) {
  constexpr double usual = 1e-4, of_target = 0.1;
  if (scene.skin.options.tolerance > 0) return scene.skin.options.tolerance;
  return scene.targets.empty() ? usual * size : of_target * target_tolerance(scene, size);
}

double size_of(const std::vector<CharacterLine>& lines) {
  constexpr int samples = 16;  // per line
  std::vector<Vec3> points;
  for (const CharacterLine& line : lines)
    for (int i = 0; i <= samples; ++i)
      points.push_back(line.curve->evaluate(
          line.curve->start() + (line.curve->end() - line.curve->start()) * i / samples));
  return bounding_box(points).diagonal().norm();
}

// The lines of a scene that consists of sections only, in order; else empty.
std::vector<CharacterLine> specified_sections(const Scene& scene,
                                              const std::vector<CharacterLine>& lines) {
  const auto& sections = scene.skin.sections;
  if (sections.size() < 2 || sections.size() != lines.size()) return {};
  std::vector<CharacterLine> in_order;
  for (const LocatedString& section : sections) {
    const auto it = std::find_if(lines.begin(), lines.end(),
                                 [&](const CharacterLine& l) { return l.name == section.text; });
    if (it == lines.end()) return {};  // loft_shape() reports which one
    in_order.push_back(*it);
  }
  return in_order;
}

// Creates the layout of a region, with normals on the side defined in normal_side.h.
RegionLayout make_layout(const Scene& scene, const std::vector<CharacterLine>& lines,
                         const std::vector<CharacterLine>& sections, const Progress& progress) {
  const auto layout = [&](const SkinOptions& options) {
    return sections.empty() ? RegionLayout(scene.name, lines, options, progress)
                            : section_region(scene.name, sections, options, progress);
  };
  SkinOptions options = scene.skin.options;
  const double stated = std::exchange(options.edge_length, 0);  // the default mesh suffices for the
                                                                // side
  const RegionLayout usual = layout(options);
  try {
    const ModelLayout model(usual);
    const Points rest = scene.skin.has_rest() ? rest_dofs(model) : Points();
    const Points shape =
        rest.rows() > 0 ? rest : model.minimize_energy(scene.skin.material, Points());
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
BuiltModel one_region(const Scene& scene, const std::vector<CharacterLine>& lines,
                      const std::vector<CharacterLine>& sections, const Progress& progress) {
  BuiltModel made;
  try {
    made.model.layout =
        std::make_shared<const ModelLayout>(make_layout(scene, lines, sections, progress));
  } catch (const InputError& e) {
    std::string text = e.what();
    const size_t named = scene.skin.sections.size();
    if (!sections.empty() && text.find("'rail ") != std::string::npos)
      text += "; rails run through the ends of the sections in the order of 'sections'";
    else if (sections.empty() && named > 1)
      text += "; 'sections' names " + std::to_string(named) + " of " +
              std::to_string(lines.size()) +
              " curves: a loft without boundary curves needs all of them as sections";
    throw InputError(scene.at({}) + text);
  }
  made.fit_tolerance = made.model.layout->tolerance();
  ModelRegion& region = made.model.regions.emplace_back();
  region.plan.name = scene.name;
  region.layout_index = 0;
  region.warnings = made.model.layout->warnings();
  return made;
}

}  // namespace

CurveNetwork network_of(const Scene& scene, const std::vector<CharacterLine>& lines,
                        const Progress& progress) {
  NetworkOptions options;
  options.tolerance = scene.network.tolerance;
  options.fit_tolerance =
      scene.targets.empty() ? scene.skin.options.tolerance : fit_tolerance(scene, size_of(lines));
  options.corner_angle = scene.skin.options.corner_angle;
  options.tangent_angle = scene.network.tangent_angle;
  try {
    return CurveNetwork(lines, options, progress);
  } catch (const InputError& e) {
    throw InputError(scene.at(scene.network.location) + e.what());
  }
}

FoundRegions regions_of(const Scene& scene, const CurveNetwork& network, const Progress& progress) {
  RegionSearchOptions options;
  options.specs = mirrored_regions(scene, network.lines());
  options.max_faces_per_edge = scene.network.max_faces_per_edge;
  FoundRegions found = find_regions(network, options, progress);
  if (!found.regions.empty()) return found;
  std::string text = scene.at(scene.network.location) + "found no closed loop of curves that " +
                     "bounds a face, expected at least one (gap tolerance " +
                     format_number(network.tolerance()) + " " + scene.unit + ")";
  int more = 0;
  for (const NetworkDiagnostic& diagnostic : network.diagnostics()) {
    if (diagnostic.repaired) continue;
    constexpr int most = 5;
    if (++more <= most) text += "; " + diagnostic.text;
  }
  throw InputError(text);
}

std::vector<std::string> BuiltModel::region_names() const {
  std::vector<std::string> names;
  for (const ModelRegion& region : model.regions)
    if (region.layout_index >= 0) names.push_back(region.plan.name);
  return names;
}

bool specifies_single_region(const Scene& scene) {
  using MeshAlignment = CharacterLine::MeshAlignment;
  const SceneSkin& skin = scene.skin;
  const SkinOptions& options = skin.options;
  if (!scene.network.regions.empty() || !scene.network.joins.empty() || scene.network.symmetry)
    return false;
  return options.domain != SkinOptions::Domain::Auto || options.minimize_distortion ||
         options.mesher != SkinOptions::Mesher::Delaunay || options.fan_refinements >= 0 ||
         !skin.isotropic_alpha || !skin.isotropic_beta || skin.fair == SceneSkin::Fair::Loft ||
         std::any_of(scene.lines.begin(), scene.lines.end(), [](const SceneLine& line) {
           return line.mesh_alignment != MeshAlignment::Auto;
         });
}

namespace {

bool bounds(const CharacterLine& line) { return line.role == CharacterLine::Role::Outline; }

// True if the outlines alone bound one region, on which all curves with another role lie.
bool outlines_bound_one_region(const Scene& scene, const std::vector<CharacterLine>& lines,
                               const Progress& progress) {
  std::vector<CharacterLine> outlines;
  std::copy_if(lines.begin(), lines.end(), std::back_inserter(outlines), bounds);
  if (outlines.size() == lines.size() && scene.skin.boundary == SceneSkin::FixedBoundary::Lines)
    return false;
  if (outlines.empty()) return true;  // the error of the single region explains what is missing
  const CurveNetwork network = network_of(scene, outlines, progress);
  const FoundRegions found = find_regions(network, {}, progress);
  return found.regions.empty() || (found.regions.size() == 1 && found.unused_edges.empty());
}

// Skins the regions of the network.
void skin(BuiltModel& made, const Scene& scene, const Progress& progress) {
  const std::vector<CharacterLine>& lines = made.network->lines();
  ModelOptions options;
  options.name = scene.name;
  options.skin = scene.skin.options;
  if (!scene.targets.empty()) options.skin.tolerance = fit_tolerance(scene, size_of(lines));
  options.material = scene.skin.material;
  options.joins = mirrored_joins(scene, lines);
  options.rest = scene.skin.has_rest();
  options.crease_angle_deg = scene.network.crease_angle;
  options.join_tolerance_deg = scene.network.join_tolerance;
  made.model = skin_network(*made.network, *made.found, options, progress);
  made.fit_tolerance = fit_tolerance(scene, made.network->size());
}

// Surfaces between closed sections with a corner. Each bay gets two of them, bounded by rails
// through the corners and through the noses (opposite ends). The sections themselves bound no
// surface.
BuiltModel between_cornered(const Scene& scene, const std::vector<CharacterLine>& sections,
                            const Progress& progress) {
  std::vector<CharacterLine> lines = sections;
  for (CharacterLine& rail : corner_rails(sections)) lines.push_back(std::move(rail));
  BuiltModel made;
  made.network.emplace(network_of(scene, lines, progress));
  RegionSearchOptions options;
  for (const CharacterLine& section : sections) {
    RegionSpec spec;
    spec.kind = RegionSpec::Kind::NoSurface;
    spec.loops = {{section.name}};
    options.specs.push_back(std::move(spec));
  }
  made.found.emplace(find_regions(*made.network, options, progress));
  skin(made, scene, progress);
  return made;
}

}  // namespace

BuiltModel build_model(const Scene& scene, const std::vector<CharacterLine>& lines,
                       const Progress& progress) {
  if (specifies_single_region(scene)) {
    const std::vector<CharacterLine> sections = specified_sections(scene, lines);
    if (have_corner_at_seam(sections, scene.skin.options.corner_angle))
      return between_cornered(scene, sections, progress);
    return one_region(scene, lines, sections, progress);
  }
  progress.update("network", 0);
  const bool specs = !scene.network.regions.empty() || !scene.network.joins.empty();
  if (!specs && outlines_bound_one_region(scene, lines, progress))
    return one_region(scene, lines, {}, progress);
  BuiltModel made;
  made.network.emplace(network_of(scene, lines, progress));
  if (!specs)
    if (const std::vector<CharacterLine> row = ordered_sections(*made.network); !row.empty()) {
      if (have_corner_at_seam(row, scene.skin.options.corner_angle))
        return between_cornered(scene, row, progress);
      made = one_region(scene, lines, row, progress);
      made.sections = {};
      for (const CharacterLine& section : row) made.sections.push_back(section.name);
      return made;
    }
  progress.update("faces", 0);
  made.found.emplace(regions_of(scene, *made.network, progress));
  // A single surface gets the name of its scene.
  std::vector<NetworkRegion>& regions = made.found->regions;
  if (regions.size() == 1 && !regions[0].requested) regions[0].name = scene.name;
  skin(made, scene, progress);
  // If there is only one region, its failure is the error of the scene.
  if (regions.size() == 1 && !made.model.layout)
    throw InputError(scene.at({}) + made.model.regions[0].rejection_reason);
  return made;
}

namespace {

using Curves = std::map<std::string, HermiteCurve>;

/// The curves of all lines of the regions, by name.
Curves curves_of_regions(const BuiltModel& made) {
  Curves curves;
  for (const SkinnedRegion* region : made.model.skinned()) {
    for (const EdgeAlignedLine& aligned_line : region->edge_aligned)
      curves.try_emplace(aligned_line.line.name, aligned_line.fitted);
    for (const EmbeddedLine& line : region->embedded)
      curves.try_emplace(line.line.name, line.fitted);
  }
  return curves;
}

Vec3 start_of(const HermiteCurve& curve) { return curve.position(0); }
Vec3 end_of(const HermiteCurve& curve) { return curve.evaluate(curve.end()); }
Vec3 last_slope(const HermiteCurve& curve) {
  return curve.slope_in(curve.closed() ? 0 : curve.node_count() - 1);
}

bool parallel(const Vec3& a, const Vec3& b) {
  constexpr double radians = 1e-6;
  return a.dot(b) > 0 && a.cross(b).norm() <= radians * a.norm() * b.norm();
}

/// A sequence of curves, each of which begins at the end of the previous one, as one curve. It is
/// C1 up to rounding of the slopes.
class Chain {
 public:
  explicit Chain(const HermiteCurve& first) { add(first); }

  /// True if the curve continues the chain at its end, in the same direction.
  bool continues(const HermiteCurve& next) const {
    return (start_of(next) - points_.back()).norm() <= merge_tolerance() &&
           parallel(slopes_.back(), next.slope_out(0));
  }
  void add(const HermiteCurve& next) {
    const double factor = points_.empty() ? 1 : next.slope_out(0).norm() / slopes_.back().norm();
    const double shift = points_.empty() ? next.start() : u_.back() - factor * next.start();
    const int nodes = next.closed() ? next.node_count() + 1 : next.node_count();
    for (int i = points_.empty() ? 0 : 1; i < nodes; ++i) {
      u_.push_back(shift + factor * next.parameters()[i]);
      points_.push_back(next.position(i % next.node_count()));
      slopes_.push_back(next.slope_out(i % next.node_count()) / factor);
    }
    if (!next.closed()) slopes_.back() = last_slope(next) / factor;
  }
  /// A chain that returns to its beginning in the same direction gives a closed curve.
  HermiteCurve curve() const {
    const bool closed = u_.size() > 2 &&
                        (points_.back() - points_.front()).norm() <= merge_tolerance() &&
                        parallel(slopes_.back(), slopes_.front()) &&
                        std::abs(slopes_.back().norm() / slopes_.front().norm() - 1) < 1e-6;
    const CurveMesh mesh(u_, closed);
    Points dofs(mesh.dof_count(), 3);
    for (int i = 0; i < mesh.node_count(); ++i) {
      dofs.row(mesh.position_dof(i)) = points_[i].transpose();
      dofs.row(mesh.slope_out(i)) = slopes_[i].transpose();
    }
    return {mesh, dofs};
  }

 private:
  double merge_tolerance() const {
    return 1e-9 * (u_.back() - u_.front()) * slopes_.front().norm();
  }
  std::vector<double> u_;
  std::vector<Vec3> points_, slopes_;
};

/// The curve of an edge in the direction of its line, taken from a region if it belongs to one.
HermiteCurve edge_along_line(const NetworkEdge& edge, const Curves& of_regions) {
  const auto found = of_regions.find(edge.name);
  if (found == of_regions.end()) return edge.reversed ? edge.curve.backwards() : edge.curve;
  // Regions store it in the direction of their loops. An edge that is a closed curve has no
  // preferred direction.
  const HermiteCurve& own = found->second;
  const bool turned =
      (start_of(own) - start_of(edge.curve)).norm() > (start_of(own) - end_of(edge.curve)).norm();
  return turned != edge.reversed ? own.backwards() : own;
}

}  // namespace

std::vector<CubicSpline> line_curves(const BuiltModel& made) {
  const Curves of_regions = curves_of_regions(made);
  std::vector<CubicSpline> splines;
  const auto add = [&](const std::string& name, const HermiteCurve& curve) {
    for (CubicSpline& spline : cubic_splines(name, curve)) splines.push_back(std::move(spline));
  };
  if (!made.network) {
    for (const auto& [name, curve] : of_regions) add(name, curve);
    return splines;
  }
  for (int l = 0; l < isize(made.network->lines()); ++l) {
    const std::string& name = made.network->lines()[l].name;
    std::vector<Chain> chains;
    std::vector<std::array<int, 2>> numbers;  // first and last edge number of each chain
    int number = 0;
    for (const int a : made.network->edges_of(name)) {
      const NetworkEdge& edge = made.network->edges()[a];
      ++number;
      if (edge.line != l) continue;  // belongs to another line
      const HermiteCurve curve = edge_along_line(edge, of_regions);
      if (!chains.empty() && chains.back().continues(curve)) {
        chains.back().add(curve);
        numbers.back()[1] = number;
      } else {
        chains.emplace_back(curve);
        numbers.push_back({number, number});
      }
    }
    for (size_t k = 0; k < chains.size(); ++k) {
      const auto [first, last] = numbers[k];
      const std::string part =
          "." + std::to_string(first) + (last > first ? "-" + std::to_string(last) : std::string());
      add(name + (chains.size() > 1 ? part : std::string()), chains[k].curve());
    }
  }
  return splines;
}

}  // namespace batten
