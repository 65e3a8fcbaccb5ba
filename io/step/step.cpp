// SPDX-License-Identifier: MPL-2.0
#include "batten/io/step/step.h"

#include <BRepCheck_Analyzer.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Standard_Failure.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <numeric>
#include <set>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/io/cad/cad_writer.h"
#include "batten/io/cad/continuity_report.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/input_file.h"
#include "batten/io/step/exact_faces.h"
#include "batten/io/step/face_maker.h"
#include "batten/io/step/face_measure.h"
#include "batten/io/step/step_check.h"
#include "batten/io/step/step_plan.h"
#include "batten/io/step/step_report.h"

namespace batten {
namespace {

// Fits CAD faces to model faces, and measures them on the STEP file that is read back.

/// One FaceMaker per model face; see fitted_faces().
using FittedFaces = std::vector<std::unique_ptr<FaceMaker>>;

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
           const Vec2 at = other->boundary.domain_point(uv);
           return region->surface.jet(other->locator.locate(at)).normal();
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

/// Throws InputError if the tolerance or a limit on poles is out of range.
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

/// Fits a face to every model face without an analytic face, on all threads. `options`, `analytic`
/// and the model faces must outlive the result. Model faces whose analytic face is invalid by
/// itself, or misses a smooth join, are added to `failed`; in that case nothing is fitted.
FittedFaces fitted_faces(const std::vector<const SkinnedRegion*>& regions, const StepPlan& plan,
                         const StepFaceOptions& options, const AnalyticFaces& analytic = {},
                         std::vector<const SkinnedRegion*>* failed = nullptr) {
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
  for (const auto& maker : made)
    if (!maker->analytic() && !options.neighbours.empty())
      follow_neighbours(
          {&maker->boundary(), [m = maker.get()](const Vec2& uv) { return m->normal(uv); }},
          options.neighbours);
  parallel_for(isize(made), [&](int k) {
    if (made[k]->analytic()) return;
    made[k]->fit();
    if (made.size() > 1) fit_to_tolerance(*made[k], options.tolerance);
  });
  if (plan.joined) fit_joins_to_tolerance(made, plan, options);
  return made;
}

/// Writes a file and measures it. Repeats this with finer fits of the faces that miss the tolerance
/// or an angle, as long as that helps, six times at most. `written` makes and writes all faces, and
/// returns the report with the patches in the order of `made`.
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

/// Measures the `faces` of a file read back against the model faces of `made`, on all threads, and
/// adds the patches to the report. `rest` runs in parallel and measures the rest of the report.
void measure_patches(StepReport& report, const std::vector<TopoDS_Face>& faces,
                     const FittedFaces& made, const StepPlan& plan, const StepFaceOptions& options,
                     const std::function<void()>& rest = {}) {
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

/// Reads the file back and measures each face, in the order of `made`, against its model face. Sets
/// everything in StepReport except `file` and `warnings`. `beside` runs on another thread while the
/// file is read. Throws UnwritableRegions if the file has a different number of faces.
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

// Files of exact faces.

constexpr const char* kFace =
    "expected step_form = \"face\", which writes one fitted STEP face per face";

bool is_cut(const SkinnedRegion& region) { return region.surface.trim() != nullptr; }

/// Diagonal of the bounding box of all mesh vertices. For trimmed model faces, whose meshes extend
/// beyond the boundary, that of their curves.
double size_of(const std::vector<const SkinnedRegion*>& regions) {
  Box3 box;
  for (const SkinnedRegion* region : regions) {
    const Surface& surface = region->surface;
    if (is_cut(*region)) {
      for (const EmbeddedLine& line : region->embedded)
        for (int i = 0; i < line.fitted.node_count(); ++i) box.extend(line.fitted.position(i));
      continue;
    }
    for (int v = 0; v < surface.mesh().vertex_count(); ++v)
      box.extend(Vec3(surface.dofs().row(surface.dof_map().vertex(v))));
  }
  return box.diagonal().norm();
}

/// Throws InputError for model faces that have no exact STEP form.
void check_exact(const std::vector<const SkinnedRegion*>& regions, bool z12_as_hct) {
  std::map<std::string, std::string> edge_aligned;  // curve name → a model face aligned to it
  std::string cut;
  for (const SkinnedRegion* region : regions) {
    if (is_cut(*region)) {
      cut += (cut.empty() ? "'" : ", '") + region->name + "'";
      continue;
    }
    if (region->surface.kind() != TriangleElement::HCT && !z12_as_hct)
      throw InputError(
          "STEP: found a surface of Z12 elements, which are rational and have no exact STEP form; "
          "expected HCT elements (element = \"hct\")");
    for (const EdgeAlignedLine& aligned_line : region->edge_aligned)
      edge_aligned.emplace(aligned_line.line.name, region->name);
  }
  if (!regions.empty() && std::all_of(regions.begin(), regions.end(),
                                      [](const SkinnedRegion* r) { return is_cut(*r); }))
    throw InputError("STEP: found only faces that are trimmed by embedded curves, " + cut +
                     ", whose trimmed triangles have no exact STEP form; " + kFace);
  for (const SkinnedRegion* region : regions) {
    if (is_cut(*region)) continue;
    for (const EmbeddedLine& embedded : region->embedded)
      if (const auto aligned_line = edge_aligned.find(embedded.line.name);
          aligned_line != edge_aligned.end() && !embedded.line.name.empty())
        throw InputError("STEP: found the curve '" + embedded.line.name + "' of face '" +
                         aligned_line->second + "' embedded in face '" + region->name +
                         "': element edges do not follow it there, so that the two faces share no "
                         "edges; " +
                         kFace);
  }
}

/// A file of exact faces, and fitted ones of trimmed model faces, which share vertices and edges.
class ModelFile {
 public:
  /// Plans the file and fits faces. Keeps a reference to `options`.
  ModelFile(const std::vector<const SkinnedRegion*>& regions, double model_unit_in_metres,
            const StepOptions& options)
      : options_(options),
        plan_(step_plan(regions, model_unit_in_metres)),
        size_(size_of(regions)),
        coincidence_(reader_coincidence(model_unit_in_metres)) {
    for (const SkinnedRegion* region : plan_.regions)
      if (is_cut(*region)) cut_.push_back(region);
    cut_at_vertices(plan_);
    if (cut_.empty()) return;
    face_options_.tolerance = options.tolerance > 0 ? options.tolerance : 1e-4 * size_;
    face_options_.analytic = false;
    if (plan_.joined) cut_lines(plan_, cut_);
    fitted_ = fitted_faces(cut_, plan_, face_options_);
  }

  const StepPlan& plan() const { return plan_; }

  /// Writes and measures the file. The report does not contain the plan's warnings.
  StepReport write(const std::filesystem::path& path, OccSettings& occ) const {
    return refined(fitted_, face_options_, [&] {
      const bool valid = save(path, occ);
      std::vector<TopoDS_Face> faces;
      StepReport report = measured_file(path, plan_.regions, faces);
      if (faces.size() != fitted_.size())
        throw Error(path.string() + ": OpenCASCADE reads other faces than were written");
      if (!faces.empty()) measure_patches(report, faces, fitted_, plan_, face_options_);
      report.valid = report.valid && valid;
      return report;
    });
  }

 private:
  /// Writes the file. Returns false if OpenCASCADE finds an error in fitted faces. This must be
  /// checked here, because readers repair silently.
  bool save(const std::filesystem::path& path, OccSettings& occ) const {
    SharedEdges shared(plan_);
    SharedEdges* common = plan_.joined && !cut_.empty() ? &shared : nullptr;
    RegionFaces faces = exact_faces(plan_, size_, &shared);
    double tolerance = 1e-9 * size_;
    auto maker = fitted_.begin();
    for (size_t r = 0; r < faces.size(); ++r) {
      if (!is_cut(*plan_.regions[r])) continue;
      faces[r].push_back((*maker)->make(coincidence_, common));
      tolerance = std::max(tolerance, (*maker++)->tolerance());
    }
    const TopoDS_Shape shape = assembled(plan_, [&](int region, TopoDS_Shell& shell) {
      for (const TopoDS_Face& face : faces[region]) BRep_Builder().Add(shell, face);
    });
    if (!cut_.empty()) reparametrize_for_gap_check(shape, coincidence_);
    CadPart part{options_.file.name + " 1", shape, {}, {}, {}, shared.along_lines()};
    for (size_t r = 0; r < faces.size(); ++r)
      for (const TopoDS_Face& face : faces[r])
        part.faces.push_back(face_of_region(face, plan_.regions[r]->name, r, faces.size()));
    write_surfaces(path, part, options_.file, tolerance, occ);
    return cut_.empty() || BRepCheck_Analyzer(shape).IsValid();
  }

  const StepOptions& options_;
  StepPlan plan_;
  double size_, coincidence_;
  std::vector<const SkinnedRegion*> cut_;
  StepFaceOptions face_options_;
  FittedFaces fitted_;  // of `cut_`
};

}  // namespace

std::string step_size_warning(const std::vector<const SkinnedRegion*>& regions) {
  constexpr double bytes_per_face = 4750;
  constexpr int max_triangles = 10'000;
  int triangles = 0;
  for (const SkinnedRegion* region : regions)
    if (!is_cut(*region)) triangles += region->surface.mesh().triangle_count();
  if (triangles <= max_triangles) return "";
  return "the exact STEP file has " + std::to_string(3 * triangles) + " faces and about " +
         std::to_string(std::lround(3 * triangles * bytes_per_face / 1e6)) +
         " MB; larger elements reduce its size";
}

StepReport write_step(const std::filesystem::path& path,
                      const std::vector<const SkinnedRegion*>& regions, double model_unit_in_metres,
                      const StepOptions& options) {
  check_exact(regions, options.z12_as_hct);
  if (!(options.tolerance >= 0) || !std::isfinite(options.tolerance))
    throw InputError(path.string() + ": found a tolerance of " + format_number(options.tolerance) +
                     "; expected a length above 0, or 0");
  const std::string unit = cad_unit(model_unit_in_metres);
  AtomicFile file(path);
  const ModelFile model(regions, model_unit_in_metres, options);
  OccSettings occ;
  occ.set_unit(unit);
  StepReport report;
  try {
    report = model.write(file.temporary(), occ);
  } catch (const Standard_Failure& failure) {
    throw Error(path.string() +
                ": OpenCASCADE failed to write or read it: " + failure.GetMessageString());
  }
  file.commit();
  report.file = path;
  report.warnings = model.plan().warnings;
  if (const std::string warning = step_size_warning(regions); !warning.empty())
    report.warnings.push_back(warning);
  return report;
}

StepReport check_step(const std::filesystem::path& file, double model_unit_in_metres,
                      const std::vector<const SkinnedRegion*>& regions) {
  OccSettings occ;
  occ.set_unit(cad_unit(model_unit_in_metres));
  try {
    std::vector<TopoDS_Face> fitted;
    StepReport report = measured_file(file, regions, fitted);
    auto face = fitted.begin();
    for (const SkinnedRegion* region : regions) {
      if (!region->surface.trim() || face == fitted.end()) continue;
      StepPatch patch;
      patch.region = region->name;
      patch.deviation = nearest_deviation(*face, {region});
      report.patches.push_back(patch);
      ++face;
    }
    return report;
  } catch (const Standard_Failure& failure) {
    throw InputError(file.string() +
                     ": OpenCASCADE failed to read it: " + failure.GetMessageString());
  }
}

namespace {

/// Writes the current faces, and returns their shape.
TopoDS_Shape save(const std::filesystem::path& path, const StepPlan& plan, const FittedFaces& made,
                  double coincidence, const StepFaceOptions& options, OccSettings& occ) {
  SharedEdges shared(plan);
  const bool common = plan.joined || std::any_of(made.begin(), made.end(), [](const auto& maker) {
                        return maker->analytic();
                      });
  CadPart part;
  part.name = options.file.name;
  part.shape = assembled(plan, [&](int region, TopoDS_Shell& shell) {
    const TopoDS_Face face = made[region]->make(coincidence, common ? &shared : nullptr);
    BRep_Builder().Add(shell, face);
    part.faces.push_back(
        face_of_region(face, plan.regions[region]->name, region, plan.regions.size()));
    const auto& edges = made[region]->along_lines();
    part.edges.insert(part.edges.end(), edges.begin(), edges.end());
  });
  const TopoDS_Shape& shape = part.shape;
  reparametrize_for_gap_check(shape, coincidence);
  // Some readers resolve only 1e-7 of the unit. If the file declared a smaller tolerance, they
  // would recompute every boundary. In a tiny model, 1e-7 would be too large.
  constexpr double seen = 1e-7, little = 1e-5;
  double tolerance = coincidence, least = seen;
  for (const auto& maker : made) {
    tolerance = std::max(tolerance, maker->tolerance());
    least = std::min(least, little * maker->size());
  }
  tolerance = std::max(tolerance, least);
  write_surfaces(path, part, options.file, tolerance, occ);
  return shape;
}

/// True if all boundary curves have names.
bool lines_have_names(const StepPlan& plan) {
  for (const SkinnedRegion* region : plan.regions)
    for (const auto& loop : region->boundary)
      for (const BoundarySegment& piece : loop) {
        const auto i = static_cast<size_t>(piece.index);
        if ((piece.kind == BoundarySegment::Kind::EdgeAligned ? region->edge_aligned.at(i).line.name
                                                              : region->embedded.at(i).line.name)
                .empty())
          return false;
      }
  return true;
}

/// True if the vertices and centroids of a model face are within a distance of a primitive.
bool is_within(const SkinnedRegion& region, const FittedPrimitive& primitive, double distance) {
  const Surface& surface = region.surface;
  for (int t = 0; t < surface.mesh().triangle_count(); ++t) {
    if (surface.trim() && surface.trim()->side(t) != Trim::Side::Inside) continue;
    for (const Vec3& L : {Vec3(Vec3::Constant(1.0 / 3)), Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()),
                          Vec3(Vec3::UnitZ())})
      if (!(std::abs(primitive.distance(surface.position({t, L}))) <= distance)) return false;
  }
  return true;
}

/// The model faces that are planes, cylinders … within the tolerance.
MeasuredShapes shapes_within(const StepPlan& plan, const StepFaceOptions& options) {
  MeasuredShapes shapes;
  if (!options.analytic || !lines_have_names(plan)) return shapes;
  std::vector<FittedPrimitive> found(plan.regions.size());
  parallel_for(isize(found), [&](int k) {
    const SkinnedRegion& region = *plan.regions[k];
    // The file is measured between the samples used here.
    constexpr double most = 0.95;
    const double size = kInfinity;
    const double tolerance = std::min(most * options.tolerance, primitive_tolerance(region, size));
    constexpr double alike = 0.01;
    const auto continued = options.continued_primitives.find(region.name);
    if (continued != options.continued_primitives.end() &&
        is_within(region, continued->second,
                  std::min(most * options.tolerance, alike * region.size))) {
      found[k] = continued->second;
      return;
    }
    const auto known = options.primitives.find(region.name);
    found[k] = known != options.primitives.end() && is_within(region, known->second, tolerance)
                   ? known->second
                   : fit_primitive(region, tolerance);
  });
  for (size_t k = 0; k < found.size(); ++k)
    if (found[k].kind != FittedPrimitive::Kind::Free && !plan.regions[k]->boundary.empty())
      shapes.emplace(plan.regions[k], found[k]);
  return shapes;
}

/// Plans the analytic faces and cuts all curves. Model faces that cannot be analytic faces are
/// removed from `shapes`.
AnalyticFaces planned_faces(StepPlan& plan, MeasuredShapes& shapes) {
  const StepPlan before = plan;
  while (true) {
    plan = before;
    if (!plan.joined && shapes.empty()) return {};
    std::set<const SkinnedRegion*> whole;
    for (const auto& [region, shape] : shapes) whole.insert(region);
    cut_lines(plan, plan.regions, whole);
    const size_t count = shapes.size();
    AnalyticFaces faces = analytic_faces(plan, shapes);
    if (shapes.size() == count) return faces;
  }
}

/// The model faces whose analytic faces cause a check of the file to fail.
std::vector<const SkinnedRegion*> failed_faces(const FittedFaces& made, const StepReport& report) {
  std::vector<const SkinnedRegion*> failed;
  for (size_t k = 0; k < made.size(); ++k) {
    const StepPatch& patch = report.patches[k];
    if (made[k]->analytic() && (!report.valid || !patch.reached ||
                                !std::isfinite(patch.edge_deviation) || patch.join_deg > 0))
      failed.push_back(&made[k]->region());
  }
  return failed;
}

}  // namespace

StepReport write_step_faces(const std::filesystem::path& path,
                            const std::vector<const SkinnedRegion*>& regions,
                            double model_unit_in_metres, const StepFaceOptions& options) {
  check_options(path, options);
  const StepPlan planned = step_plan(regions, model_unit_in_metres);
  const std::string unit = cad_unit(model_unit_in_metres);
  AtomicFile file(path);
  OccSettings occ;
  occ.set_unit(unit);
  try {
    // Model faces whose analytic faces fail become B-splines, and the file is written again.
    MeasuredShapes shapes = shapes_within(planned, options);
    StepReport report;
    while (true) {
      StepPlan plan = planned;
      const AnalyticFaces analytic = planned_faces(plan, shapes);
      std::vector<const SkinnedRegion*> failed;
      const FittedFaces made = fitted_faces(plan.regions, plan, options, analytic, &failed);
      if (failed.empty()) {
        try {
          report = refined(made, options, [&] {
            const TopoDS_Shape shape = save(file.temporary(), plan, made,
                                            reader_coincidence(model_unit_in_metres), options, occ);
            // Check the shape itself, because the reader silently repairs errors.
            bool valid = false;
            StepReport measured = measured_faces(file.temporary(), made, plan, options, [&] {
              valid = BRepCheck_Analyzer(shape).IsValid();
            });
            measured.valid = measured.valid && valid;
            return measured;
          });
          failed = failed_faces(made, report);
        } catch (const UnwritableRegions&) {
          if (analytic.empty()) throw;
          for (const auto& [region, face] : analytic) failed.push_back(region);
        }
      }
      if (failed.empty()) break;
      for (const SkinnedRegion* region : failed) shapes.erase(region);
    }
    file.commit();
    report.file = path;
    report.warnings = planned.warnings;
    return report;
  } catch (const Standard_Failure& failure) {
    throw Error(path.string() +
                ": OpenCASCADE failed to write or read it: " + failure.GetMessageString());
  }
}

}  // namespace batten
