// SPDX-License-Identifier: MPL-2.0
#include "batten/io/cad/cad_convert.h"

#include <BRepBndLib.hxx>
#include <BRepGProp.hxx>
#include <BRepTools.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <GProp_GProps.hxx>
#include <Message_ProgressRange.hxx>
#include <RWGltf_CafWriter.hxx>
#include <Standard_Failure.hxx>
#include <TColStd_IndexedDataMapOfStringString.hxx>
#include <TopExp.hxx>
#include <TopTools_IndexedMapOfShape.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/cad/cad_contents.h"
#include "batten/io/cad/cad_file.h"
#include "batten/io/cad/cad_mesher.h"
#include "batten/io/cad/cad_parts.h"
#include "batten/io/cad/cad_primitive.h"
#include "batten/io/cad/cad_writer.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"

namespace batten {

// Transfer of CadContents out of a child process.

/// Serialises contents as JSON, and parses them. Throws InputError for numbers that were not
/// finite.
std::string to_bytes(const CadContents& contents);
CadContents contents_from_bytes(const std::string& bytes);

// Counts and measures the contents of a file.

/// Summarises a file that was read in this process. Throws the exceptions of OpenCASCADE.
CadContents contents_of(const CadFile& cad);

namespace fs = std::filesystem;
namespace {

/// The unit of the output. BREP declares none; other programs assume millimetres.
double unit_of(const CadConvertOptions& options, const fs::path& to, double unit_of_source) {
  if (options.unit_in_metres > 0) return options.unit_in_metres;
  return lower_extension(to).starts_with(".br") ? 1e-3 : unit_of_source;
}

/// Reads a file in a child process. Returns its serialised contents, followed by the result of
/// `work`.
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
                           ": OpenCASCADE cannot convert this file: " + failure.GetMessageString());
        }
      },
      20);
}

/// Removes the contents from the front of the bytes that read_sandboxed() returned, and parses
/// them.
CadContents take_contents(std::string& bytes) {
  const size_t end = bytes.find('\n'), length = std::stoul(bytes.substr(0, end));
  const CadContents contents = contents_from_bytes(bytes.substr(end + 1, length));
  bytes.erase(0, end + 1 + length);
  return contents;
}

/// Adds a note for each kind of data that IGES cannot store.
void add_iges_notes(CadConversion& c) {
  int edges = 0;
  for (const CadAttribute& use : c.before.names) edges += use.edges;
  if (edges > 0)
    c.notes.push_back("IGES cannot store names of edges between faces: " + std::to_string(edges) +
                      " are lost");
  if (std::any_of(c.before.products.begin(), c.before.products.end(),
                  [](const CadProduct& product) { return product.assembly; }))
    c.notes.push_back(
        "IGES has no assemblies: parts are written as named solids at their positions");
}

