#include "batten/io/cad/cad_convert.h"

#include <BRepTools.hxx>
#include <Message_ProgressRange.hxx>
#include <RWGltf_CafWriter.hxx>
#include <Standard_Failure.hxx>
#include <TColStd_IndexedDataMapOfStringString.hxx>
#include <algorithm>
#include <sstream>

#include "batten/core/errors.h"
#include "batten/io/cad/cad_contents_bytes.h"
#include "batten/io/cad/cad_mesher.h"
#include "batten/io/cad/cad_writer.h"
#include "batten/io/cad/measure_contents.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/cad/read_cad_contents.h"
#include "batten/io/cad/step_text.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/sandboxed_read.h"
#include "batten/io/files/text.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

/// The unit of the file that is written. BREP states none: programs take its numbers for
/// millimetres.
double unit_of(const CadConvertOptions& options, const fs::path& to, double unit_of_source) {
  if (options.unit_in_metres > 0) return options.unit_in_metres;
  return lower_extension(to).starts_with(".br") ? 1e-3 : unit_of_source;
}

/// What `work` makes of a file, in a child: it sends the contents and what else is asked for.
template <class Work>
std::string read_sandboxed(const fs::path& from, const Work& work) {
  return sandboxed_read(
      from, "OpenCASCADE",
      [&] {
        const CadFile cad = read_cad_here(from);
        OccSettings occ;
        try {
          const std::string contents = to_bytes(contents_of(cad));
          return std::to_string(contents.size()) + "\n" + contents + work(cad);
        } catch (const Standard_Failure& failure) {
          throw InputError(from.string() +
                           ": OpenCASCADE cannot convert it: " + failure.GetMessageString());
        }
      },
      20);
}

/// Takes the contents off the front of what read_sandboxed() sent.
CadContents take_contents(std::string& bytes) {
  const size_t end = bytes.find('\n'), length = std::stoul(bytes.substr(0, end));
  const CadContents contents = contents_from_bytes(bytes.substr(end + 1, length));
  bytes.erase(0, end + 1 + length);
  return contents;
}

/// What IGES cannot hold.
void add_iges_notes(CadConversion& c) {
  int edges = 0;
  for (const CadAttribute& use : c.before.names) edges += use.edges;
  if (edges > 0)
    c.notes.push_back("IGES has no names of edges between faces: " + std::to_string(edges) +
                      " are lost");
  if (std::any_of(c.before.products.begin(), c.before.products.end(),
                  [](const CadProduct& product) { return product.assembly; }))
    c.notes.push_back("IGES has no assemblies: parts are solids at their places, by their names");
}

CadConversion to_cad(const fs::path& from, const fs::path& to, const CadConvertOptions& options) {
  CadWriteOptions how{cad_format(to), options.ap242, 1e-3, to.stem().string()};
  if (how.format == CadFormat::Patches)
    throw InputError(to.string() +
                     ": sets of patches are only read, expected .step, .iges, .brep "
                     "or .glb");
  std::string bytes = read_sandboxed(from, [&](const CadFile& cad) {
    how.unit_in_metres = unit_of(options, to, cad.header.unit_in_metres);
    return cad_text(cad.document, cad.shape, how);
  });
  CadConversion result;
  result.before = take_contents(bytes);
  result.unit_in_metres = unit_of(options, to, result.before.unit_in_metres);
  AtomicFile file(to);
  write_file_atomically(file.temporary(), [&](std::ostream& out) { out << bytes; });
  result.after = read_cad_contents(file.temporary());
  file.commit();
  if (how.format == CadFormat::Iges) add_iges_notes(result);
  if (how.format == CadFormat::Brep) {
    if (!result.before.names.empty() || !result.before.colours.empty() ||
        result.before.products.size() > 1 || !result.before.layers.empty())
      result.notes.push_back(
          "BREP holds shapes only: names, colours, layers and products are lost");
    // It is read back as millimetres whatever its numbers are.
    result.after.unit_in_metres = result.unit_in_metres;
    result.after.notes.clear();
  }
  return result;
}

void write_glb(const CadFile& cad, const JoinedParts& joined, const fs::path& file) {
  const auto document = joined.sewn ? document_of(joined.parts) : cad.document;
  RWGltf_CafWriter writer(file.c_str(), true);
  writer.ChangeCoordinateSystemConverter().SetInputLengthUnit(1e-3);
  writer.ChangeCoordinateSystemConverter().SetInputCoordinateSystem(RWMesh_CoordinateSystem_Zup);
  TColStd_IndexedDataMapOfStringString header;
  header.Add("Generator", "Batten");
  if (!writer.Perform(document, header, Message_ProgressRange()))
    throw Error("OpenCASCADE cannot write glTF");
}

CadConversion to_glb(const fs::path& from, const fs::path& to, const CadConvertOptions& options) {
  AtomicFile file(to);
  const TemporaryFileGuard beside(file.temporary().string() + ".bin.tmp");  // the writer's own
  std::string bytes = read_sandboxed(from, [&](const CadFile& cad) {
    const JoinedParts joined = joined_parts(cad);
    const CadFacets facets =
        mesh_parts(joined.parts, joined.size,
                   options.chord * unit_of(options, to, cad.header.unit_in_metres) / 1e-3);
    if (facets.mesh.face_count() == 0)
      throw InputError(from.string() + ": found " + cad.found +
                       " and no face, expected some to mesh");
    write_glb(cad, joined, file.temporary());
    std::ostringstream out;
    out.precision(17);
    out << facets.size << ' ' << facets.chord << ' ' << facets.deviation << ' '
        << facets.mesh.face_count() << ' ' << facets.cracks << ' ' << facets.unmeshed;
    return out.str();
  });
  CadConversion result;
  result.before = take_contents(bytes);
  result.unit_in_metres = unit_of(options, to, result.before.unit_in_metres);
  std::istringstream in(bytes);
  in >> result.size >> result.chord >> result.deviation >> result.triangles >> result.cracks >>
      result.unmeshed;
  for (double* length : {&result.size, &result.chord, &result.deviation})
    *length *= 1e-3 / result.unit_in_metres;
  file.commit();
  return result;
}

}  // namespace

CadConversion convert_cad(const fs::path& from, const fs::path& to,
                          const CadConvertOptions& options) {
  if (lower_extension(to) == ".glb") return to_glb(from, to, options);
  if (options.unit_in_metres > 0) cad_unit(options.unit_in_metres);
  return to_cad(from, to, options);
}

}  // namespace batten
