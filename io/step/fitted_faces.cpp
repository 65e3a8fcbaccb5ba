#include "batten/io/step/fitted_faces.h"

#include <BRepCheck_Analyzer.hxx>
#include <BRep_Tool.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Standard_Failure.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/cad/shape_continuity.h"
#include "batten/io/files/input_file.h"
#include "batten/io/step/face_measure.h"
#include "batten/io/step/step_check.h"
#include "batten/io/step/step_report.h"

namespace batten {
namespace {

/// Refines the fit until it meets the tolerance between its sample points, too. This avoids writing
/// files of many model faces twice.
void fit_to_tolerance(FaceMaker& made, double tolerance) {
  constexpr int most_fits = 5;
  for (int i = 0; i < most_fits; ++i) {
    std::vector<Vec2> points = points_of_region(made);
    KnotCells cells(made.patch().u.knots(), made.patch().v.knots());
    for (const FaceLoop& loop : made.boundary().loops)
      for (const FaceBoundarySegment& segment : loop) {
        const int n = 8 * (segment.curve.segment_count() + segment.pcurve.segment_count() +
                           made.poles_u() + made.poles_v());
        const double start = segment.curve.start(), end = segment.curve.end();
        Vec2 before = segment.first();
        for (int k = 0; k < n; ++k) {
          points.push_back(segment.uv(start + (end - start) * double(k) / n));
          cells.pass(before, points.back());
          before = points.back();
        }
        cells.pass(before, segment.last());
      }
    const auto contains = [&](const Vec2& p) { return made.boundary().contains(p); };
    for (const Vec2& uv : cells.points(contains, contains)) points.push_back(uv);
    // The file will be measured at other points.
    constexpr double margin = 1.02;
    const double deviation =
        margin * largest(points.size(), [&](size_t k) {
          return (made.fitted_position(points[k]) - made.position(points[k])).norm();
        });
    if (deviation <= tolerance || !made.refine(deviation, 0)) return;
  }
}

/// Refines the faces at joins whose angle is missed between the sample points.
void fit_joins_to_tolerance(const FittedFaces& made, const StepPlan& plan,
                            const StepFaceOptions& options) {
  constexpr int max_rounds = 3;
  for (int round = 0; round < max_rounds; ++round) {
    std::vector<FaceNormals> normals(made.size());
    parallel_for(isize(made), [&](int k) { normals[k] = normals_of_fit(*made[k], plan); });
    const std::vector<double> angles_to_correct = correctable_angles(normals, options.join_deg);
    std::vector<char> again(made.size());
    parallel_for(isize(made), [&](int k) {
      again[k] = angles_to_correct[k] > 0 && made[k]->refine(0, angles_to_correct[k]);
      if (again[k]) fit_to_tolerance(*made[k], options.tolerance);
    });
    if (std::find(again.begin(), again.end(), 1) == again.end()) return;
  }
}

/// An adjacent model face that has no fitted face.
struct NeighbourSide {
  FaceBoundary boundary;
  TriangleLocator locator;
  NeighbourSide(const SkinnedRegion& region, const StepPlan& plan)
      : boundary(region, &plan), locator(region.surface.mesh()) {}
};

void find_joins(const FittedFaces& made, const StepPlan& plan, double tolerance) {
  std::vector<TangentSide> sides;
  std::vector<std::unique_ptr<NeighbourSide>> others;
  for (const SkinnedRegion* region : plan.regions) {
    const auto maker = std::find_if(made.begin(), made.end(),
                                    [&](const auto& m) { return &m->region() == region; });
    if (maker != made.end()) {
      sides.push_back(
          {&(*maker)->boundary(), [m = maker->get()](const Vec2& uv) { return m->normal(uv); }});
      continue;
    }
    others.push_back(std::make_unique<NeighbourSide>(*region, plan));
    sides.push_back(
        {&others.back()->boundary, [other = others.back().get(), region](const Vec2& uv) {
           return region->surface.jet(other->locator.locate(uv)).normal();
         }});
  }
  find_tangent_joins(plan, sides, tolerance);
}

/// True if a model face's analytic face is valid by itself and covers the part of the surface that
/// the model face covers.
bool is_valid_alone(FaceMaker& made) {
  try {
    const TopoDS_Face face = made.make(1e-9 * made.size());
    return BRepCheck_Analyzer(face).IsValid() && has_area_of_region(face, made);
  } catch (const Standard_Failure&) {
    return false;
  } catch (const Error&) {
    return false;
  }
}

/// The model faces whose analytic faces miss a smooth join whatever the other face is.
std::vector<const SkinnedRegion*> analytic_off_joins(const FittedFaces& made, const StepPlan& plan,
                                                     double join_deg) {
  std::vector<const SkinnedRegion*> off;
  const auto is_analytic = [](const auto& maker) { return maker->analytic(); };
  if (std::none_of(made.begin(), made.end(), is_analytic)) return off;
  std::vector<FaceNormals> normals(made.size());
  parallel_for(isize(made), [&](int k) { normals[k] = normals_before_fit(*made[k], plan); });
  const std::vector<double> angles = angles_from_target(normals, join_deg);
  for (size_t k = 0; k < made.size(); ++k)
    if (made[k]->analytic() && angles[k] > join_deg) off.push_back(&made[k]->region());
  return off;
}

/// True if a face of the file has the surface that was fitted to a model face.
bool lies_on_region(const TopoDS_Face& face, const FaceMaker& made) {
  if (made.analytic())
    return shape_of(BRep_Tool::Surface(face)).kind == made.analytic()->surface.shape().kind;
  const auto surface = Handle(Geom_BSplineSurface)::DownCast(BRep_Tool::Surface(face));
  if (surface.IsNull() || surface->NbUPoles() != made.poles_u() ||
      surface->NbVPoles() != made.poles_v())
    return false;
  const SplineAxis &u = made.patch().u, &v = made.patch().v;
  const Vec2 middle(u.knots()[u.knots().size() / 2], v.knots()[v.knots().size() / 2]);
  constexpr double hair = 1e-6;
  return (from_occ(surface->Value(middle.x(), middle.y())) - made.fitted_position(middle)).norm() <=
         hair * made.size();
}

/// Throws UnwritableRegions, with the names of the model faces whose face was read back as several
/// faces or not at all.
void require_as_written(const std::vector<TopoDS_Face>& faces, const FittedFaces& made) {
  if (faces.size() == made.size()) return;
  std::vector<const SkinnedRegion*> other;
  std::string names;
  size_t next = 0;
  for (const auto& maker : made) {
    const size_t first = next;
    while (next < faces.size() && lies_on_region(faces[next], *maker)) ++next;
    if (next - first == 1) continue;
    other.push_back(&maker->region());
    names += (names.empty() ? " ('" : ", '") + maker->region().name + "'";
  }
  // Faces after an unrecognised one cannot be assigned to model faces.
  if (next < faces.size()) other.clear();
  throw UnwritableRegions("OpenCASCADE reads " + std::to_string(faces.size()) + " faces where " +
                              std::to_string(made.size()) + " were written" +
                              (other.empty() ? "" : names + ")"),
                          other);
}

}  // namespace

void check_options(const std::filesystem::path& path, const StepFaceOptions& options) {
  if (!(options.tolerance > 0) || !std::isfinite(options.tolerance))
    throw InputError(path.string() + ": found a tolerance of " + format_number(options.tolerance) +
                     "; expected a length above 0");
  if (!(options.join_deg > 0))
    throw InputError(path.string() + ": found an angle between faces of " +
                     format_number(options.join_deg) + " degrees; expected one above 0");
  if (options.max_poles < 16 || options.max_poles_total < 256)
    throw InputError(path.string() + ": found a limit of " + std::to_string(options.max_poles) +
                     " poles per direction and " + std::to_string(options.max_poles_total) +
                     " in total; expected 16 and 256 or more");
}

FittedFaces fitted_faces(const std::vector<const SkinnedRegion*>& regions, const StepPlan& plan,
                         const StepFaceOptions& options, const AnalyticFaces& analytic,
                         std::vector<const SkinnedRegion*>* failed) {
  FittedFaces made(regions.size());
  std::vector<char> bad(regions.size(), 0);
  const bool common = plan.joined || !analytic.empty();
  parallel_for(isize(made), [&](int k) {
    const auto face = analytic.find(regions[k]);
    made[k] = std::make_unique<FaceMaker>(*regions[k], options, common ? &plan : nullptr,
                                          face == analytic.end() ? nullptr : &face->second);
    bad[k] = made[k]->analytic() && !is_valid_alone(*made[k]);
  });
  for (size_t k = 0; k < bad.size(); ++k)
    if (bad[k] && failed) failed->push_back(regions[k]);
  if (failed && !failed->empty()) return made;
  if (plan.joined) {
    find_joins(made, plan, options.tolerance);
    if (failed) *failed = analytic_off_joins(made, plan, options.join_deg);
    if (failed && !failed->empty()) return made;
  }
  parallel_for(isize(made), [&](int k) {
    if (made[k]->analytic()) return;
    made[k]->fit();
    if (made.size() > 1) fit_to_tolerance(*made[k], options.tolerance);
  });
  if (plan.joined) fit_joins_to_tolerance(made, plan, options);
  return made;
}

StepReport refined(const FittedFaces& made, const StepFaceOptions& options,
                   const std::function<StepReport()>& written) {
  StepReport report;
  constexpr int max_rounds = 6, most_for_angles = 2;
  constexpr double far_off = 3;
  for (int round = 0; round < max_rounds; ++round) {
    report = written();
    bool again = false;
    // Finer knots reduce errors between the samples, but not an angle that the surface itself has.
    // If a join misses by far, the file is not made three times as large for the others.
    const bool angles =
        round < most_for_angles && report.max_join_deg <= far_off * options.join_deg;
    for (size_t k = 0; k < made.size(); ++k)
      if (const StepPatch& patch = report.patches[k]; !patch.reached || patch.join_deg > 0)
        again = made[k]->refine(patch.deviation, angles ? patch.join_deg : 0) || again;
    if (!again) break;
  }
  return report;
}

void measure_patches(StepReport& report, const std::vector<TopoDS_Face>& faces,
                     const FittedFaces& made, const StepPlan& plan, const StepFaceOptions& options,
                     const std::function<void()>& rest) {
  std::vector<StepPatch> patches(faces.size());
  std::vector<FaceNormals> normals(faces.size());
  const int before = rest ? 1 : 0;
  parallel_for(before + isize(faces), [&](int part) {
    if (part < before) return rest();
    const auto k = static_cast<size_t>(part - before);
    StepPatch& patch = patches[k];
    patch.region = made[k]->region().name;
    patch.poles_u = made[k]->poles_u();
    patch.poles_v = made[k]->poles_v();
    if (made[k]->analytic())
      patch.surface = primitive_name(made[k]->analytic()->surface.shape().kind);
    normals[k] = measure_face(faces[k], *made[k], plan, patch);
    patch.reached = patch.deviation <= options.tolerance;
  });
  report.tolerance = options.tolerance;
  report.joins = joins_between(normals, options.join_deg);
  for (const StepJoin& join : report.joins) {
    report.reached = report.reached && join.reached;
    report.max_join_deg = std::max(report.max_join_deg, join.angle_deg);
  }
  const std::vector<double> angles_to_correct = correctable_angles(normals, options.join_deg);
  for (size_t k = 0; k < patches.size(); ++k) patches[k].join_deg = angles_to_correct[k];
  for (const StepPatch& patch : patches) {
    report.reached = report.reached && patch.reached;
    report.max_gap = std::max(report.max_gap, patch.edge_gap);
    report.line_gap = std::max(report.line_gap, patch.line_gap);
    report.edge_deviation = std::max(report.edge_deviation, patch.edge_deviation);
    report.patches.push_back(patch);
  }
}

StepReport measured_faces(const std::filesystem::path& path, const FittedFaces& made,
                          const StepPlan& plan, const StepFaceOptions& options,
                          const std::function<void()>& beside) {
  TopoDS_Shape shape;
  parallel_for(2, [&](int part) {
    if (part == 1) return beside();
    shape = read_step(path);
  });
  std::vector<TopoDS_Face> faces;
  for (TopExp_Explorer it(shape, TopAbs_FACE); it.More(); it.Next())
    faces.push_back(TopoDS::Face(it.Current()));
  require_as_written(faces, made);
  std::vector<int> region_of_face(faces.size());
  std::iota(region_of_face.begin(), region_of_face.end(), 0);
  StepReport report;
  measure_patches(report, faces, made, plan, options,
                  [&] { report = measure_shape(shape, region_of_face); });
  report.bytes = input_file_size(path);
  report.continuity = shape_continuity(shape, report.size);
  report.area = report.continuity->area;
  report.max_deviation = 0;
  for (const StepPatch& patch : report.patches)
    report.max_deviation = std::max(*report.max_deviation, patch.deviation);
  return report;
}

}  // namespace batten
