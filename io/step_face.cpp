#include "batten/io/step_face.h"

#include <BRep_Builder.hxx>
#include <Standard_Failure.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Shell.hxx>

#include <algorithm>
#include <chrono>

#include "batten/core/errors.h"
#include "batten/io/face_file.h"
#include "batten/io/step_text.h"
#include "batten/io/whole_file.h"

namespace batten {
namespace {

bool save(const std::filesystem::path& path, std::vector<FaceMaker>& made, OccSettings& occ,
          const StepFaceOptions& options) {
  BRep_Builder builder;
  TopoDS_Compound compound;
  TopoDS_Shape shape;
  builder.MakeCompound(compound);
  double tolerance = 0;
  for (FaceMaker& maker : made) {
    TopoDS_Shell shell;
    builder.MakeShell(shell);
    builder.Add(shell, maker.make());
    builder.Add(compound, shell);
    shape = shell;
    tolerance = std::max(tolerance, maker.tolerance());
  }
  if (made.size() > 1) shape = compound;
  return write_faces(path, shape, tolerance, occ, options);
}

}  // namespace

StepFaceReport write_step_face(const std::filesystem::path& path,
                               const std::vector<const SkinnedRegion*>& regions,
                               double model_unit_in_metres, const StepFaceOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  if (regions.empty()) throw InputError(path.string() + ": no region to write");
  check_options(path, options);
  const std::string unit = cad_unit(model_unit_in_metres);
  WholeFile file(path);
  std::vector<FaceMaker> made;
  made.reserve(regions.size());
  for (const SkinnedRegion* region : regions) made.emplace_back(*region, options);
  std::vector<const FaceMaker*> pointers;
  for (const FaceMaker& maker : made) pointers.push_back(&maker);

  OccSettings occ;
  set_up_faces(occ, unit, options.name);
  try {
    StepFaceReport report;
    for (int round = 0; round < 4; ++round) {
      const bool valid = save(file.temporary(), made, occ, options);
      TopoDS_Shape shape;
      report = measured_faces(file.temporary(), pointers, options.tolerance, shape);
      report.valid = report.valid && valid;
      bool again = false;
      for (size_t k = 0; k < made.size(); ++k)
        if (!report.patches[k].reached)
          again = made[k].refine(report.patches[k].deviation) || again;
      if (!again) break;
    }
    file.commit();
    report.file = path;
    report.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return report;
  } catch (const Standard_Failure& failure) {
    throw Error(path.string() +
                ": OpenCASCADE failed to write or read it: " + failure.GetMessageString());
  }
}

}  // namespace batten
