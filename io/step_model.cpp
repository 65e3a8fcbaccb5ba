#include "batten/io/step_model.h"

#include <BRepGProp.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedDataMapOfShapeListOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>

#include <algorithm>
#include <chrono>
#include <memory>

#include "batten/core/errors.h"
#include "batten/core/parallel.h"
#include "batten/io/face_file.h"
#include "batten/io/step_text.h"
#include "batten/io/whole_file.h"

namespace batten {
namespace {

/// Regions as the file has them: the faces of each shell side by side.
struct ShellPlan {
  std::vector<int> faces;  // indices into Plan::regions, which has them in this order
  bool solid = false;
};
struct Plan {
  std::vector<const SkinnedRegion*> regions;
  std::vector<ShellPlan> shells;
  std::vector<std::string> warnings;
};

bool branches(const SurfaceModel& model, const ModelShell& shell) {
  for (const ModelJoin& join : model.joins)
    if (join.kind == ModelJoin::Kind::Branching &&
        std::any_of(join.regions.begin(), join.regions.end(), [&](int r) {
          return std::find(shell.regions.begin(), shell.regions.end(), r) != shell.regions.end();
        }))
      return true;
  return false;
}

Plan plan_of(const SurfaceModel& model) {
  Plan plan;
  for (const ModelShell& shell : model.shells) {
    ShellPlan faces;
    bool whole = true;
    for (const int r : shell.regions) {
      const ModelRegion& region = model.regions[static_cast<size_t>(r)];
      // No face can be fitted to a surface that turns over.
      const bool turns_over =
          std::any_of(model.flaws.begin(), model.flaws.end(), [r](const SurfaceFlaw& flaw) {
            return flaw.kind == SurfaceFlaw::Kind::Jacobian && flaw.regions[0] == r;
          });
      if (turns_over)
        plan.warnings.push_back("region '" + region.plan.name +
                                "' is left out of the file: its surface turns over");
      whole = whole && region.skinned && !turns_over;
      if (!region.skinned || turns_over) continue;
      faces.faces.push_back(static_cast<int>(plan.regions.size()));
      plan.regions.push_back(&*region.skinned);
    }
    if (faces.faces.empty()) continue;
    faces.solid = whole && shell.closed && shell.orientable && shell.volume > 0;
    const bool branching = branches(model, shell);
    if (shell.orientable && !branching) {
      plan.shells.push_back(std::move(faces));
      continue;
    }
    if (faces.faces.size() > 1)
      plan.warnings.push_back(
          std::string("regions that hang together ") +
          (branching ? "meet three and more at a line" : "have no outside in common") +
          ": they are a shell each, with common edges");
    for (const int f : faces.faces) plan.shells.push_back({{f}, false});
  }
  return plan;
}

/// Lines are cut at the same places for all regions.
CommonLines common_lines(const Plan& plan, const CharacterLineNetwork& network) {
  CommonLines common;
  common.distance = 1e-6 * network.size();
  for (const NetworkArc& arc : network.arcs()) common.curves.emplace(arc.name, &arc.curve);
  LineCuts cuts;
  for (const SkinnedRegion* region : plan.regions) FaceBoundary(*region, &common).add_cuts(cuts);
  for (auto& [line, at] : cuts) {
    std::sort(at.begin(), at.end());
    const HermiteCurve& curve = *common.curves.at(line);
    const double hair = 1e-9 * (curve.end() - curve.start());
    at.erase(std::unique(at.begin(), at.end(), [&](double a, double b) { return b - a <= hair; }),
             at.end());
  }
  common.cuts = std::move(cuts);
  return common;
}

TopoDS_Shape shape_of(const Plan& plan, std::vector<std::unique_ptr<FaceMaker>>& made,
                      const LineCuts& cuts, const SharedEdges::NodeOf& node_of, double& tolerance) {
  BRep_Builder builder;
  SharedEdges shared(cuts, node_of);
  TopoDS_Compound compound;
  builder.MakeCompound(compound);
  TopoDS_Shape last;
  for (const ShellPlan& faces : plan.shells) {
    TopoDS_Shell shell;
    builder.MakeShell(shell);
    for (const int f : faces.faces) builder.Add(shell, made[static_cast<size_t>(f)]->make(&shared));
    shell.Closed(faces.solid);
    last = shell;
    if (faces.solid) {
      TopoDS_Solid solid;
      builder.MakeSolid(solid);
      builder.Add(solid, shell);
      last = solid;
    }
    builder.Add(compound, last);
  }
  for (const auto& maker : made) tolerance = std::max(tolerance, maker->tolerance());
  return plan.shells.size() > 1 ? TopoDS_Shape(compound) : last;
}

void measure_shells(const TopoDS_Shape& shape, StepModelReport& report) {
  for (TopExp_Explorer it(shape, TopAbs_SOLID); it.More(); it.Next()) {
    ++report.solids;
    GProp_GProps properties;
    BRepGProp::VolumeProperties(it.Current(), properties);
    report.volume += properties.Mass();
  }
  for (TopExp_Explorer it(shape, TopAbs_SHELL); it.More(); it.Next()) {
    ++report.shells;
    TopTools_IndexedDataMapOfShapeListOfShape faces_of_edge;
    TopExp::MapShapesAndAncestors(it.Current(), TopAbs_EDGE, TopAbs_FACE, faces_of_edge);
    bool closed = true;
    for (int e = 1; e <= faces_of_edge.Extent(); ++e)
      closed = closed && faces_of_edge(e).Extent() == 2;  // a seam's face comes twice
    report.closed_shells += closed;
  }
  for (TopExp_Explorer it(shape, TopAbs_EDGE); it.More(); it.Next())
    report.max_tolerance =
        std::max(report.max_tolerance, BRep_Tool::Tolerance(TopoDS::Edge(it.Current())));
  for (TopExp_Explorer it(shape, TopAbs_VERTEX); it.More(); it.Next())
    report.max_tolerance =
        std::max(report.max_tolerance, BRep_Tool::Tolerance(TopoDS::Vertex(it.Current())));
}

}  // namespace

StepModelReport write_step_model(const std::filesystem::path& path,
                                 const CharacterLineNetwork& network, const SurfaceModel& model,
                                 double model_unit_in_metres, const StepFaceOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  const Plan plan = plan_of(model);
  if (plan.regions.empty()) throw InputError(path.string() + ": no region to write");
  check_options(path, options);
  const std::string unit = cad_unit(model_unit_in_metres);
  WholeFile file(path);
  std::map<std::string, const NetworkArc*> arcs;
  for (const NetworkArc& arc : network.arcs()) arcs.emplace(arc.name, &arc);
  const auto node_of = [&](const std::string& line, bool end) {
    return arcs.at(line)->nodes[end ? 1 : 0];
  };
  const CommonLines common = common_lines(plan, network);
  std::vector<std::unique_ptr<FaceMaker>> made(plan.regions.size());
  parallel_parts(static_cast<int>(made.size()), [&](int k) {
    const auto i = static_cast<size_t>(k);
    made[i] = std::make_unique<FaceMaker>(*plan.regions[i], options, &common);
  });
  std::vector<const FaceMaker*> in_order;  // regions are planned shell by shell
  for (const auto& maker : made) in_order.push_back(maker.get());

  OccSettings occ;
  set_up_faces(occ, unit, options.name);
  try {
    StepModelReport report;
    TopoDS_Shape read;
    for (int round = 0; round < 4; ++round) {
      double tolerance = 0;
      const TopoDS_Shape shape = shape_of(plan, made, common.cuts, node_of, tolerance);
      const bool valid = write_faces(file.temporary(), shape, tolerance, occ, options);
      static_cast<StepFaceReport&>(report) =
          measured_faces(file.temporary(), in_order, options.tolerance, read);
      report.valid = report.valid && valid;
      bool again = false;
      for (size_t k = 0; k < in_order.size(); ++k)
        if (!report.patches[k].reached)
          again = made[k]->refine(report.patches[k].deviation) || again;
      if (!again) break;
    }
    measure_shells(read, report);
    file.commit();
    report.file = path;
    report.warnings.insert(report.warnings.begin(), plan.warnings.begin(), plan.warnings.end());
    report.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return report;
  } catch (const Standard_Failure& failure) {
    throw Error(path.string() +
                ": OpenCASCADE failed to write or read it: " + failure.GetMessageString());
  }
}

}  // namespace batten
