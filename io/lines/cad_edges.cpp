#include "batten/io/lines/cad_edges.h"

#include <BRepLib.hxx>
#include <BRep_Tool.hxx>
#include <TopoDS.hxx>
#include <algorithm>
#include <set>

namespace batten {

Handle(Geom_Curve) curve_of(const TopoDS_Edge& edge, double& start, double& end) {
  if (BRep_Tool::Degenerated(edge)) return {};
  Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, start, end);
  if (curve.IsNull()) {
    // An edge that is stored as a parameter curve only.
    if (!BRepLib::BuildCurve3d(edge)) return {};
    curve = BRep_Tool::Curve(edge, start, end);
  }
  if (curve.IsNull() || !(end > start)) return {};
  constexpr int samples = 16;
  const gp_Pnt first = curve->Value(start);
  double reach = 0;
  for (int i = 1; i <= samples; ++i)
    reach = std::max(reach, first.Distance(curve->Value(start + (end - start) * i / samples)));
  if (reach <= 1e-12 * (1 + first.XYZ().Modulus())) return {};
  return curve;
}

std::vector<std::string> edge_names(const CadFile& cad) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  int count = 0;
  for (int e = 1; e <= cad.edges.Extent(); ++e) {
    double start, end;
    std::string& name = names.emplace_back();
    if (curve_of(TopoDS::Edge(cad.edges(e)), start, end).IsNull()) continue;
    const std::string& label = cad.labels[e - 1];
    ++count;
    name = label.empty() ? "edge" + std::to_string(count) : label;
    for (int n = 2; !taken.insert(name).second; ++n) name = label + "_" + std::to_string(n);
  }
  return names;
}

}  // namespace batten
