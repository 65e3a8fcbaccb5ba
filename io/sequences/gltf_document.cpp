// SPDX-License-Identifier: MPL-2.0
#include "batten/io/sequences/gltf_document.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/glb_file.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/toml_table.h"

namespace batten {
namespace {

constexpr long kMostThings = 1000000000;
/// Numbers that an accessor without data (or with sparse data only) may have in addition to one per
/// byte of the buffers. They are zero.
constexpr size_t kMostZeros = 1UL << 20;

/// Size of a component type in bytes; 0 for an unknown type.
size_t size_of_type(long type) {
  switch (type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      return 0;
  }
}

double load_number(const char* bytes, long type, bool normalized) {
  const auto fraction = [&](double value, double largest) {
    return normalized ? std::max(value / largest, -1.0) : value;
  };
  switch (type) {
    case 5120:
      return fraction(static_cast<signed char>(*bytes), 127);
    case 5121:
      return fraction(static_cast<unsigned char>(*bytes), 255);
    case 5122:
      return fraction(static_cast<std::int16_t>(load_unsigned<std::uint16_t>(bytes)), 32767);
    case 5123:
      return fraction(load_unsigned<std::uint16_t>(bytes), 65535);
    case 5125:
      return load_unsigned<std::uint32_t>(bytes);
    default:
      return load_float32(bytes);
  }
}

/// Number of components of an element type; 0 for an unknown type.
int components_of(const std::string& type) {
  return type == "SCALAR"                   ? 1
         : type == "VEC2"                   ? 2
         : type == "VEC3"                   ? 3
         : type == "VEC4" || type == "MAT2" ? 4
         : type == "MAT3"                   ? 9
         : type == "MAT4"                   ? 16
                                            : 0;
}

int hex_digit(char c) {
  const std::string digits = "0123456789abcdef";
  const size_t at = digits.find(static_cast<char>(std::tolower(static_cast<unsigned char>(c))));
  return at == digits.npos ? -1 : static_cast<int>(at);
}

/// Decodes percent-encoded characters such as %20.
std::string decoded_uri(const std::string& uri) {
  std::string text;
  for (size_t i = 0; i < uri.size(); ++i) {
    const int high = uri[i] == '%' && i + 2 < uri.size() ? hex_digit(uri[i + 1]) : -1;
    const int low = high >= 0 ? hex_digit(uri[i + 2]) : -1;
    if (low >= 0) i += 2;
    text += low >= 0 ? static_cast<char>(16 * high + low) : uri[i];
  }
  return text;
}

/// True for an absolute uri, such as "file:///data.bin" or "https://host/data.bin".
bool has_scheme(const std::string& uri) {
  const size_t colon = uri.find(':');
  return colon != uri.npos && uri.find_first_of("/?#") > colon;
}

/// Decodes base64; empty if the text is invalid.
std::optional<std::string> decoded_base64(std::string_view text) {
  static constexpr std::string_view letters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  while (text.ends_with('=')) text.remove_suffix(1);
  std::array<int, 256> values;
  values.fill(-1);
  for (size_t i = 0; i < letters.size(); ++i)
    values[static_cast<unsigned char>(letters[i])] = static_cast<int>(i);
  std::string bytes;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const int value = values[static_cast<unsigned char>(c)];
    if (value < 0) return {};
    bits = bits << 6 | static_cast<std::uint32_t>(value);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count & 255);
  }
  return bytes;
}

/// Extensions that are supported, or affect only colours and lighting.
bool harmless(const std::string& extension) {
  return extension.starts_with("KHR_materials_") || extension.starts_with("KHR_texture_") ||
         extension.starts_with("EXT_texture_") || extension == "KHR_lights_punctual" ||
         extension == "KHR_mesh_quantization" || extension == "KHR_xmp_json_ld";
}

}  // namespace

GltfDocument::GltfDocument(const std::filesystem::path& path) : path_(path) {
  std::string bytes = read_input_file(path, "a glTF scene");
  if (bytes.size() >= 4 && load_unsigned<std::uint32_t>(bytes.data()) == kGlbMagic) {
    read_glb(bytes);
  } else {
    check_nesting_depth(bytes, path.string());
    root_ = Json::parse(bytes, nullptr, false);
  }
  if (!root_.is_object()) fail("found no glTF, expected JSON text or a GLB");
  const std::string version =
      root_.contains("asset") ? text(root_["asset"], "version", "") : std::string();
  if (!version.starts_with("2."))
    fail("found version " + quoted_excerpt(version) + " of glTF, expected 2.0");
  require_extensions();
  read_buffers();
}

