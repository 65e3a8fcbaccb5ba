#include "batten/io/cad/cad_mesher.h"

#include <BRepBndLib.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <IMeshTools_Parameters.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <algorithm>
#include <cmath>
#include <tuple>

#include "batten/io/cad/cad_free_edges.h"
#include "batten/io/cad/continuity.h"
#include "batten/io/cad/facet_numbering.h"

namespace batten {
namespace {

TopoDS_Compound together(const std::vector<CadPart>& parts) {
  TopoDS_Compound all;
  BRep_Builder builder;
  builder.MakeCompound(all);
  for (const CadPart& part : parts)
    if (!part.faces.empty()) builder.Add(all, part.shape);
  return all;
}

double size_of(const TopoDS_Shape& shape) {
  Bnd_Box box;
  BRepBndLib::AddOptimal(shape, box, false, false);
  return box.IsVoid() ? 0 : std::sqrt(box.SquareExtent());
}

/// Faces of IGES files are parts of their own: they become one, with faces that have the parts'
/// names.
void make_one(std::vector<CadPart>& parts) {
  CadPart all;
  all.shape = together(parts);
  for (CadPart& part : parts) {
    for (CadFace& face : part.faces) {
      if (face.name.empty()) face.name = part.name;
      all.faces.push_back(face);
    }
    all.curves.insert(all.curves.end(), part.curves.begin(), part.curves.end());
  }
  parts = {all};
}

/// Largest distances of chords from edges, and of flat triangles from faces.
struct Deflection {
  double edges, faces;
};

void mesh_faces(const TopoDS_Shape& shape, const Deflection& deflection) {
  BRepTools::Clean(shape);
  IMeshTools_Parameters how;
  how.Deflection = deflection.edges;
  how.DeflectionInterior = deflection.faces;
  how.Angle = 0.5;
  BRepMesh_IncrementalMesh(shape, how);
}

/// Meshes with holes are worse than rough ones.
std::tuple<int, int, double> worth(const CadFacets& f) {
  return {f.unmeshed, f.cracks, f.deviation};
}

}  // namespace

JoinedParts joined_parts(const CadFile& cad) {
  JoinedParts result{tree_of(cad.document).parts, false, size_of(cad.shape)};
  if (cad.header.format == CadFormat::Iges && result.parts.size() > 1) {
    make_one(result.parts);
    result.sewn = true;
  }
  for (CadPart& part : result.parts) {
    const int free_edges = free_edges_of(part.shape).Extent();
    if (free_edges == 0) continue;
    std::vector<CadFace> faces = part.faces;
    const TopoDS_Shape shape = sewn(part.shape, ContinuityOptions{}.sewing * result.size, &faces);
    if (free_edges_of(shape).Extent() >= free_edges) continue;  // nothing lies on anything else
    part.shape = shape;
    part.faces = std::move(faces);
    result.sewn = true;
  }
  return result;
}

CadFacets mesh_parts(const std::vector<CadPart>& parts, double size, double chord, bool curved) {
  const TopoDS_Compound all = together(parts);
  if (!(chord > 0)) chord = 1e-3 * size;
  CadFacets facets;
  // Flat triangles are off by h², curved ones by h⁴.
  Deflection deflection = {chord, curved ? std::max(chord, 0.1 * std::sqrt(chord * size)) : chord};
  Deflection last = deflection, best = deflection;
  for (int round = 0; round < 5; ++round) {
    mesh_faces(all, last = deflection);
    CadFacets made = number_facets(parts, all, curved);
    const bool whole = made.unmeshed == 0 && made.cracks == 0;
    const bool better = round == 0 || worth(made) < worth(facets);
    const double deviation = made.deviation;
    if (better) {
      facets = std::move(made);
      best = deflection;
    }
    if (whole && deviation <= chord) break;
    if (whole && !better && round > 1) break;
    // Faces whose borders cross each other in the plane of parameters may do so no more when these
    // are finer.
    const double finer = whole ? std::clamp(0.9 * chord / deviation, 0.1, 0.7) : 0.7;
    deflection.edges *= std::max(finer, curved ? 0.7 : 0.1);
    deflection.faces *= curved ? std::sqrt(finer) : finer;
  }
  if (best.faces != last.faces) mesh_faces(all, best);
  facets.size = size;
  facets.chord = chord;
  return facets;
}

}  // namespace batten
