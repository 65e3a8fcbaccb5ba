// SPDX-License-Identifier: MPL-2.0
#include "batten/io/cad/cad_join.h"

#include <BRepBuilderAPI_MakeSolid.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <BRepLib.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <GProp_GProps.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <algorithm>
#include <ostream>

#include "batten/core/errors.h"
#include "batten/io/cad/cad_file.h"
#include "batten/io/cad/cad_parts.h"
#include "batten/io/cad/cad_writer.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/input_file.h"

namespace batten {
namespace {

/// Replaces closed shells by solids with outward normals.
TopoDS_Shape with_solids(const TopoDS_Shape& sewn) {
  TopoDS_Compound result;
  BRep_Builder builder;
  builder.MakeCompound(result);
  int count = 0;
  TopoDS_Shape last;
  const auto add = [&](const TopoDS_Shape& shape) {
    last = shape;
    builder.Add(result, shape);
    ++count;
  };
  for (TopExp_Explorer s(sewn, TopAbs_SHELL); s.More(); s.Next()) {
    const TopoDS_Shell shell = TopoDS::Shell(s.Current());
    if (!free_edges_of(shell).IsEmpty()) {
      add(shell);
      continue;
    }
    TopoDS_Solid solid = BRepBuilderAPI_MakeSolid(shell);
    BRepLib::OrientClosedSolid(solid);
    add(solid);
  }
  for (TopExp_Explorer f(sewn, TopAbs_FACE, TopAbs_SHELL); f.More(); f.Next()) add(f.Current());
  return count == 1 ? last : TopoDS_Shape(result);
}

/// The faces of `part` that the options select, as one CAD part.
CadPart selected_part(const CadFile& part, const CadJoinOptions& options) {
  CadPart all;
  for (const CadPart& one : tree_of(part.document).parts) {
    if (all.name.empty()) all.name = one.name;
    for (const CadFace& face : one.faces) {
      const std::string name = "face " + std::to_string(part.faces.FindIndex(face.face));
      const auto has = [&](const std::vector<std::string>& names) {
        return std::find(names.begin(), names.end(), name) != names.end();
      };
      if ((options.only.empty() || has(options.only)) && !has(options.without))
        all.faces.push_back(face);
    }
  }
  return all;
}

std::string joined_text(const CadFile& part, const CadFile& added, const std::string& name,
                        const CadJoinOptions& options) {
  const double unit = options.model_unit_in_metres / 1e-3;  // one model unit in millimetres
  CadPart joined = selected_part(part, options);
  const size_t given = joined.faces.size();
  if (given == 0) throw InputError("found no face of the part, expected at least one");
  for (const CadPart& one : tree_of(added.document).parts)
    joined.faces.insert(joined.faces.end(), one.faces.begin(), one.faces.end());
  TopoDS_Compound faces;
  BRep_Builder builder;
  builder.MakeCompound(faces);
  for (const CadFace& face : joined.faces) builder.Add(faces, face.face);
  joined.shape = with_solids(sewn(faces, options.tolerance * unit, &joined.faces));
  // The faces of a solid may be turned.
  TopTools_IndexedMapOfShape placed;
  TopExp::MapShapes(joined.shape, TopAbs_FACE, placed);
  for (CadFace& face : joined.faces)
    if (const int at = placed.FindIndex(face.face)) face.face = TopoDS::Face(placed(at));
  CadWriteOptions how{CadFormat::Step, options.ap242, part.header.unit_in_metres, name};
  return cad_text(document_of({joined}), joined.shape, how);
}

CadJoinReport measured(const std::filesystem::path& file, const CadJoinOptions& options) {
  CadJoinReport report;
  ContinuityOptions as_read;
  as_read.sewing = 0;
  report.continuity = measure_continuity(file, options.model_unit_in_metres, as_read);
  const CadFile cad = read_cad(file);
  const OccSettings occ;  // only now: read_cad() may have forked a child process
  const double unit = 1e-3 / options.model_unit_in_metres;  // one millimetre in model units
  report.faces = cad.faces.Extent();
  for (TopExp_Explorer s(cad.shape, TopAbs_SOLID); s.More(); s.Next()) ++report.solids;
  for (TopExp_Explorer s(cad.shape, TopAbs_SHELL); s.More(); s.Next()) {
    ++report.shells;
    report.closed_shells += free_edges_of(s.Current()).IsEmpty();
  }
  report.valid = BRepCheck_Analyzer(cad.shape).IsValid();
  if (report.solids > 0) {
    GProp_GProps volume;
    BRepGProp::VolumeProperties(cad.shape, volume);
    report.volume = volume.Mass() * unit * unit * unit;
  }
  for (int e = 1; e <= cad.edges.Extent(); ++e)
    report.max_tolerance =
        std::max(report.max_tolerance, unit * BRep_Tool::Tolerance(TopoDS::Edge(cad.edges(e))));
  return report;
}

}  // namespace

CadJoinReport join_cad_files(const std::filesystem::path& part, const std::filesystem::path& added,
                             const std::filesystem::path& to, const CadJoinOptions& options) {
  if (!(options.tolerance > 0))
    throw InputError(to.string() + ": found the tolerance " + format_number(options.tolerance) +
                     " for joining faces, expected more than 0");
  const std::string text = sandboxed_read(
      part, "OpenCASCADE",
      [&] {
        const CadFile given = read_cad_here(part), more = read_cad_here(added);
        OccSettings occ;
        try {
          return joined_text(given, more, to.stem().string(), options);
        } catch (const Standard_Failure& failure) {
          throw InputError(part.string() +
                           ": OpenCASCADE cannot join faces to it: " + failure.GetMessageString());
        }
      },
      20);
  AtomicFile file(to);
  file.write([&](std::ostream& out) { out << text; });
  CadJoinReport report = measured(file.temporary(), options);
  report.added = read_cad(added).faces.Extent();
  file.commit();
  return report;
}

}  // namespace batten
