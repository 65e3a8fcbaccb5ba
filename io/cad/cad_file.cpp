#include "batten/io/cad/cad_file.h"

#include <BRep_Builder.hxx>
#include <BinTools.hxx>
#include <IGESControl_Reader.hxx>
#include <IGESData_IGESEntity.hxx>
#include <IGESGeom_Line.hxx>
#include <STEPControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <StepRepr_RepresentationItem.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopExp.hxx>
#include <TopoDS.hxx>
#include <TransferBRep.hxx>
#include <Transfer_TransientProcess.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>
#include <algorithm>
#include <array>
#include <cstdlib>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "batten/core/errors.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/files/in_child.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"

namespace batten {
namespace {

// ---- is the file whole? ---------------------------------------------------------------------
// OpenCASCADE reads what it can of a file that is cut short, and says nothing.

[[noreturn]] void refuse(const std::filesystem::path& file, size_t line, const std::string& what) {
  throw InputError(file.string() + ", line " + std::to_string(line) + ": " + what);
}

std::vector<std::string> lines_of(const std::filesystem::path& file) {
  std::istringstream in(input_bytes(file, "an IGES or STEP file"));
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) {
    while (!line.empty() && std::isspace(static_cast<unsigned char>(line.back()))) line.pop_back();
    lines.push_back(line);
  }
  while (!lines.empty() && lines.back().empty()) lines.pop_back();
  if (lines.empty()) throw InputError(file.string() + ": empty; expected an IGES or STEP file");
  return lines;
}

/// The number in columns [from, from + width), or -1.
long field(const std::string& line, size_t from, size_t width) {
  if (line.size() <= from) return -1;
  char* end = nullptr;
  const std::string text = line.substr(from, width);
  const long value = std::strtol(text.c_str(), &end, 10);
  return end == text.c_str() ? -1 : value;
}

/// Lines of 80 columns, a section's letter in column 73 and the number in the section after it; the
/// last line counts the lines of the others.
void check_iges(const std::filesystem::path& file, const std::vector<std::string>& lines) {
  const std::string sections = "SGDPT";
  std::array<size_t, 5> first{}, count{};
  size_t section = 0;
  for (size_t i = 0; i < lines.size(); ++i) {
    const char letter = lines[i].size() > 72 ? lines[i][72] : ' ';
    if (i == 0 && (letter == 'C' || letter == 'B'))
      refuse(file, 1, "compressed or binary IGES; expected the ASCII form in 80 columns");
    const size_t found = sections.find(letter);
    if (found == std::string::npos || found < section || (i == 0 && found != 0))
      refuse(file, i + 1,
             (lines[i].size() > 72 ? "found '" + std::string(1, letter) + "' in column 73"
                                   : "the line ends before column 73") +
                 "; expected the letter of an IGES section (S, G, D, P, T in this order): the file "
                 "is cut short or not IGES");
    if (found != section || i == 0) first[found] = i;
    section = found;
    if (field(lines[i], 73, 7) != static_cast<long>(++count[found]))
      refuse(file, i + 1,
             "line number " + lines[i].substr(std::min<size_t>(73, lines[i].size())) +
                 " in section " + letter + "; expected " + std::to_string(count[found]) +
                 ": a line is missing or cut short");
  }
  if (section != 4)
    refuse(file, lines.size(),
           "the file ends in section " + std::string(1, sections[section]) +
               "; expected a last line of section T: the file is cut short");
  for (size_t s = 0; s < 4; ++s)
    if (const long told = field(lines.back(), 8 * s + 1, 7); told != static_cast<long>(count[s]))
      refuse(file, lines.size(),
             "section " + std::string(1, sections[s]) + " should have " + std::to_string(told) +
                 " lines; found " + std::to_string(count[s]));
  if (count[2] == 0 || count[2] % 2)
    refuse(
        file, lines.size(),
        std::to_string(count[2]) + " lines in the directory (section D); expected two an entity");
  for (size_t d = first[2]; d < first[2] + count[2]; d += 2) {
    const long start = field(lines[d], 8, 8), length = std::max(field(lines[d + 1], 24, 8), 0L);
    if (start < 1 || start + length - 1 > static_cast<long>(count[3]))
      refuse(file, d + 1,
             "the entity's data are lines " + std::to_string(start) + " to " +
                 std::to_string(start + length - 1) + " of section P, which has " +
                 std::to_string(count[3]));
  }
}

void check_step_text(const std::filesystem::path& file, const std::vector<std::string>& lines) {
  size_t first = 0;
  while (lines[first].empty()) ++first;
  if (lines[first].find("ISO-10303-21") == std::string::npos)
    refuse(file, first + 1,
           "found '" + lines[first].substr(0, 40) + "'; expected 'ISO-10303-21;' of a STEP file");
  if (lines.back().find("END-ISO-10303-21") == std::string::npos)
    refuse(file, lines.size(),
           "the file ends with '" + lines.back().substr(0, 40) +
               "'; expected 'END-ISO-10303-21;': the file is cut short");
}

// ---- reading --------------------------------------------------------------------------------

std::string trimmed(const Handle(TCollection_HAsciiString) & text) {
  if (text.IsNull()) return "";
  std::string s = text->ToCString();
  const auto blank = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  s.erase(s.begin(), std::find_if_not(s.begin(), s.end(), blank));
  s.erase(std::find_if_not(s.rbegin(), s.rend(), blank).base(), s.end());
  return s;
}

std::string label_of(const Handle(Standard_Transient) & entity) {
  if (const auto iges = Handle(IGESData_IGESEntity)::DownCast(entity); !iges.IsNull())
    return iges->HasName() ? trimmed(iges->NameValue()) : "";
  if (const auto item = Handle(StepRepr_RepresentationItem)::DownCast(entity); !item.IsNull())
    return trimmed(item->Name());
  return "";
}

// What every edge is made from, in one pass: TransferReader looks through all entities for each.
std::vector<std::string> labels_of(const TopTools_IndexedMapOfShape& edges,
                                   const Handle(Transfer_TransientProcess) & made) {
  std::vector<std::string> labels(static_cast<size_t>(edges.Extent()));
  std::vector<char> known(labels.size(), 0);
  for (int i = 1; i <= made->NbMapped(); ++i) {
    const TopoDS_Shape shape = TransferBRep::ShapeResult(made, made->Mapped(i));
    const int edge = shape.IsNull() ? 0 : edges.FindIndex(shape);
    if (edge == 0 || std::exchange(known[static_cast<size_t>(edge) - 1], 1)) continue;
    labels[static_cast<size_t>(edge) - 1] = label_of(made->Mapped(i));
  }
  return labels;
}

bool is_geometry(const IGESData_IGESEntity& entity) {
  const int type = entity.TypeNumber();
  const bool curve_or_surface = (type >= 100 && type < 200) || (type >= 500 && type < 600);
  return curve_or_surface && type != 116 && type != 123 && type != 124 && type != 132;
}

bool without_length(const Handle(IGESData_IGESEntity) & entity) {
  const auto line = Handle(IGESGeom_Line)::DownCast(entity);
  return !line.IsNull() && line->StartPoint().IsEqual(line->EndPoint(), 1e-12);
}

void map_shapes(CadFile& cad) {
  TopExp::MapShapes(cad.shape, TopAbs_EDGE, cad.edges);
  TopExp::MapShapes(cad.shape, TopAbs_FACE, cad.faces);
}

void transfer(XSControl_Reader& reader, const std::filesystem::path& file, CadFile& cad) {
  BRep_Builder builder;
  builder.MakeCompound(cad.shape);
  const int roots = reader.NbRootsForTransfer();
  for (int r = 1; r <= roots; ++r) {
    const Handle(Standard_Transient) root = reader.RootForTransfer(r);
    const auto iges = Handle(IGESData_IGESEntity)::DownCast(root);
    // Flag 5: a curve in some parameter plane.
    if (!iges.IsNull() && iges->UseFlag() == 5) continue;
    const int shapes = reader.NbShapes();
    reader.TransferOneRoot(r);
    if (reader.NbShapes() > shapes)
      builder.Add(cad.shape, reader.Shape(reader.NbShapes()));
    else if (!iges.IsNull() && is_geometry(*iges) && !without_length(iges))
      throw InputError(file.string() + ": entity " +
                       reader.Model()->StringLabel(root)->ToCString() + " of type " +
                       std::to_string(iges->TypeNumber()) +
                       " cannot be converted; expected a curve or surface that OpenCASCADE knows");
  }
  cad.found = std::to_string(reader.Model()->NbEntities()) + " entities";
  if (roots == 0)
    throw InputError(file.string() + ": found " + cad.found +
                     " and no shape among them; expected "
                     "curves or surfaces");

  map_shapes(cad);
  cad.labels = labels_of(cad.edges, reader.WS()->TransferReader()->TransientProcess());
}

}  // namespace

