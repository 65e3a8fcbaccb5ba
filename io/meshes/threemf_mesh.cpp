// SPDX-License-Identifier: MPL-2.0
// Writes 3MF for 3D printing: one object whose triangles have materials.
#include <Model/COM/NMR_DLLInterfaces.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <ostream>
#include <string>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/meshes/mesh_content.h"

namespace batten {
namespace {

/// lib3mf writes six decimals: in millimetres, an error below one nanometre.
constexpr double kMillimetre = 1e-3;

/// Owning handle of a lib3mf object; releases it on destruction.
class Owned {
 public:
  Owned() = default;
  ~Owned() {
    if (object_) NMR::lib3mf_release(object_);
  }
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
  operator void**() const { return object_; }
  void*** address() { return &object_; }

 private:
  void** object_ = nullptr;
};

/// Receives the bytes of a file from lib3mf, which would end the program if it failed to write one.
class ByteSink {
 public:
  static std::uint32_t write(BYTE* data, std::uint32_t count, void* sink) noexcept {
    return static_cast<ByteSink*>(sink)->put(reinterpret_cast<const char*>(data), count) ? 0 : 1;
  }
  static std::uint32_t seek(std::uint64_t position, void* sink) noexcept {
    static_cast<ByteSink*>(sink)->position_ = position;
    return 0;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  bool put(const char* data, size_t count) noexcept {
    try {
      bytes_.resize(std::max(bytes_.size(), position_ + count));
    } catch (const std::exception&) {
      return false;
    }
    std::copy_n(data, count, bytes_.begin() + static_cast<std::ptrdiff_t>(position_));
    position_ += count;
    return true;
  }

  std::string bytes_;
  size_t position_ = 0;
};

class ThreeMfFile {
 public:
  explicit ThreeMfFile(const MeshOutput& output) : output_(output), file_(output.path) {
    demand(NMR::lib3mf_createmodel(model_.address()), nullptr);
    demand(NMR::lib3mf_model_setunit(model_, NMR::MODELUNIT_MILLIMETER), model_);
    demand(NMR::lib3mf_model_addmeshobject(model_, object_.address()), model_);
    add_geometry();
    if (!output.sets.empty()) add_materials();
    Owned item;
    demand(NMR::lib3mf_model_addbuilditem(model_, object_, nullptr, item.address()), model_);
    // Identifiers are hashes of the mesh, so the same mesh gives the same bytes.
    demand(NMR::lib3mf_object_setuuidutf8(object_, identifier(1).c_str()), object_);
    demand(NMR::lib3mf_builditem_setuuidutf8(item, identifier(2).c_str()), item);
    demand(NMR::lib3mf_model_setbuilduuidutf8(model_, identifier(3).c_str()), model_);
  }

  void write() {
    Owned writer;
    demand(NMR::lib3mf_model_querywriter(model_, "3mf", writer.address()), model_);
    ByteSink sink;
    demand(NMR::lib3mf_writer_writetocallback(writer, reinterpret_cast<void*>(&ByteSink::write),
                                              reinterpret_cast<void*>(&ByteSink::seek), &sink),
           writer);
    file_.write([&](std::ostream& out) { out << sink.bytes(); });
    file_.commit();
  }

 private:
  void demand(LIB3MFRESULT result, void** of) const {
    if (result == LIB3MF_OK) return;
    DWORD code = 0;
    LPCSTR why = nullptr;
    if (of) NMR::lib3mf_getlasterror(of, &code, &why);
    throw InputError(output_.path.string() +
                     ": lib3mf cannot write it: " + (why ? why : "no reason given"));
  }

