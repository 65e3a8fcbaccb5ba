// SPDX-License-Identifier: MPL-2.0
// Measures a solved shape for its report.

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/fairing/curves/input_curve.h"
#include "batten/fem/surface.h"
#include "batten/io/cad/cad_format.h"
#include "batten/io/files/text.h"
#include "batten/io/report/report.h"
#include "batten/scenes/lines/scene_neighbours.h"
#include "batten/scenes/shapes/shape_files.h"
#include "batten/skinning/lines/character_line.h"
#include "batten/skinning/model/model_shapes.h"

namespace batten {
namespace {

// Update an extreme value. NaN replaces any number, so that the report shows it.
void update_max(double& most, double value) {
  if (!(value <= most) && !std::isnan(most)) most = value;
}
void update_min(double& least, double value) {
  if (!(value >= least) && !std::isnan(least)) least = value;
}

/// Largest distance from samples of the input line to the fitted curve.
double deviation(const CharacterLine& line, const HermiteCurve& fitted) {
  const auto breaks = line.curve->breaks();
  const int samples = std::clamp<int>(2000 / isize(breaks), 4, 64);
  double largest = 0;
  for (size_t i = 0; i + 1 < breaks.size(); ++i)
    for (int k = 0; k <= samples; ++k) {
      const double t = breaks[i] + (breaks[i + 1] - breaks[i]) * k / samples;
      const double d = fitted.closest_point(line.curve->evaluate(t)).distance;
      if (!(d <= largest) && !std::isnan(largest)) largest = d;
    }
  return largest;
}

/// Limits from analytic shapes and hulls (docs/theory/domains.md); good domains stay far below
/// them.
void warn_of_strain(Report& report) {
  const SkinQuality& q = report.surface.quality;
  constexpr double most_shear = 5, most_strain = 0.7, least_jacobian = 0.1;
  if (q.max_shear <= most_shear && q.rms_strain <= most_strain &&
      q.min_jacobian_ratio >= least_jacobian)
    return;
  report.warnings.push_back(
      "the parametrization is distorted (shear " + format_number(q.max_shear) + ", strain " +
      format_number(q.rms_strain) + ", Jacobian " + format_number(q.min_jacobian_ratio) +
      " of its median), so that the surface may be uneven: try another domain, "
      "minimize_distortion = true, or inner curves with alignment = \"embedded\"");
}

SkinQuality worst_of(const SurfaceModel& model) {
  SkinQuality worst;
  bool first = true;
  for (const ModelRegion& r : model.regions) {
    if (!r.skinned) continue;
    const SkinQuality& q = r.quality;
    if (first) worst.min_jacobian_ratio = q.min_jacobian_ratio;
    first = false;
    update_max(worst.max_line_residual, q.max_line_residual);
    update_max(worst.max_line_gap, q.max_line_gap);
    update_max(worst.max_line_deviation, q.max_line_deviation);
    update_max(worst.max_normal_jump_deg, q.max_normal_jump_deg);
    update_min(worst.min_jacobian_ratio, q.min_jacobian_ratio);
    update_max(worst.max_shear, q.max_shear);
    update_max(worst.rms_strain, q.rms_strain);
    worst.singular_nodes += q.singular_nodes;
  }
  worst.area = model.area;
  return worst;
}

void measure_region_lines(Report& report, const SkinnedRegion& region) {
  for (const EdgeAlignedLine& run : region.edge_aligned)
    report.lines.push_back({run.line.name, run.line.role, false, ArcLength(run.line.curve).total(),
                            deviation(run.line, run.fitted), run.fitted.node_count()});
  for (const EmbeddedLine& e : region.embedded)
    report.lines.push_back({e.line.name, e.line.role, true, ArcLength(e.line.curve).total(),
                            deviation(e.line, e.fitted), e.fitted.node_count(), isize(e.points),
                            line_gap(region.surface, e), e.line.constrains_surface});
}

// Measures edges. An edge shared by several regions counts as embedded if it is embedded in any of
// them.
void measure_edges(Report& report, const BuiltModel& made, const Scene& scene) {
  struct Embedding {
    int points = 0;
    double gap = 0;
  };
  std::map<std::string, Embedding> embedded;
  std::map<std::string, double> moved;  // lengths of displaced lines
  for (const SkinnedRegion* region : made.model.skinned()) {
    for (const EmbeddedLine& e : region->embedded) {
      Embedding& of = embedded[e.line.name];
      of.points = std::max(of.points, isize(e.points));
      update_max(of.gap, line_gap(region->surface, e));
    }
    const auto note = [&](const std::string& name, const HermiteCurve& fitted) {
      for (const SceneLineOffset& move : scene.moves)
        if (move.line.text == name) moved[name] = fitted.length();
    };
    for (const EdgeAlignedLine& run : region->edge_aligned) note(run.line.name, run.fitted);
    for (const EmbeddedLine& e : region->embedded) note(e.line.name, e.fitted);
  }
  const CurveNetwork& network = *made.network;
  std::vector<char> outline(network.edges().size()), inner(outline.size());
  for (const ModelRegion& r : made.model.regions) {
    for (const EdgeLoop& loop : r.plan.loops)
      for (const OrientedEdge& use : loop) outline[use.edge] = 1;
    for (const int a : r.plan.inner) inner[a] = 1;
  }
  for (size_t a = 0; a < outline.size(); ++a) {
    if (!outline[a] && !inner[a]) continue;
    const NetworkEdge& edge = network.edges()[a];
    Report::Line line{
        edge.name,      outline[a] ? CharacterLine::Role::Outline : CharacterLine::Role::Inner,
        false,          edge.length,
        edge.deviation, edge.curve.node_count()};
    if (const auto m = moved.find(edge.name); m != moved.end()) line.length = m->second;
    if (const auto e = embedded.find(edge.name); e != embedded.end()) {
      line.embedded = true;
      line.points = e->second.points;
      line.gap = e->second.gap;
    }
    report.lines.push_back(line);
  }
}

void measure_network(Report& report, const BuiltModel& made, const Scene& scene) {
  measure_edges(report, made, scene);
  report.network = network_report(*made.network, *made.found, made.model, made.fit_tolerance,
                                  scene.network.join_tolerance);
  report.network->added_curves = made.added_curves;
  if (!scene.neighbours.empty() && !has_outlines(scene) && !has_blend(scene))
    for (const auto& join : report.network->joins)
      if (join.kind == "free edge")
        report.failed_checks.push_back(
            {"joins." + join.line, "is a free edge, expected a given face beside it"});
  report.surface.max_smooth_join_deg = made.model.max_join_deg;
  report.warnings.insert(report.warnings.end(), made.model.warnings.begin(),
                         made.model.warnings.end());
  for (const ModelRegion& r : made.model.regions)
    for (const std::string& w : r.warnings)
      report.warnings.push_back("face '" + r.plan.name + "': " + w);
  if (!made.found->optimal)
    report.warnings.push_back(
        "the search for faces was stopped early and may have missed better ones: specify faces by "
        "[[face]]");
}

// Orientation of the shells as text, most frequent first, with counts.
std::string describe_normals(const std::vector<ModelShell>& shells) {
  std::vector<std::pair<std::string, int>> said;
  for (const ModelShell& shell : shells) {
    const std::string text =
        shell.orientable ? shell.normals.text()
                         : "in no consistent direction (non-orientable or non-manifold surface)";
    const auto found = std::find_if(said.begin(), said.end(),
                                    [&](const auto& other) { return other.first == text; });
    if (found == said.end())
      said.emplace_back(text, 1);
    else
      ++found->second;
  }
  std::stable_sort(said.begin(), said.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  std::string all;
  for (const auto& [text, count] : said)
    all += (all.empty() ? "" : ", ") + text +
           (said.size() > 1 ? " (" + format_count(count, "shell") + ")" : "");
  return all;
}

// Orientation of the normals, and displacement of the surface by loads and constraints.
void measure_sides(Report::Surface& s, const BuiltModel& made, const SolvedShape& shape) {
  SideIntegrals all;
  for (const SkinnedRegion& region : shape.regions) all.add(side_integrals({&region}));
  s.mean_normal = all.area_vector / all.area;
  s.normals = made.network ? describe_normals(made.model.shells) : normal_side(all, false).text();
  if (!shape.layout || shape.unloaded.rows() != shape.dofs.rows()) return;
  const DofMap dofs(*shape.layout->mesh());
  for (int v = 0; v < shape.layout->mesh()->vertex_count(); ++v)
    update_max(s.moved,
               (shape.dofs.row(dofs.vertex(v)) - shape.unloaded.row(dofs.vertex(v))).norm());
}

void add_distances(const Distances& more, Report::Target& to) {
  const double squares = to.rms * to.rms * to.points + more.rms * more.rms * more.points;
  to.points += more.points;
  to.excluded += more.excluded;
  to.rms = to.points > 0 ? std::sqrt(squares / to.points) : 0;
  if (more.largest > to.max) {
    to.max = more.largest;
    to.where = more.where;
  }
}

// Distance of the fitted shape from its target.
void measure_target(Report& report, const ModelFit& fit, const Scene& scene) {
  Report::Target before, t;
  for (const Distances& region : fit.before.regions) add_distances(region, before);
  for (const Distances& region : fit.after.regions) add_distances(region, t);
  for (const SceneTarget& target : scene.targets)
    t.files.push_back(target.mesh ? "mesh of the scene" : target.file.filename().string());
  t.size = fit.layout->size();
  t.tolerance = target_tolerance(scene, t.size);
  t.before_rms = before.rms;
  t.before_max = before.max;
  t.back_rms = fit.after.back.rms;
  t.back_max = fit.after.back.largest;
  t.back_points = fit.after.back.points;
  t.back_excluded = fit.after.back.excluded;
  t.iterations = fit.iterations;
  t.refinements = fit.refinements;
  t.reached = fit.reached;
  const auto& lines = fit.layout->lines();
  for (size_t l = 0; l < lines.size(); ++l)
    if (fit.after.lines[l].largest > t.tolerance)
      t.line_distances.push_back({lines[l].name, fit.after.lines[l].largest});
  std::sort(t.line_distances.begin(), t.line_distances.end(),
            [](const auto& a, const auto& b) { return a.distance > b.distance; });
  for (int r = 0; r < fit.layout->region_count(); ++r)
    t.regions.emplace_back(fit.layout->region(r).name(), fit.after.regions[r].largest);
  if (!t.reached) {
    std::string why;
    if (!t.line_distances.empty())
      why = "; " + format_count(isize(t.line_distances), "curve") +
            (t.line_distances.size() == 1 ? " is" : " are") +
            " farther from the target than that, '" + t.line_distances.front().name + "' by " +
            format_number(t.line_distances.front().distance);
    report.failed_checks.push_back(
        {"target", "is at a distance of " + format_number(std::max(t.max, t.back_max)) +
                       " from the surface, expected at most " + format_number(t.tolerance) + why});
  }
  t.analytic = fit.analytic;
  for (int r = 0; r < fit.layout->region_count(); ++r)
    if (fit.primitives[r].kind != FittedPrimitive::Kind::Free)
      t.primitives[fit.layout->region(r).name()] = fit.primitives[r];
  report.target = std::move(t);
}

// Warns if a surface departs from the shape that its boundary curves suggest, because it minimises
// bending or variation, or because smooth joins pull it. Inner curves, loads and targets are no
// such reason.
void warn_of_departures(Report& report, const SolvedShape& shape, const Scene& scene) {
  if (!shape.layout || scene.is_sculpted() || !scene.targets.empty() || shape.fairing.lofted ||
      scene.skin.boundary != SceneSkin::FixedBoundary::Lines)
    return;
  const ModelLayout& layout = *shape.layout;
  const bool free = scene.skin.fair != SceneSkin::Fair::Auto;
  std::vector<char> joined(shape.regions.size(), free);
  for (const JoinPlan& plan : layout.join_plans())
    if (!plan.rejected())
      for (const JoinSide& side : plan.join_line.sides) joined[side.region] = 1;
  std::vector<std::optional<RestShapeDeviation>> found(shape.regions.size());
  parallel_for(isize(found), [&](int r) {
    const SkinnedRegion& region = shape.regions[r];
    const auto inner = [](const auto& l) { return l.line.role == CharacterLine::Role::Inner; };
    if (!joined[r] || std::any_of(region.edge_aligned.begin(), region.edge_aligned.end(), inner) ||
        std::any_of(region.embedded.begin(), region.embedded.end(), inner))
      return;
    found[r] = rest_shape_deviation(layout.region(r), region);
  });
  for (int r = 0; r < isize(found); ++r) {
    if (!found[r]) continue;
    const RestShapeDeviation& d = *found[r];
    const double thickness = scene.stress ? scene.stress->thickness : 0;
    const bool thick = thickness > 0 && d.distance > thickness;
    // Smooth joins are meant to pull thin sections.
    const bool large = free ? d.is_large() : d.distance > 0.1 * d.across;
    if (!large && !thick) continue;
    const bool sections = free && d.depth > 0 && d.distance > 0.5 * d.depth;
    report.warnings.push_back(
        "face '" + layout.region(r).name() +
        "' deviates from the blend of its boundary curves by " + format_number(d.distance) + " " +
        scene.unit + " at " + format_point(d.at) + ", " +
        format_number(std::round(100 * d.distance / (sections ? d.depth : d.across))) +
        " % of the " + (sections ? "depth of its sections" : "distance between its sides") +
        (thick ? " and more than its thickness, which changes the stresses; " : "; ") +
        (free ? "fair = \"auto\" avoids this"
              : "its smooth edges cause this, [[join]] continuity = \"G0\" avoids it"));
  }
}

}  // namespace

void measure_into(RunContext& run, BuiltModel& made, const SolvedShape& shape, const Scene& scene,
                  const Progress& progress) {
  set_shape(made, shape, progress);
  Report& report = run.report;
  auto& s = report.surface;
  s.element = scene.skin.options.element == TriangleElement::HCT ? "hct" : "z12";
  s.regions = isize(shape.regions);
  s.size = made.network ? made.network->size() : shape.layout->size();
  if (shape.layout) {
    s.triangles = shape.layout->mesh()->triangle_count();
    s.dofs = DofMap(*shape.layout->mesh()).count();
  }
  s.quality = worst_of(made.model);
  report.defects = defect_reports(made.model);
  if (made.network) {
    measure_network(report, made, scene);
  } else {
    measure_region_lines(report, shape.regions.front());
    report.warnings.insert(report.warnings.end(), made.model.regions.front().warnings.begin(),
                           made.model.regions.front().warnings.end());
    warn_of_strain(report);
  }
  measure_sides(s, made, shape);
  s.bending_energy = shape.energy.bending;
  s.max_constraint_residual = shape.max_constraint_residual;
  s.max_normal_constraint_deg = shape.max_normal_constraint_deg;
  s.iterations = shape.iterations;
  s.last_change = shape.last_change;
  if (shape.fairing.surface) {
    const MinimumVariationSurface& f = *shape.fairing.surface;
    s.fairing = {f.functional,     f.start_functional, f.max_move, f.iterations,
                 f.factorizations, f.converged,        f.fraction, {}};
    s.fairing->requested = shape.fairing.requested;
    s.fairing->regions = shape.fairing.regions;
    for (const UnchangedRegion& unchanged_regions : shape.fairing.unchanged_regions) {
      s.fairing->unchanged_regions.push_back(shape.layout->region(unchanged_regions.region).name());
      if (!shape.fairing.requested) continue;
      report.warnings.push_back("face '" + s.fairing->unchanged_regions.back() +
                                "' is not faired and keeps the shape of minimum bending energy: " +
                                unchanged_regions.why);
    }
    if (!shape.fairing.failure_reason.empty())
      report.warnings.push_back(
          "the surface is not faired and keeps the shape of minimum bending energy: " +
          shape.fairing.failure_reason);
    constexpr double far = 0.1;
    if (shape.fairing.requested && f.max_move > far * s.size)
      report.warnings.push_back("fairing moved the surface by " +
                                format_number(f.max_move / s.size) +
                                " of the size: its curves hardly determine the shape");
  }
  warn_of_departures(report, shape, scene);
  if (shape.fairing.fit) measure_target(report, *shape.fairing.fit, scene);
  report.scans = shape.scans;
  report.reactions = shape.reactions;
  if (shape.joins_planned)
    report.warnings.push_back(
        "moved curves rotate the tangents at their ends, so that smooth edges there were set up "
        "again");
  run.watch.lap("measure");
}

}  // namespace batten