namespace {

// The shapes and labels of a file whose text was looked at.
CadFile read_with_occ(const std::filesystem::path& file, bool iges) {
  OccSettings occ;
  occ.set_unit("MM");
  // One line an entity, corners in it or not; the default cuts splines at their corners.
  occ.set("read.iges.bspline.continuity", 0);
  CadFile cad;
  try {
    const auto read = [&](XSControl_Reader&& reader) {
      if (reader.ReadFile(file.string().c_str()) != IFSelect_RetDone)
        throw InputError(file.string() + ": OpenCASCADE cannot read it; expected " +
                         (iges ? "IGES" : "STEP"));
      transfer(reader, file, cad);
    };
    iges ? read(IGESControl_Reader()) : read(STEPControl_Reader());
  } catch (const Standard_Failure& failure) {
    throw InputError(file.string() +
                     ": OpenCASCADE failed to read it: " + failure.GetMessageString());
  }
  return cad;
}

// The order of edges in the map is that of the shape, and survives.
std::string to_bytes(const CadFile& cad) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out << cad.found << '\n' << cad.labels.size() << '\n';
  for (const std::string& label : cad.labels) out << label.size() << ' ' << label;
  BinTools::Write(cad.shape, out);
  return out.str();
}

CadFile from_bytes(const std::string& bytes) {
  std::istringstream in(bytes);
  in.imbue(std::locale::classic());
  CadFile cad;
  size_t count = 0;
  std::getline(in, cad.found);
  in >> count;
  in.get();
  for (size_t i = 0; i < count; ++i) {
    size_t length = 0;
    in >> length;
    in.get();
    in.read(cad.labels.emplace_back(length, ' ').data(), static_cast<std::streamsize>(length));
  }
  TopoDS_Shape shape;
  BinTools::Read(shape, in);
  if (!in || shape.IsNull() || shape.ShapeType() != TopAbs_COMPOUND)
    throw Error("what a child process read is not whole");
  cad.shape = TopoDS::Compound(shape);
  map_shapes(cad);
  return cad;
}

}  // namespace

CadFile read_cad(const std::filesystem::path& file) {
  const std::string extension = lower_extension(file);
  const bool iges = extension == ".igs" || extension == ".iges";
  if (!iges && extension != ".stp" && extension != ".step")
    throw InputError(file.string() + ": extension '" + extension +
                     "'; expected .igs, .iges, .stp or .step");
  const auto lines = lines_of(file);
  iges ? check_iges(file, lines) : check_step_text(file, lines);
  if (!reads_in_child()) return read_with_occ(file, iges);
  return from_bytes(
      bytes_from_child(file, "OpenCASCADE", [&] { return to_bytes(read_with_occ(file, iges)); }));
}

}  // namespace batten