void GltfDocument::fail(const std::string& message) const {
  throw InputError(path_.string() + ": " + message);
}

void GltfDocument::read_glb(const std::string& bytes) {
  const auto uint32_at = [&](size_t at) { return load_unsigned<std::uint32_t>(&bytes[at]); };
  const std::string size = "found " + std::to_string(bytes.size()) + " bytes, expected ";
  if (bytes.size() < 20) fail(size + "20 of a GLB's head");
  if (uint32_at(4) != 2)
    fail("found version " + std::to_string(uint32_at(4)) + " of GLB, expected 2");
  if (uint32_at(8) != bytes.size())
    fail(size + std::to_string(uint32_at(8)) + " as the GLB's head says");
  for (size_t at = 12; at + 8 <= bytes.size();) {
    const size_t length = uint32_at(at), kind = uint32_at(at + 4);
    if (length > bytes.size() - at - 8)
      fail(size + std::to_string(at + 8 + length) + " for a part of " + std::to_string(length));
    if (at == 12) {
      if (kind != kJsonChunk) fail("found another chunk of the GLB first, expected its JSON chunk");
      const std::string_view json = std::string_view(bytes).substr(at + 8, length);
      check_nesting_depth(json, path_.string());
      root_ = Json::parse(json, nullptr, false);
    } else if (kind == kBinaryChunk && !has_binary_) {
      binary_ = bytes.substr(at + 8, length);
      has_binary_ = true;
    }
    at += 8 + (length + 3) / 4 * 4;
  }
}

void GltfDocument::require_extensions() const {
  if (!root_.contains("extensionsRequired")) return;
  for (const Json& extension : root_["extensionsRequired"])
    if (!extension.is_string() || !harmless(extension.get<std::string>()))
      fail("this scene needs the extension " +
           (extension.is_string() ? extension.get<std::string>() : "?") +
           ", which is not supported: export it without");
}

void GltfDocument::read_buffers() {
  std::map<std::string, std::shared_ptr<const std::string>> read;  // by uri
  for (int b = 0; b < count("buffers"); ++b) {
    const std::string what = "buffer " + std::to_string(b);
    const Json& buffer = item("buffers", b);
    const long length = integer(buffer, "byteLength", what);
    const bool is_binary_chunk = !buffer.contains("uri") && b == 0 && has_binary_;
    const std::string uri = text(buffer, "uri", "");
    std::shared_ptr<const std::string>& bytes = read[uri];
    if (!bytes || uri.empty()) {
      bytes = std::make_shared<const std::string>(is_binary_chunk ? std::move(binary_)
                                                                  : read_buffer(buffer, what));
      buffer_bytes_ += bytes->size();
    }
    if (length < 0 || bytes->size() < static_cast<size_t>(length))
      fail("found " + std::to_string(bytes->size()) + " bytes in " + what + ", expected " +
           std::to_string(length));
    buffers_.push_back(bytes);
  }
}

/// The file that a uri names. A scene may come from anywhere, so it names only files of its own
/// folder and below: links are followed before this is checked.
std::filesystem::path GltfDocument::buffer_file(const std::string& uri,
                                                const std::string& what) const {
  namespace fs = std::filesystem;
  const fs::path named = decoded_uri(uri),
                 own = path_.has_parent_path() ? path_.parent_path() : ".";
  const bool outside =
      has_scheme(uri) || named.is_absolute() || named.native().find('\0') != std::string::npos;
  std::error_code error;
  const fs::path folder = fs::weakly_canonical(own, error),
                 file = fs::weakly_canonical(own / named, error);
  const auto [end, inside] = std::mismatch(folder.begin(), folder.end(), file.begin(), file.end());
  if (outside || error || end != folder.end())
    fail("found the uri " + quoted_excerpt(uri) + " of " + what +
         ", expected a file in the folder of this scene or below it");
  return own / named;
}

std::string GltfDocument::read_buffer(const Json& buffer, const std::string& what) const {
  const std::string uri = text(buffer, "uri", "");
  if (uri.empty()) fail("found no data for " + what + ", expected a uri");
  if (!uri.starts_with("data:"))
    return read_input_file(buffer_file(uri, what), "the data of " + what, path_.string() + ": ");
  const size_t comma = uri.find(',');
  const bool base64 = comma != uri.npos && uri.substr(0, comma).ends_with(";base64");
  auto bytes = base64 ? decoded_base64(std::string_view(uri).substr(comma + 1)) : std::nullopt;
  if (!bytes) fail("found a data uri of " + what + " that cannot be read, expected base64");
  return std::move(*bytes);
}

