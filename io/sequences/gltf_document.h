// The data of a glTF 2.0 file: its JSON, its buffers, and numbers read from them. Internal.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "batten/core/eigen.h"

namespace batten {

/// A .gltf with its buffers (files beside it, data URIs) or a .glb. All functions throw InputError
/// that names the file and what is wrong in it; none believes a number of the file.
class GltfDocument {
 public:
  using Json = nlohmann::json;

  /// Throws also for a required extension that changes geometry and is not known.
  explicit GltfDocument(const std::filesystem::path& path);

  const Json& root() const { return root_; }
  /// How many things of a kind there are: "nodes".
  int count(const char* kind) const;
  /// Thing `index` of a kind, an object.
  const Json& item(const char* kind, long index) const;
  /// The member `key` of an object as a whole number; `fallback` where it is missing.
  long integer(const Json& object, const char* key, long fallback) const;
  /// The same, which has to be there. `what` is said in messages: "accessor 3".
  long integer(const Json& object, const char* key, const std::string& what) const;
  /// The member `key` as the number of a thing; -1 where it is missing.
  int index(const Json& object, const char* key) const;
  /// The member `key` as a list of as many numbers as `fallback` has, or `fallback` where it is
  /// missing.
  VecX numbers(const Json& object, const char* key, const VecX& fallback) const;
  /// The member `key` as a list of indices; empty where it is missing.
  std::vector<int> indices(const Json& object, const char* key) const;
  std::string text(const Json& object, const char* key, const std::string& fallback) const;

  /// The elements of an accessor, one in each row; numbers that are normalized as fractions.
  /// `components`: of each element, as it is expected.
  MatX accessor(long index, int components) const;

  [[noreturn]] void fail(const std::string& message) const;

 private:
  struct Slice {
    const char* begin = nullptr;
    size_t size = 0, stride = 0;
  };
  void read_glb(const std::string& bytes);
  void read_buffers();
  std::string buffer_bytes(const Json& buffer, const std::string& what) const;
  void require_extensions() const;
  Slice view(long index) const;
  /// Reads `count` elements behind each other in a view into rows of `into`.
  void read_elements(const Slice& slice, size_t offset, long type, bool normalized,
                     Eigen::Ref<MatX> into, const std::string& what) const;
  void read_sparse(const Json& sparse, long type, bool normalized, MatX& into,
                   const std::string& what) const;

  std::filesystem::path path_;
  Json root_;
  std::vector<std::string> buffers_;
  std::string binary_;  // of a GLB
  bool has_binary_ = false;
};

}  // namespace batten
