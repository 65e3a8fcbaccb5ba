// SPDX-License-Identifier: MPL-2.0
// Reads glTF 2.0 files: the JSON, the buffers, and numbers from accessors.
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// A .gltf file with its buffers (separate files or data URIs), or a .glb file. All functions throw
/// InputError that names the file and the defect. Every count, offset and index of the file is
/// validated.
class GltfDocument {
 public:
  using Json = nlohmann::json;

  /// Also throws for an unknown required extension that changes geometry.
  explicit GltfDocument(const std::filesystem::path& path);

  /// The JSON root object.
  const Json& root() const { return root_; }
  /// Number of objects of a kind, such as "nodes".
  int count(const char* kind) const;
  /// Object `index` of a kind, such as "nodes".
  const Json& item(const char* kind, long index) const;
  /// The member `key` of an object as an integer; `fallback` if it is missing.
  long integer(const Json& object, const char* key, long fallback) const;
  /// Like integer() above, but the member is mandatory. `what` names the object in messages:
  /// "accessor 3".
  long integer(const Json& object, const char* key, const std::string& what) const;
  /// The member `key` as an index; -1 if it is missing.
  int index(const Json& object, const char* key) const;
  /// The member `key` as a list of numbers of the same length as `fallback`; `fallback` if it is
  /// missing.
  VecX numbers(const Json& object, const char* key, const VecX& fallback) const;
  /// The member `key` as a list of indices; empty if it is missing.
  std::vector<int> indices(const Json& object, const char* key) const;
  /// The member `key` as a string; `fallback` if it is missing.
  std::string text(const Json& object, const char* key, const std::string& fallback) const;

  /// The elements of an accessor, one per row; normalized integers are converted to fractions.
  /// `components`: expected number of components per element.
  MatX accessor(long index, int components) const;
  /// Number of elements of an accessor. Throws InputError if its data have no room for them.
  long element_count(long index) const;
  /// Size of all buffers. A file that several buffers name counts once.
  size_t buffer_bytes() const { return buffer_bytes_; }

  /// Throws InputError that begins with the file name.
  [[noreturn]] void fail(const std::string& message) const;

 private:
  struct Slice {
    const char* begin = nullptr;
    size_t size = 0, stride = 0;
  };
  void read_glb(const std::string& bytes);
  void read_buffers();
  std::filesystem::path buffer_file(const std::string& uri, const std::string& what) const;
  std::string read_buffer(const Json& buffer, const std::string& what) const;
  void require_extensions() const;
  Slice view(long index) const;
  /// Reads `count` consecutive elements of a view into the rows of `into`.
  void read_elements(const Slice& slice, size_t offset, long type, bool normalized,
                     Eigen::Ref<MatX> into, const std::string& what) const;
  void read_sparse(const Json& sparse, long type, bool normalized, MatX& into,
                   const std::string& what) const;

  std::filesystem::path path_;
  Json root_;
  std::vector<std::shared_ptr<const std::string>> buffers_;
  size_t buffer_bytes_ = 0;
  std::string binary_;  // binary chunk of a GLB
  bool has_binary_ = false;
};

}  // namespace batten