int GltfDocument::count(const char* kind) const {
  const auto list = root_.find(kind);
  if (list == root_.end()) return 0;
  if (!list->is_array()) fail(std::string("found another kind of ") + kind + ", expected a list");
  return isize(*list);
}

const GltfDocument::Json& GltfDocument::item(const char* kind, long index) const {
  if (index < 0 || index >= count(kind))
    fail("found the number " + std::to_string(index) + " for one of " +
         std::to_string(count(kind)) + " " + kind);
  const Json& found = root_[kind][static_cast<size_t>(index)];
  if (!found.is_object())
    fail(std::string("found another kind of value in ") + kind + ", expected {…}");
  return found;
}

long GltfDocument::integer(const Json& object, const char* key, long fallback) const {
  const auto found = object.find(key);
  if (found == object.end()) return fallback;
  // Some programs write integers as 3.0.
  const double value = found->is_number() ? found->get<double>() : NAN;
  if (!(std::abs(value) < 1e15) || value != std::floor(value))
    fail("found " + quoted_excerpt(found->dump()) + " as " + key + ", expected a whole number");
  return static_cast<long>(value);
}

long GltfDocument::integer(const Json& object, const char* key, const std::string& what) const {
  if (!object.is_object() || !object.contains(key))
    fail(std::string("found no ") + key + " in " + what + ", expected a whole number");
  return integer(object, key, 0);
}

int GltfDocument::index(const Json& object, const char* key) const {
  const long found = integer(object, key, -1L);
  if (found > kMostThings || (found < 0 && object.is_object() && object.contains(key)))
    fail("found " + std::to_string(found) + " as " + key + ", expected an index from 0");
  return static_cast<int>(found);
}

VecX GltfDocument::numbers(const Json& object, const char* key, const VecX& fallback) const {
  const auto found = object.find(key);
  if (found == object.end()) return fallback;
  VecX values(fallback.size());
  bool good = found->is_array() && isize(*found) == values.size();
  for (Eigen::Index i = 0; good && i < values.size(); ++i) {
    const Json& value = (*found)[static_cast<size_t>(i)];
    good = value.is_number() && std::isfinite(value.get<double>());
    if (good) values[i] = value.get<double>();
  }
  if (!good)
    fail("found " + quoted_excerpt(found->dump()) + " as " + key + ", expected " +
         std::to_string(values.size()) + " numbers");
  return values;
}

std::vector<int> GltfDocument::indices(const Json& object, const char* key) const {
  std::vector<int> result;
  const auto found = object.find(key);
  if (found == object.end()) return result;
  if (!found->is_array())
    fail("found " + quoted_excerpt(found->dump()) + " as " + key + ", expected a list");
  for (const Json& index : *found) {
    if (!index.is_number_integer() || index.get<double>() < 0 || index.get<double>() > kMostThings)
      fail("found " + quoted_excerpt(index.dump()) + " in " + key + ", expected an index from 0");
    result.push_back(index.get<int>());
  }
  return result;
}

std::string GltfDocument::text(const Json& object, const char* key,
                               const std::string& fallback) const {
  if (!object.is_object() || !object.contains(key)) return fallback;
  if (!object[key].is_string())
    fail("found " + quoted_excerpt(object[key].dump()) + " as " + key + ", expected a text");
  return object[key].get<std::string>();
}

GltfDocument::Slice GltfDocument::view(long index) const {
  const std::string what = "buffer view " + std::to_string(index);
  const Json& view = item("bufferViews", index);
  const long buffer = integer(view, "buffer", what), offset = integer(view, "byteOffset", 0L),
             length = integer(view, "byteLength", what), stride = integer(view, "byteStride", 0L);
  item("buffers", buffer);
  const std::string& bytes = *buffers_[static_cast<size_t>(buffer)];
  const auto size = static_cast<long>(bytes.size());
  if (offset < 0 || length < 0 || stride < 0 || offset > size || length > size - offset)
    fail(what + " ends at byte " + std::to_string(offset + length) + " of buffer " +
         std::to_string(buffer) + ", which has " + std::to_string(size));
  return {bytes.data() + offset, static_cast<size_t>(length), static_cast<size_t>(stride)};
}

