#include "batten/io/cad/step_face.h"

#include <BRepCheck_Analyzer.hxx>
#include <Standard_Failure.hxx>

#include <algorithm>
#include <cmath>
#include <set>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/core/parallel.h"
#include "batten/io/cad/edge_reparametrization.h"
#include "batten/io/cad/face_file.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/cad/step_text.h"
#include "batten/io/cad/unwritable_regions.h"
#include "batten/io/files/atomic_file.h"

namespace batten {
namespace {

/// Writes the faces as they are, and returns them.
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
  // Readers that see no better than 1e-7 of the unit would compute every border of a file anew that
  // claims more; in a tiny model that would be too much.
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

/// Whether all lines of all boundaries have names.
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

/// The regions that are planes, cylinders, … within the tolerance.
MeasuredShapes shapes_within(const StepPlan& plan, const StepFaceOptions& options) {
  MeasuredShapes shapes;
  if (!options.analytic || !lines_have_names(plan)) return shapes;
  std::vector<FittedPrimitive> found(plan.regions.size());
  parallel_for(isize(found), [&](int k) {
    const SkinnedRegion& region = *plan.regions[k];
    // What is measured on the file lies between the samples.
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

/// Plans the analytic faces, and cuts all lines. Shapes that cannot be one are erased.
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

/// The regions whose analytic faces are at fault for what is missed in a file.
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
    // Regions whose analytic faces fail become B-splines, and the file is written anew.
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
            // The file read back would not tell of all that is wrong: readers repair silently.
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
