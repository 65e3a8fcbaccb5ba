// SPDX-License-Identifier: MPL-2.0
// CAD files for tests.
#pragma once

#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <TDataStd_Name.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_LayerTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <gp_Ax2.hxx>

#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "batten/io/cad/cad_parts.h"
#include "batten/io/cad/cad_writer.h"
#include "batten/io/files/input_file.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/test_data.h"

namespace batten_test {

using namespace batten;
namespace fs = std::filesystem;

/// During its lifetime, CAD files are read as in the program.
struct SandboxScope {
  SandboxScope() { enable_sandboxed_read(true); }
  ~SandboxScope() { enable_sandboxed_read(false); }
};

/// A part with faces "face 1", "face 2" …, alternately red and green.
inline CadPart painted(const std::string& name, const TopoDS_Shape& shape) {
  CadPart part;
  part.name = name;
  part.shape = shape;
  TopTools_IndexedMapOfShape faces;
  TopExp::MapShapes(shape, TopAbs_FACE, faces);
  for (int f = 1; f <= faces.Extent(); ++f)
    part.faces.push_back(
        {TopoDS::Face(faces(f)), "face " + std::to_string(f), f % 2 ? "#ff0000" : "#00ff00"});
  return part;
}

/// Writes a document in the format of the file's extension.
inline fs::path written(const fs::path& file, const Handle(TDocStd_Document) & document,
                        const TopoDS_Shape& shape, double unit_in_metres = 1e-3) {
  CadWriteOptions options;
  options.format = cad_format(file);
  options.unit_in_metres = unit_in_metres;
  options.name = file.stem().string();
  std::ofstream(file, std::ios::binary) << cad_text(document, shape, options);
  return file;
}

inline fs::path written(const fs::path& file, const CadPart& part, double unit_in_metres = 1e-3) {
  return written(file, document_of({part}), part.shape, unit_in_metres);
}

/// A block of 40 x 30 x 20 mm with a hole of radius 5.
inline TopoDS_Shape drilled_block() {
  return BRepAlgoAPI_Cut(
             BRepPrimAPI_MakeBox(40, 30, 20).Shape(),
             BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(20, 15, -1), gp_Dir(0, 0, 1)), 5, 30).Shape())
      .Shape();
}

}  // namespace batten_test
