#include "batten/io/cad/step_face.h"

#include <BRepCheck_Analyzer.hxx>
#include <Standard_Failure.hxx>

#include <algorithm>

#include "batten/core/errors.h"
#include "batten/io/cad/edge_parameter.h"
#include "batten/io/cad/face_file.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/cad/step_text.h"
#include "batten/io/files/whole_file.h"

namespace batten {
namespace {

/// Writes the faces as they are and returns whether OpenCASCADE finds nothing wrong with them. (The
/// file read back would not tell: readers repair silently.)
bool save(const std::filesystem::path& path, const StepPlan& plan, const FittedFaces& made,
          double coincidence, const StepFaceOptions& options, OccSettings& occ) {
  SharedEdges shared(plan);
  const TopoDS_Shape shape = assembled(plan, [&](int region, TopoDS_Shell& shell) {
    BRep_Builder().Add(shell, made[region]->make(coincidence, plan.joined ? &shared : nullptr));
  });
  show_largest_gaps(shape, coincidence);
  double tolerance = 0;
  for (const auto& maker : made) tolerance = std::max(tolerance, maker->tolerance());
  write_shape(path, shape, tolerance, options.name, {options.name, options.author, "surfaces"},
              occ);
  return BRepCheck_Analyzer(shape).IsValid();
}

}  // namespace

StepReport write_step_faces(const std::filesystem::path& path,
                            const std::vector<const SkinnedRegion*>& regions,
                            double model_unit_in_metres, const StepFaceOptions& options) {
  check_options(path, options);
  StepPlan plan = step_plan(regions, model_unit_in_metres);
  const std::string unit = cad_unit(model_unit_in_metres);
  WholeFile file(path);
  OccSettings occ;
  occ.set_unit(unit);
  try {
    if (plan.joined) cut_lines(plan, plan.regions);
    const FittedFaces made = fitted_faces(plan.regions, plan, options);
    StepReport report = refined(made, [&] {
      const bool valid = save(file.temporary(), plan, made,
                              reader_coincidence(model_unit_in_metres), options, occ);
      StepReport measured = measured_faces(file.temporary(), made, plan, options);
      measured.valid = measured.valid && valid;
      return measured;
    });
    file.commit();
    report.file = path;
    report.warnings = plan.warnings;
    return report;
  } catch (const Standard_Failure& failure) {
    throw Error(path.string() +
                ": OpenCASCADE failed to write or read it: " + failure.GetMessageString());
  }
}

}  // namespace batten
