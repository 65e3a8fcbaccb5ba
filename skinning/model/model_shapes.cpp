// SPDX-License-Identifier: MPL-2.0
#include "batten/skinning/model/model_shapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/elements/quadrature.h"
#include "batten/fem/refinement.h"
#include "batten/fem/surface_assembler.h"
#include "batten/skinning/model/boundary_sweep.h"
#include "batten/skinning/model/join_edge.h"
#include "batten/skinning/model/section_surface.h"

namespace batten {

Points rest_dofs(const RegionLayout& region) {
  if (!region.uses_rest_shape()) return {};
  if (is_annulus(region)) return SectionSurface(region, 0).dofs();
  const auto sweep = BoundarySweep::of(region);
  return sweep ? sweep->dofs().value_or(Points()) : Points();
}

double reliable_rest_area(const RegionLayout& region, const Points& rest) {
  constexpr double similar = 0.25;
  if (rest.rows() == 0 || is_annulus(region)) return 0;
  const auto sweep = BoundarySweep::of(region);
  if (!sweep || !(sweep->mismatch() < similar)) return 0;
  return region.region(rest).surface.area();
}

bool has_many_sides(const RegionLayout& region) { return BoundarySweep::has_many_sides(region); }

Points rest_dofs(const ModelLayout& layout) {
  if (!layout.has_rest()) return {};
  std::vector<Points> rests(static_cast<size_t>(layout.region_count()));
  parallel_for(layout.region_count(), [&](int r) { rests[r] = rest_dofs(layout.region(r)); });
  std::vector<const Points*> of_regions;
  for (const Points& rest : rests) of_regions.push_back(&rest);
  return rest_dofs(layout, of_regions);
}

namespace {

// Faces with a closed smooth outline and no rest shape, which smooth joins connect to faces with
// one.
std::vector<int> patches_between(const ModelLayout& layout,
                                 const std::vector<const Points*>& of_regions) {
  const auto has_rest = [&](int r) { return of_regions[static_cast<size_t>(r)]->rows() > 0; };
  std::set<int> patches;
  for (const JoinPlan& plan : layout.join_plans())
    for (size_t s = 0; s < 2; ++s) {
      const int mine = plan.join_line.sides[s].region, other = plan.join_line.sides[1 - s].region;
      if (!plan.rejected() && !has_rest(mine) && has_rest(other) &&
          layout.region(mine).corners().empty() && layout.region(mine).uses_rest_shape())
        patches.insert(mine);
    }
  return {patches.begin(), patches.end()};
}

// Gives patches the shape of least bending energy that continues their neighbours. Each solution
// with soft patches bends the neighbours by a fraction kSoft of the angle that remains.
void continue_neighbours(const ModelLayout& layout, const std::vector<int>& patches, Points& all) {
  constexpr double kSoft = 1e-2;
  constexpr int kRounds = 2;
  std::vector<SurfaceStiffness> materials(static_cast<size_t>(layout.mesh()->triangle_count()),
                                          SurfaceStiffness::isotropic(0, 1));
  for (const int r : patches)
    std::fill_n(materials.begin() + layout.first_triangle(r),
                layout.region(r).mesh()->triangle_count(), SurfaceStiffness::isotropic(0, kSoft));
  for (int round = 0; round < kRounds; ++round) {
    const Points shape = layout.nearest_shape(materials, all);
    for (const int r : patches) {
      const Points own = layout.region_dofs(r, shape);
      for (int d = 0; d < own.rows(); ++d) all.row(layout.dof_offsets(r)(d)) = own.row(d);
    }
  }
}

}  // namespace

Points rest_dofs(const ModelLayout& layout, const std::vector<const Points*>& of_regions) {
  Points all;
  for (int r = 0; r < layout.region_count(); ++r) {
    const Points& rest = *of_regions[static_cast<size_t>(r)];
    if (rest.rows() == 0) continue;
    if (all.rows() == 0) all = Points::Zero(layout.position_dofs().size(), 3);
    for (int d = 0; d < rest.rows(); ++d) all.row(layout.dof_offsets(r)(d)) = rest.row(d);
  }
  if (all.rows() > 0)
    if (const std::vector<int> patches = patches_between(layout, of_regions); !patches.empty())
      continue_neighbours(layout, patches, all);
  return all;
}

namespace {

constexpr int kBoundarySamples = 24;  // per boundary curve

std::vector<Vec3> samples(const HermiteCurve& curve) {
  std::vector<Vec3> points;
  for (int i = 0; i <= kBoundarySamples; ++i)
    points.push_back(
        curve.evaluate(curve.start() + (curve.end() - curve.start()) * i / kBoundarySamples));
  return points;
}

// Largest distance from the chord; for a closed curve the smallest distance from its centre.
double depth_of(const HermiteCurve& curve) {
  const std::vector<Vec3> points = samples(curve);
  if (curve.closed()) {
    Vec3 centre = Vec3::Zero();
    for (int i = 0; i < kBoundarySamples; ++i) centre += points[i] / kBoundarySamples;
    double least = std::numeric_limits<double>::infinity();
    for (const Vec3& p : points) least = std::min(least, (p - centre).norm());
    return least;
  }
  const Vec3 chord = points.back() - points.front();
  const Vec3 way = chord.norm() > 0 ? Vec3(chord.normalized()) : Vec3::Zero();
  double most = 0;
  for (const Vec3& p : points) {
    const Vec3 d = p - points.front();
    most = std::max(most, (d - way.dot(d) * way).norm());
  }
  return most;
}

double length_of(const HermiteCurve& curve) {
  const std::vector<Vec3> points = samples(curve);
  double length = 0;
  for (size_t i = 0; i + 1 < points.size(); ++i) length += (points[i + 1] - points[i]).norm();
  return length;
}

}  // namespace

std::optional<RestShapeDeviation> rest_shape_deviation(const RegionLayout& layout,
                                                       const SkinnedRegion& made) {
  const Points rest = rest_dofs(layout);
  if (rest.rows() == 0 || rest.rows() != made.surface.dofs().rows()) return std::nullopt;
  RestShapeDeviation found;
  const DofMap map(*layout.mesh());
  for (int v = 0; v < layout.mesh()->vertex_count(); ++v) {
    const Vec3 x = made.surface.dofs().row(map.vertex(v)), x_rest = rest.row(map.vertex(v));
    if (!((x - x_rest).norm() > found.distance)) continue;
    found.distance = (x - x_rest).norm();
    found.at = x;
  }
  double around = 0, depth = std::numeric_limits<double>::infinity();
  for (const auto& loop : layout.boundary())
    for (const BoundarySegment& piece : loop) {
      const auto i = static_cast<size_t>(piece.index);
      const HermiteCurve& curve = piece.kind == BoundarySegment::Kind::EdgeAligned
                                      ? layout.edge_aligned()[i].fitted
                                      : layout.embedded()[i].fitted;
      around += length_of(curve);
      const double of_curve = depth_of(curve);
      if (of_curve > 1e-2 * layout.size()) depth = std::min(depth, of_curve);
    }
  if (std::isfinite(depth)) found.depth = depth;
  const Surface surface(layout.mesh(), layout.element(), rest, layout.trim());
  double area = 0;
  for (int t = 0; t < layout.mesh()->triangle_count(); ++t)
    area += surface.area_vector({t, Vec3::Constant(1.0 / 3)}).norm() * layout.mesh()->shape(t).area;
  const double quarter = around / 4;
  found.across = quarter - std::sqrt(std::max(0.0, quarter * quarter - area));
  return found;
}

namespace {

// True if a line is a section, or part of one: "root.2" is part of the line "root" that was split
// at its corners. Removes the sections that it finds from `missing`.
bool is_section(const std::string& name, const std::vector<std::string>& sections,
                std::set<std::string>& missing) {
  const auto it = std::find_if(sections.begin(), sections.end(), [&](const std::string& s) {
    return name == s || name.starts_with(s + ".");
  });
  if (it != sections.end()) missing.erase(*it);
  return it != sections.end();
}

// The side of a region with four corners that a section is part of, or -1.
int side_of_sections(const RegionLayout& region, const std::vector<std::string>& sections,
                     std::set<std::string>& missing) {
  int side = -1;
  for (const EmbeddedLine& line : region.embedded()) is_section(line.line.name, sections, missing);
  for (const EdgeAlignedLine& aligned_line : region.edge_aligned()) {
    if (!is_section(aligned_line.line.name, sections, missing) || is_annulus(region) ||
        region.corners().size() != 4 || aligned_line.line.role != CharacterLine::Role::Outline)
      continue;
    const int found = domain_side(region, aligned_line);
    if (side >= 0 && found % 2 != side % 2)
      throw InputError("found section '" + aligned_line.line.name +
                       "' on a side adjacent to the other sections of face '" + region.name() +
                       "', expected opposite sides");
    side = found;
  }
  return side;
}

// Marks triangles in which `dofs` miss the loft by more than `most`, at sampled interior points.
void mark_misses(const RegionLayout& region, const SectionSurface& through, const Points& dofs,
                 double most, char* marks) {
  const Surface surface(region.mesh(), region.element(), dofs, region.trim());
  parallel_for_each<16>(surface.mesh().triangle_count(), [&](int t) {
    double miss = 0;
    for (const Vec3& L :
         {Vec3(1, 1, 1), Vec3(0.3, 1.35, 1.35), Vec3(1.35, 0.3, 1.35), Vec3(1.35, 1.35, 0.3)}) {
      const Vec2 uv = surface.mesh().shape(t).point(L / 3);
      miss = std::max(miss, (surface.position({t, L / 3}) - through.at(uv)).norm());
    }
    if (miss > most) marks[t] = 1;
  });
}

// Target dofs: those of the lofts, 0 in other regions. `marks`, unless null, receives marks of
// triangles that miss their loft.
Points wanted_dofs(const ModelLayout& layout, const std::vector<std::string>& sections, double most,
                   std::vector<char>* marks) {
  std::set<std::string> missing(sections.begin(), sections.end());
  Points wanted = Points::Zero(layout.position_dofs().size(), 3);
  bool lofted = false;
  for (int r = 0; r < layout.region_count(); ++r) {
    const RegionLayout& region = layout.region(r);
    const int side = side_of_sections(region, sections, missing);
    if (!is_annulus(region) && side < 0) continue;
    lofted = true;
    const SectionSurface through(region, side);
    const Points own = through.dofs();
    for (int d = 0; d < own.rows(); ++d) wanted.row(layout.dof_offsets(r)(d)) = own.row(d);
    if (marks) mark_misses(region, through, own, most, marks->data() + layout.first_triangle(r));
  }
  if (!missing.empty())
    throw InputError("section '" + *missing.begin() +
                     "' is neither a side of a face with four corners nor a curve inside one");
  if (!lofted)
    throw InputError(
        "found nothing to loft, expected an annular face, or 'sections' that are sides of a face "
        "with four corners (face '" +
        layout.region(0).name() + "' has " + std::to_string(layout.region(0).corners().size()) +
        ")");
  return wanted;
}

}  // namespace

Points loft_shape(const ModelLayout& layout, const std::vector<std::string>& sections) {
  return layout.nearest(wanted_dofs(layout, sections, 0, nullptr));
}

LoftedModel loft_model(std::shared_ptr<const ModelLayout> layout,
                       const std::vector<std::string>& sections, double most) {
  constexpr int kMaxRounds = 4;
  for (int round = 0;; ++round) {
    std::vector<char> marks(static_cast<size_t>(layout->mesh()->triangle_count()), 0);
    const Points wanted = wanted_dofs(*layout, sections, most, &marks);
    auto finer = std::make_shared<ModelLayout>(*layout);
    if (round == kMaxRounds || !finer->refine(marks)) return {layout, layout->nearest(wanted)};
    if (!finer->join_plans().empty()) finer->plan_joins(finer->minimize_energy({}));
    layout = std::move(finer);
  }
}

namespace {

// A line that begins at an end of a join line: its unit tangent there, its curvature vector and
// chord length.
struct CrossingLine {
  Vec3 direction, curvature;
  double length;
};

// Tangent and curvature of an edge-aligned line at its start or end, directed away from it.
CrossingLine crossing_line(const EdgeAlignedLine& aligned_line, bool at_end) {
  const double p = at_end ? aligned_line.parameters.back() : aligned_line.parameters.front();
  const Vec3 d1 = (at_end ? -1 : 1) * aligned_line.fitted.evaluate(p, 1),
             d2 = aligned_line.fitted.evaluate(p, 2);
  const Vec3 direction = d1.normalized();
  const Vec3 chord = aligned_line.fitted.evaluate(aligned_line.parameters.back()) -
                     aligned_line.fitted.evaluate(aligned_line.parameters.front());
  return {direction, (d2 - d2.dot(direction) * direction) / d1.squaredNorm(), chord.norm()};
}

// All lines of a side's region that begin at an end of it, except the side itself.
std::vector<CrossingLine> crossing_lines(const ModelLayout& layout, const JoinSide& side,
                                         bool at_end) {
  const auto& edge_aligned = layout.region(side.region).edge_aligned();
  const EdgeAlignedLine& own = edge_aligned[static_cast<size_t>(side.line)];
  const int v = at_end ? own.vertices.back() : own.vertices.front();
  std::vector<CrossingLine> all;
  for (const EdgeAlignedLine& aligned_line : edge_aligned) {
    if (&aligned_line == &own || aligned_line.fitted.closed()) continue;
    if (aligned_line.vertices.front() == v) all.push_back(crossing_line(aligned_line, false));
    if (aligned_line.vertices.back() == v) all.push_back(crossing_line(aligned_line, true));
  }
  return all;
}

}  // namespace

bool is_curvature_continuous(const ModelLayout& layout, const JoinPlan& plan) {
  if (plan.rejected()) return false;
  const JoinLine& line = plan.join_line;
  if (line.curvature) return *line.curvature;
  if (line.neighbour()) return false;
  if (line.sides[0].embedded || line.sides[1].embedded) return true;
  constexpr double kStraightCosine = -0.9, kMinCrossingSine = 0.3;  // cosine; sine
  constexpr double kMinTurningAngle = 0.2;                          // radians
  double jump = 0, most = 0;
  for (const bool at_end : {false, true}) {
    const auto& aligned_line =
        layout.region(line.sides[0].region).edge_aligned()[line.sides[0].line];
    const Vec3 along = crossing_line(aligned_line, at_end).direction;
    for (const CrossingLine& a : crossing_lines(layout, line.sides[0], at_end))
      for (const CrossingLine& b : crossing_lines(layout, line.sides[1], at_end)) {
        const Vec3 normal = along.cross(a.direction);
        if (a.direction.dot(b.direction) > kStraightCosine || normal.norm() < kMinCrossingSine)
          continue;
        const double first = a.curvature.dot(normal.normalized()),
                     second = b.curvature.dot(normal.normalized());
        most += std::max(std::abs(first), std::abs(second));
        // Nearly equal total turning over the shorter line counts as no jump.
        if (std::abs(first - second) * std::min(a.length, b.length) < kMinTurningAngle) continue;
        jump += std::abs(first - second);
      }
  }
  return jump <= 0.5 * most;
}

std::vector<JoinPoint> curvature_join_points(const ModelLayout& layout) {
  std::vector<const RegionLayout*> regions;
  for (int r = 0; r < layout.region_count(); ++r) regions.push_back(&layout.region(r));
  JoinEdgeFactory edges(regions);
  const SegmentRule gauss = gauss_legendre(2);
  std::vector<JoinPoint> points;
  for (const JoinPlan& plan : layout.join_plans()) {
    const bool goes_on = is_curvature_continuous(layout, plan);
    if (plan.rejected() || (!goes_on && plan.at.empty())) continue;
    const JoinLine& line = plan.join_line;
    const JoinEdge sides[2] = {edges(line.sides[0]), edges(line.sides[1])};
    const std::vector<double> at = sides[sides[0].embedded() ? 1 : 0].stations();
    for (size_t k = 0; k + 1 < at.size(); ++k)
      for (long g = 0; g < gauss.weights.size(); ++g) {
        const double f = lerp(at[k], at[k + 1], gauss.s[g]);
        JoinPoint& point = points.emplace_back();
        point.curvature = goes_on;
        point.tangent = !plan.at.empty();
        for (size_t s = 0; s < 2; ++s) {
          point.at[s] = layout.to_model_location(line.sides[s].region, sides[s].where(f));
          point.direction[s] = sides[s].along_uv(f);
        }
        if (const NeighbourEdge* neighbour = line.neighbour())
          point.given = {neighbour->into(f, sides[1].slope(f)), neighbour->curvature(f)};
        point.weight = gauss.weights[g] * (at[k + 1] - at[k]) * sides[0].span();
      }
  }
  return points;
}

namespace {

bool continues_neighbours(const ModelLayout& layout) {
  return std::any_of(layout.join_plans().begin(), layout.join_plans().end(),
                     [](const JoinPlan& plan) {
                       return !plan.rejected() && plan.join_line.neighbour();
                     });
}

// Edge-aligned outline and hole lines that are no smooth joins, as vertices of the model.
std::vector<std::vector<int>> outline_sides(const ModelLayout& layout) {
  std::vector<std::vector<int>> sides;
  for (const ModelLine& line : layout.lines()) {
    if (layout.join_plan(line.name)) continue;
    for (const LineSide& side : line.sides) {
      if (side.embedded) continue;
      const EdgeAlignedLine& aligned_line =
          layout.region(side.region).edge_aligned()[static_cast<size_t>(side.index)];
      if (aligned_line.line.role == CharacterLine::Role::Inner) continue;
      std::vector<int>& vertices = sides.emplace_back();
      for (const int v : aligned_line.vertices)
        vertices.push_back(layout.dof_offsets(side.region).vertices / 3 + v);
    }
  }
  return sides;
}

}  // namespace

MinimumVariationSurface fair_shape(const ModelLayout& layout, const Points& start,
                                   const ConstraintSet& constraints,
                                   MinimumVariationOptions options, const Progress& progress) {
  bool corners = false, inner_lines = false, rings = false;
  for (int r = 0; r < layout.region_count(); ++r) {
    const RegionLayout& region = layout.region(r);
    corners = corners || !region.corners().empty();
    rings = rings || is_annulus(region);
    // The boundary circles of a can's lids are embedded outlines, and do not matter for its side.
    for (const EmbeddedLine& line : region.embedded())
      inner_lines = inner_lines || line.line.role != CharacterLine::Role::Outline;
  }
  if (corners)
    options.sides = outline_sides(layout);
  else if (!inner_lines && !continues_neighbours(layout))
    options.gauss = 100;
  options.joins = curvature_join_points(layout);
  // Near the origin, to reduce round-off of coordinates.
  const VecX ones = layout.position_dofs();
  const Points origin = ones * layout.origin().transpose();
  if (rings && options.starts.empty()) options.starts = {start, loft_shape(layout, {})};
  for (Points& dofs : options.starts) dofs -= origin;
  MinimumVariationSurface result = minimize_curvature_variation(
      layout.surface(start - origin), constraints.translated(ones, layout.origin()), options,
      progress);
  result.dofs += origin;
  return result;
}

Points interpolate_onto(const ModelLayout& layout, const Points& dofs, const ModelLayout& finer) {
  std::vector<Points> each;
  for (int r = 0; r < layout.region_count(); ++r)
    each.push_back(
        finer.region(r).mesh() == layout.region(r).mesh()
            ? layout.region_dofs(r, dofs)
            : interpolate_onto(layout.skinned(r, dofs).surface, *finer.region(r).mesh()).dofs);
  return finer.all_dofs(each);
}

double bending_energy(const ModelLayout& layout, const Points& dofs, SurfaceStiffness material) {
  material.alpha.setZero();
  const SurfaceAssembler assembler(*layout.mesh(), layout.element(), layout.trim());
  SparseMatrix K = assembler.pattern();
  auto materials = layout.scale_to_regions({material});
  materials.resize(static_cast<size_t>(layout.mesh()->triangle_count()), materials[0]);
  assembler.stiffness(materials, K);
  const Points q = dofs - layout.position_dofs() * layout.origin().transpose();
  const double energy = 0.5 * q.cwiseProduct(Points(K.selfadjointView<Eigen::Lower>() * q)).sum();
  return std::max(0.0, energy) / (layout.size() * layout.size());
}

}  // namespace batten
