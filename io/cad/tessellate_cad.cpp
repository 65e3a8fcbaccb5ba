#include "batten/io/cad/tessellate_cad.h"

#include <Standard_Failure.hxx>
#include <cmath>
#include <cstring>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/io/cad/cad_contents_bytes.h"
#include "batten/io/cad/cad_mesher.h"
#include "batten/io/cad/measure_contents.h"
#include "batten/io/cad/occ_settings.h"
#include "batten/io/files/sandboxed_read.h"

namespace batten {
namespace {

// ---- out of a child process -----------------------------------------------------------------

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
    if (count > text_.size() - at_) throw Error("what a child process meshed is not whole");
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
  out.put(f.size).put(f.chord).put(f.deviation);
  out.put(f.shells).put(f.free_edges).put(f.cracks).put(f.unmeshed);
  return out.take();
}

CadFacets from_bytes(const std::string& bytes) {
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
  for (double* number : {&f.size, &f.chord, &f.deviation}) *number = in.get<double>();
  for (int* number : {&f.shells, &f.free_edges, &f.cracks, &f.unmeshed}) *number = in.get<int>();
  return f;
}

void scale(CadFacets& f, double factor) {
  f.mesh.points *= factor;
  for (double* length : {&f.size, &f.chord, &f.deviation}) *length *= factor;
}

/// In millimetres.
CadFacets tessellate_file(const std::filesystem::path& file, const CadFile& cad, double chord,
                          bool curved) {
  const JoinedParts joined = joined_parts(cad);
  int faces = 0;
  for (const CadPart& part : joined.parts) faces += isize(part.faces);
  if (faces == 0)
    throw InputError(file.string() + ": found " + cad.found +
                     " and no face, expected some to mesh");
  if (chord != 0 && !(chord >= 1e-7 * joined.size))
    throw InputError(
        file.string() + ": found a chord of " + format_number(chord) +
        " mm, expected 1e-7 of the size or more: " + format_number(1e-7 * joined.size) + " mm");
  CadFacets facets = mesh_parts(joined.parts, joined.size, chord, curved);
  facets.contents = contents_of(cad);
  return facets;
}

}  // namespace

CadFacets tessellate_cad(const std::filesystem::path& file, const CadFacetOptions& options) {
  CadFacets facets = from_bytes(sandboxed_read(
      file, "OpenCASCADE",
      [&] {
        const CadFile cad = read_cad_here(file);
        const OccSettings occ;
        const double unit =
            options.unit_in_metres > 0 ? options.unit_in_metres : cad.header.unit_in_metres;
        try {
          return to_bytes(tessellate_file(file, cad, options.chord * unit / 1e-3, options.curved));
        } catch (const Standard_Failure& failure) {
          throw InputError(file.string() +
                           ": OpenCASCADE cannot mesh it: " + failure.GetMessageString());
        }
      },
      20));
  facets.unit_in_metres =
      options.unit_in_metres > 0 ? options.unit_in_metres : facets.contents.unit_in_metres;
  scale(facets, 1e-3 / facets.unit_in_metres);
  return facets;
}

}  // namespace batten
