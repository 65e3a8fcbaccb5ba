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

/// Writes the faces as they are, and returns them.
TopoDS_Shape save(const std::filesystem::path& path, const StepPlan& plan, const FittedFaces& made,
                  double coincidence, const StepFaceOptions& options, OccSettings& occ) {
  SharedEdges shared(plan);
  CadPart part;
  part.name = options.file.name;
  part.shape = assembled(plan, [&](int region, TopoDS_Shell& shell) {
    const TopoDS_Face face = made[region]->make(coincidence, plan.joined ? &shared : nullptr);
    BRep_Builder().Add(shell, face);
    part.faces.push_back(
        face_of_region(face, plan.regions[region]->name, region, plan.regions.size()));
    const auto& edges = made[region]->along_lines();
    part.edges.insert(part.edges.end(), edges.begin(), edges.end());
  });
  const TopoDS_Shape& shape = part.shape;
  show_largest_gaps(shape, coincidence);
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
    StepReport report = refined(made, options, [&] {
      const TopoDS_Shape shape = save(file.temporary(), plan, made,
                                      reader_coincidence(model_unit_in_metres), options, occ);
      // The file read back would not tell of all that is wrong: readers repair silently.
      bool valid = false;
      StepReport measured = measured_faces(file.temporary(), made, plan, options,
                                           [&] { valid = BRepCheck_Analyzer(shape).IsValid(); });
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