CadConversion to_cad(const fs::path& from, const fs::path& to, const CadConvertOptions& options) {
  CadWriteOptions how{cad_format(to), options.ap242, 1e-3, to.stem().string()};
  if (how.format == CadFormat::Patches)
    throw InputError(to.string() +
                     ": found a patch file, which can only be read, expected .step, .iges, .brep "
                     "or .glb");
  std::string bytes = read_sandboxed(from, [&](const CadFile& cad) {
    how.unit_in_metres = unit_of(options, to, cad.header.unit_in_metres);
    return cad_text(cad.document, cad.shape, how);
  });
  CadConversion result;
  result.before = take_contents(bytes);
  result.unit_in_metres = unit_of(options, to, result.before.unit_in_metres);
  AtomicFile file(to);
  file.write([&](std::ostream& out) { out << bytes; });
  result.after = read_cad_contents(file.temporary());
  file.commit();
  if (how.format == CadFormat::Iges) add_iges_notes(result);
  if (how.format == CadFormat::Brep) {
    if (!result.before.names.empty() || !result.before.colours.empty() ||
        result.before.products.size() > 1 || !result.before.layers.empty())
      result.notes.push_back(
          "BREP stores shapes only: names, colours, layers and products are lost");
    // BREP is read back as millimetres, whatever the unit of its numbers.
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
  errno = 0;
  if (writer.Perform(document, header, Message_ProgressRange())) return;
  // The library states no reason.
  const int reason = errno;
  std::error_code unknown;
  const auto free = fs::space(file.parent_path(), unknown).available;
  constexpr std::uintmax_t kLittle = 1 << 20;  // bytes
  throw InputError(without_temporary_folders(file).string() + ": cannot write this file: " +
                   (!unknown && free < kLittle ? std::strerror(ENOSPC)
                    : reason != 0              ? std::strerror(reason)
                                               : "OpenCASCADE cannot write glTF"));
}

CadConversion to_glb(const fs::path& from, const fs::path& to, const CadConvertOptions& options) {
  AtomicFile file(to);
  std::string bytes = read_sandboxed(from, [&](const CadFile& cad) {
    const JoinedParts joined = joined_parts(cad);
    const CadFacets facets =
        mesh_parts(joined.parts, joined.size,
                   options.chord * unit_of(options, to, cad.header.unit_in_metres) / 1e-3);
    if (facets.mesh.face_count() == 0)
      throw InputError(from.string() + ": found " + cad.found +
                       " and no face, expected at least one face");
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

namespace {

// ---- transfer out of a child process ---------------------------------------------------------

class Bytes {
 public:
  template <class T>
  Bytes& add(const T* data, size_t count) {
    put(count);
    text_.append(reinterpret_cast<const char*>(data), count * sizeof(T));
    return *this;
  }
  Bytes& add(const std::string& text) { return add(text.data(), text.size()); }
  template <class T>
  Bytes& put(T value) {
    text_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

class BytesReader {
 public:
  explicit BytesReader(const std::string& text) : text_(text) {}
  template <class T>
  T get() {
    T value;
    std::memcpy(&value, take(sizeof value), sizeof value);
    return value;
  }
  template <class T>
  std::vector<T> list() {
    std::vector<T> result(get<size_t>());
    if (!result.empty())
      std::memcpy(result.data(), take(result.size() * sizeof(T)), result.size() * sizeof(T));
    return result;
  }
  std::string text() {
    const auto letters = list<char>();
    return {letters.begin(), letters.end()};
  }

 private:
  const char* take(size_t count) {
    if (count > text_.size() - at_) throw Error("the mesh of a child process is incomplete");
    at_ += count;
    return text_.data() + at_ - count;
  }
  const std::string& text_;
  size_t at_ = 0;
};

std::string to_bytes(const CadFacets& f) {
  Bytes out;
  out.add(to_bytes(f.contents));
  std::vector<int> corners;
  for (int t = 0; t < f.mesh.face_count(); ++t)
    corners.insert(corners.end(), f.mesh.face(t).begin(), f.mesh.face(t).end());
  out.add(f.mesh.points.data(), static_cast<size_t>(f.mesh.points.size()));
  out.add(corners.data(), corners.size()).put(f.groups.size());
  for (const FacetGroup& group : f.groups)
    out.add(group.name).add(group.colour).add(group.triangles.data(), group.triangles.size());
  std::vector<double> normals;
  for (const auto& triple : f.normals)
    for (const Vec3& n : triple) normals.insert(normals.end(), {n[0], n[1], n[2]});
  out.add(normals.data(), normals.size());
  out.add(f.faces.data(), f.faces.size());
  std::vector<double> primitives;
  for (const FittedPrimitive& p : f.primitives)
    primitives.insert(primitives.end(),
                      {static_cast<double>(p.kind), p.origin.x(), p.origin.y(), p.origin.z(),
                       p.axis.x(), p.axis.y(), p.axis.z(), p.radius, p.major_radius, p.half_angle});
  out.add(primitives.data(), primitives.size()).add(f.swept.data(), f.swept.size());
  out.put(f.size).put(f.chord).put(f.deviation);
  out.put(f.shells).put(f.free_edges).put(f.cracks).put(f.unmeshed);
  return out.take();
}

CadFacets facets_from_bytes(const std::string& bytes) {
  BytesReader in(bytes);
  CadFacets f;
  f.contents = contents_from_bytes(in.text());
  const auto numbers = in.list<double>();
  f.mesh.points = Eigen::Map<const Points>(numbers.data(), isize(numbers) / 3, 3);
  const auto corners = in.list<int>();
  for (size_t c = 0; c + 2 < corners.size(); c += 3)
    f.mesh.add_face(std::span<const int>(corners.data() + c, 3));
  f.groups.resize(in.get<size_t>());
  for (FacetGroup& group : f.groups) {
    group.name = in.text();
    group.colour = in.text();
    group.triangles = in.list<int>();
  }
  const auto normals = in.list<double>();
  for (size_t t = 0; t + 8 < normals.size(); t += 9) {
    const Eigen::Map<const Mat3> n(normals.data() + t);
    f.normals.push_back({n.col(0), n.col(1), n.col(2)});
  }
  f.faces = in.list<int>();
  const auto primitives = in.list<double>();
  for (size_t k = 0; k + 9 < primitives.size(); k += 10) {
    const double* n = primitives.data() + k;
    f.primitives.push_back({static_cast<FittedPrimitive::Kind>(static_cast<int>(n[0])),
                            Vec3(n[1], n[2], n[3]), Vec3(n[4], n[5], n[6]), n[7], n[8], n[9]});
  }
  f.swept = in.list<char>();
  for (double* number : {&f.size, &f.chord, &f.deviation}) *number = in.get<double>();
  for (int* number : {&f.shells, &f.free_edges, &f.cracks, &f.unmeshed}) *number = in.get<int>();
  return f;
}

void scale(CadFacets& f, double factor) {
  f.mesh.points *= factor;
  for (FittedPrimitive& p : f.primitives) {
    p.origin *= factor;
    p.radius *= factor;
    p.major_radius *= factor;
  }
  for (double* length : {&f.size, &f.chord, &f.deviation}) *length *= factor;
}

bool has_only_primitives(const std::vector<CadPart>& parts) {
  for (const CadPart& part : parts)
    for (const CadFace& face : part.faces)
      if (primitive_of(face.face).kind == FittedPrimitive::Kind::Free) return false;
  return true;
}

/// Recognises the primitives of the faces with triangles, in the order of their triangles.
void recognise_primitives(const std::vector<CadPart>& parts, CadFacets& facets) {
  for (const CadPart& part : parts)
    for (const CadFace& face : part.faces) {
      TopLoc_Location location;
      const Handle(Poly_Triangulation) mesh = BRep_Tool::Triangulation(face.face, location);
      if (mesh.IsNull() || mesh->NbTriangles() == 0) continue;
      facets.primitives.push_back(primitive_of(face.face));
      facets.swept.push_back(is_swept(face.face));
    }
}

/// Meshes a file that was read in this process, in millimetres.
CadFacets tessellate_file(const std::filesystem::path& file, const CadFile& cad, double chord,
                          const CadFacetOptions& options) {
  const bool curved = options.curved;
  const JoinedParts joined = joined_parts(cad);
  int faces = 0;
  for (const CadPart& part : joined.parts) faces += isize(part.faces);
  if (faces == 0)
    throw InputError(file.string() + ": found " + cad.found +
                     " and no face, expected at least one face");
  if (chord != 0 && !(chord >= 1e-7 * joined.size))
    throw InputError(
        file.string() + ": found a chord of " + format_number(chord) +
        " mm, expected 1e-7 of the size or more: " + format_number(1e-7 * joined.size) + " mm");
  if (curved && options.coarse_primitives && has_only_primitives(joined.parts))
    chord = std::max(chord, 1e-3 * joined.size);
  CadFacets facets = mesh_parts(joined.parts, joined.size, chord, curved);
  if (curved) recognise_primitives(joined.parts, facets);
  facets.contents = contents_of(cad);
  return facets;
}

}  // namespace

CadFacets tessellate_cad(const std::filesystem::path& file, const CadFacetOptions& options) {
  CadFacets facets = facets_from_bytes(sandboxed_read(
      file, "OpenCASCADE",
      [&] {
        const CadFile cad = read_cad_here(file);
        const OccSettings occ;
        const double unit =
            options.unit_in_metres > 0 ? options.unit_in_metres : cad.header.unit_in_metres;
        try {
          return to_bytes(tessellate_file(file, cad, options.chord * unit / 1e-3, options));
        } catch (const Standard_Failure& failure) {
          throw InputError(file.string() +
                           ": OpenCASCADE cannot mesh this file: " + failure.GetMessageString());
        }
      },
      20));
  facets.unit_in_metres =
      options.unit_in_metres > 0 ? options.unit_in_metres : facets.contents.unit_in_metres;
  scale(facets, 1e-3 / facets.unit_in_metres);
  return facets;
}

CadContents read_cad_contents(const std::filesystem::path& file) {
  return contents_from_bytes(sandboxed_read(file, "OpenCASCADE", [&] {
    const CadFile cad = read_cad_here(file);
    const OccSettings occ;
    try {
      return to_bytes(contents_of(cad));
    } catch (const Standard_Failure& failure) {
      throw InputError(file.string() +
                       ": OpenCASCADE cannot measure this file: " + failure.GetMessageString());
    }
  }));
}

namespace {

std::string format_text(const CadHeader& header) {
  if (header.format == CadFormat::Iges) return "IGES";
  if (header.format == CadFormat::Brep) return "BREP";
  if (header.format == CadFormat::Patches) return "patches";
  const auto has = [&](const char* name) { return header.schema.find(name) != std::string::npos; };
  return has("AP242") || has("MANAGED_MODEL_BASED_3D") ? "STEP AP242"
         : has("AUTOMOTIVE_DESIGN")                    ? "STEP AP214"
         : has("CONFIG_CONTROL_DESIGN")                ? "STEP AP203"
                                                       : "STEP " + header.schema;
}

void count(std::vector<CadAttribute>& uses, const std::string& name, int CadAttribute::*what) {
  if (name.empty()) return;
  auto at = std::find_if(uses.begin(), uses.end(),
                         [&](const CadAttribute& use) { return use.name == name; });
  if (at == uses.end()) at = uses.insert(at, CadAttribute{name});
  ++((*at).*what);
}

void measure(const CadPart& part, CadContents& c) {
  GProp_GProps area, volume;
  BRepGProp::SurfaceProperties(part.shape, area, 1e-6);
  c.area += area.Mass();
  TopTools_IndexedMapOfShape solids, shells, edges;
  TopExp::MapShapes(part.shape, TopAbs_SOLID, solids);
  TopExp::MapShapes(part.shape, TopAbs_SHELL, shells);
  TopExp::MapShapes(part.shape, TopAbs_EDGE, edges);
  for (int s = 1; s <= solids.Extent(); ++s) {
    BRepGProp::VolumeProperties(solids(s), volume);
    c.volume += std::abs(volume.Mass());
  }
  for (int e = 1; e <= edges.Extent(); ++e) {
    GProp_GProps length;
    BRepGProp::LinearProperties(edges(e), length);
    c.trim_uncertainty_area += length.Mass() * BRep_Tool::Tolerance(TopoDS::Edge(edges(e)));
  }
  c.solids += solids.Extent();
  c.shells += shells.Extent();
  c.edges += edges.Extent();
  for (int s = 1; s <= shells.Extent(); ++s) c.closed_shells += free_edges_of(shells(s)).IsEmpty();
}

}  // namespace

CadContents contents_of(const CadFile& cad) {
  CadContents c;
  c.format = format_text(cad.header);
  c.unit_in_metres = cad.header.unit_in_metres;
  c.unit_stated = cad.header.unit_stated;
  if (!cad.header.note.empty()) c.notes.push_back(cad.header.note);
  CadTree tree = tree_of(cad.document);
  for (const CadPart& part : tree.parts) {
    measure(part, c);
    c.faces += static_cast<int>(part.faces.size());
    c.curves += static_cast<int>(part.curves.size());
    for (const CadBody& body : part.bodies) count(c.names, body.name, &CadAttribute::solids);
    for (const CadFace& face : part.faces) {
      count(c.names, face.name, &CadAttribute::faces);
      count(c.colours, face.colour, &CadAttribute::faces);
    }
    for (const CadCurveItem& curve : part.curves) {
      count(c.names, curve.name, &CadAttribute::curves);
      count(c.colours, curve.colour, &CadAttribute::curves);
    }
    for (const CadCurveItem& edge : part.edges) {
      count(c.names, edge.name, &CadAttribute::edges);
      count(c.colours, edge.colour, &CadAttribute::edges);
    }
  }
  Bnd_Box box;
  BRepBndLib::AddOptimal(cad.shape, box, false, false);
  const double unit = 1e-3 / c.unit_in_metres;  // one millimetre in the file's unit
  c.size = box.IsVoid() ? 0 : std::sqrt(box.SquareExtent()) * unit;
  for (double* area : {&c.area, &c.trim_uncertainty_area}) *area *= unit * unit;
  c.volume *= unit * unit * unit;
  c.products = std::move(tree.products);
  for (CadProduct& product : c.products) product.translation *= unit;
  c.layers = std::move(tree.layers);
  return c;
}

}  // namespace batten

namespace Eigen {

void to_json(nlohmann::json& json, const Eigen::Vector3d& p) { json = {p.x(), p.y(), p.z()}; }
void from_json(const nlohmann::json& json, Eigen::Vector3d& p) {
  p = {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

}  // namespace Eigen

namespace batten {

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CadProduct, name, instance_name, level, assembly, translation,
                                   rotation_deg, colour, solids, faces, curves)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CadAttribute, name, products, solids, faces, edges, curves)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CadContents, format, unit_in_metres, unit_stated, notes,
                                   products, names, colours, layers, solids, shells, faces, edges,
                                   closed_shells, curves, area, trim_uncertainty_area, volume, size)

std::string to_bytes(const CadContents& contents) {
  // Names in damaged files may be invalid UTF-8.
  return nlohmann::json(contents).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

CadContents contents_from_bytes(const std::string& bytes) {
  try {
    return nlohmann::json::parse(bytes).get<CadContents>();
  } catch (const nlohmann::json::exception&) {  // JSON stores non-finite numbers as null
    throw InputError("OpenCASCADE measures sizes that are not finite");
  }
}

}  // namespace batten
