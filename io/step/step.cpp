#include "batten/io/step/step.h"

#include <BRepCheck_Analyzer.hxx>
#include <BRep_Builder.hxx>
#include <Eigen/Geometry>
#include <Standard_Failure.hxx>
#include <algorithm>
#include <cmath>
#include <set>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/core/geometry.h"
#include "batten/core/parallel.h"
#include "batten/io/cad/cad_writer.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/step/exact_faces.h"
#include "batten/io/step/fitted_faces.h"
#include "batten/io/step/step_check.h"
#include "batten/io/step/step_plan.h"
#include "batten/io/step/step_report.h"

namespace batten {
namespace {

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
    found[k] = fit_primitive(region,
                             std::min(most * options.tolerance, primitive_tolerance(region, size)));
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