void GltfDocument::read_elements(const Slice& slice, size_t offset, long type, bool normalized,
                                 Eigen::Ref<MatX> into, const std::string& what) const {
  const size_t bytes = size_of_type(type), element = bytes * static_cast<size_t>(into.cols()),
               stride = slice.stride > 0 ? slice.stride : element,
               count = static_cast<size_t>(into.rows());
  if (count == 0) return;
  if (stride < element)
    fail("found a stride of " + std::to_string(stride) + " bytes for " + what + ", expected " +
         std::to_string(element) + " or more");
  if (offset > slice.size || element > slice.size - offset ||
      (count - 1) > (slice.size - offset - element) / stride)
    fail(what + " ends at byte " + std::to_string(offset + (count - 1) * stride + element) +
         " of its buffer view, which has " + std::to_string(slice.size));
  for (size_t i = 0; i < count; ++i)
    for (Eigen::Index c = 0; c < into.cols(); ++c)
      into(static_cast<Eigen::Index>(i), c) = load_number(
          slice.begin + offset + i * stride + static_cast<size_t>(c) * bytes, type, normalized);
}

void GltfDocument::read_sparse(const Json& sparse, long type, bool normalized, MatX& into,
                               const std::string& what) const {
  const std::string part = "the sparse part of " + what;
  const long count = integer(sparse, "count", part);
  if (count < 0 || count > into.rows() || !sparse.contains("indices") || !sparse.contains("values"))
    fail("found " + part + " with another count than 0 to " + std::to_string(into.rows()) +
         ", or without indices or values");
  const auto offset_in = [&](const Json& object) {
    const long offset = integer(object, "byteOffset", 0L);
    if (offset < 0) fail("found a negative offset in " + part);
    return static_cast<size_t>(offset);
  };
  const Json &at = sparse["indices"], &with = sparse["values"];
  const long index_type = integer(at, "componentType", part);
  if (size_of_type(index_type) == 0) fail("found an unknown componentType in " + part);
  MatX rows(count, 1), values(count, into.cols());
  read_elements(view(integer(at, "bufferView", part)), offset_in(at), index_type, false, rows,
                part);
  read_elements(view(integer(with, "bufferView", part)), offset_in(with), type, normalized, values,
                part);
  for (long i = 0; i < count; ++i) {
    if (!(rows(i, 0) >= 0 && rows(i, 0) < static_cast<double>(into.rows())))
      fail("found the index " + format_number(rows(i, 0)) + " in " + part + ", expected 0 to " +
           std::to_string(into.rows() - 1));
    into.row(static_cast<Eigen::Index>(rows(i, 0))) = values.row(i);
  }
}

long GltfDocument::element_count(long number) const {
  const std::string what = "accessor " + std::to_string(number);
  const Json& accessor = item("accessors", number);
  const long count = integer(accessor, "count", what),
             type = integer(accessor, "componentType", what);
  const int from = index(accessor, "bufferView"),
            components = components_of(text(accessor, "type", ""));
  if (size_of_type(type) == 0)
    fail("found the componentType " + std::to_string(type) + " in " + what +
         ", expected 5120 to 5126");
  if (count < 0) fail("found a negative count in " + what);
  // Checked before memory is allocated for data that the file does not have.
  const size_t room =
      from < 0 ? (kMostZeros + buffer_bytes_) * size_of_type(type) : view(from).size;
  if (components > 0 &&
      static_cast<size_t>(count) > room / (size_of_type(type) * static_cast<size_t>(components)))
    fail(what + " has " + std::to_string(count) + " elements, more than there is room for in " +
         (from < 0 ? "any scene" : "the " + std::to_string(room) + " bytes of its buffer view"));
  return count;
}

MatX GltfDocument::accessor(long number, int components) const {
  const std::string what = "accessor " + std::to_string(number);
  const Json& accessor = item("accessors", number);
  const std::string shape = text(accessor, "type", "");
  if (components_of(shape) != components)
    fail("found " + quoted_excerpt(shape) + " elements in " + what + ", expected " +
         std::to_string(components) + " numbers in each");
  const long count = element_count(number), type = integer(accessor, "componentType", what),
             offset = integer(accessor, "byteOffset", 0L);
  if (offset < 0) fail("found a negative offset in " + what);
  const bool normalized = accessor.contains("normalized") && accessor["normalized"] == true;
  const int from = index(accessor, "bufferView");
  MatX values = MatX::Zero(count, components);
  if (from >= 0)
    read_elements(view(from), static_cast<size_t>(offset), type, normalized, values, what);
  if (accessor.contains("sparse")) read_sparse(accessor["sparse"], type, normalized, values, what);
  return values;
}

}  // namespace batten