  void add_geometry() {
    const ShellMesh& mesh = output_.mesh;
    std::vector<NMR::MODELMESHVERTEX> vertices(static_cast<size_t>(mesh.node_count()));
    const double factor = output_.unit_in_metres / kMillimetre;
    for (int i = 0; i < mesh.node_count(); ++i)
      for (int c = 0; c < 3; ++c) {
        const auto value = static_cast<float>(factor * mesh.points(i, c));
        if (!std::isfinite(value))
          throw InputError(output_.path.string() + ": a coordinate of node " + std::to_string(i) +
                           " is too large for single precision");
        vertices[i].m_fPosition[c] = value;
        mix(value);
      }
    std::vector<NMR::MODELMESHTRIANGLE> triangles;
    for (int f = 0; f < mesh.face_count(); ++f)
      for (const auto& [a, b, c] : triangles_of(mesh, f)) {
        if (a == b || b == c || c == a) continue;  // 3MF forbids degenerate triangles
        triangles.push_back(
            {{static_cast<DWORD>(a), static_cast<DWORD>(b), static_cast<DWORD>(c)}});
        faces_.push_back(f);
      }
    demand(NMR::lib3mf_meshobject_setgeometry(object_, vertices.data(),
                                              static_cast<DWORD>(vertices.size()), triangles.data(),
                                              static_cast<DWORD>(triangles.size())),
           object_);
    BOOL closed = false;
    demand(NMR::lib3mf_meshobject_ismanifoldandoriented(object_, &closed), object_);
    // 3MF models must be closed; open meshes are written as surfaces.
    demand(NMR::lib3mf_object_settype(
               object_, closed ? NMR::MODELOBJECTTYPE_MODEL : NMR::MODELOBJECTTYPE_SURFACE),
           object_);
  }

  /// Adds one material per set, and one for faces without a set.
  void add_materials() {
    Owned group;
    demand(NMR::lib3mf_model_addbasematerialgroup(model_, group.address()), model_);
    DWORD id = 0;
    demand(NMR::lib3mf_basematerial_getresourceid(group, &id), group);
    constexpr std::array grey{204, 204, 204};
    const auto add = [&](const std::string& name, const std::array<int, 3>& colour) {
      DWORD index = 0;
      const auto channel = [&](size_t c) { return static_cast<BYTE>(colour[c]); };
      demand(NMR::lib3mf_basematerial_addmaterialutf8(group, name.c_str(), channel(0), channel(1),
                                                      channel(2), &index),
             group);
      demand(NMR::lib3mf_basematerial_setdisplaycolorrgba(group, index, channel(0), channel(1),
                                                          channel(2), 255),
             group);
    };
    for (const MeshSet& set : output_.sets)
      add(set.name.empty() ? "none" : set.name, mesh_colour(set.colour).value_or(grey));
    add("none", grey);
    const std::vector<int> set = set_of_faces(output_.mesh, output_.sets);
    const auto without = static_cast<DWORD>(output_.sets.size());
    std::vector<DWORD> groups(faces_.size(), id), indices;
    for (const int f : faces_) indices.push_back(set[f] < 0 ? without : static_cast<DWORD>(set[f]));
    Owned triangles, whole;
    demand(NMR::lib3mf_meshobject_createpropertyhandler(object_, triangles.address()), object_);
    demand(
        NMR::lib3mf_propertyhandler_setbasematerialarray(triangles, groups.data(), indices.data()),
        triangles);
    demand(NMR::lib3mf_object_createdefaultpropertyhandler(object_, whole.address()), object_);
    demand(NMR::lib3mf_defaultpropertyhandler_setbasematerial(whole, id, without), whole);
  }

  void mix(float value) {
    constexpr std::uint64_t prime = 1099511628211u;
    hash_ = (hash_ ^ std::bit_cast<std::uint32_t>(value)) * prime;
  }
  std::string identifier(unsigned number) const {
    char text[37];
    std::snprintf(text, sizeof text, "%08x-%04x-8000-8000-%08x%04x",
                  static_cast<unsigned>(hash_ >> 32), static_cast<unsigned>(hash_ >> 16 & 0xffff),
                  static_cast<unsigned>(hash_ & 0xffffffff), number);
    return text;
  }

  const MeshOutput& output_;
  AtomicFile file_;
  Owned model_, object_;
  std::vector<int> faces_;  // face of each triangle
  std::uint64_t hash_ = 14695981039346656037u;
};

}  // namespace

void write_3mf_mesh(const MeshOutput& output) { ThreeMfFile(output).write(); }

}  // namespace batten
