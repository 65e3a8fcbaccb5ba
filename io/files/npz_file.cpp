// SPDX-License-Identifier: MPL-2.0
#include "batten/io/files/npz_file.h"

#include <zip.h>
#include <algorithm>
#include <bit>
#include <functional>
#include <memory>
#include <numeric>
#include <stdexcept>

#include "batten/io/files/atomic_file.h"

namespace batten {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are written as they are");

/// The header of a .npy file, padded to a multiple of 64 bytes.
std::string npy_header(const std::string& type, const std::vector<std::size_t>& shape) {
  std::string text = "{'descr': '" + type + "', 'fortran_order': False, 'shape': (";
  for (const std::size_t n : shape) text += std::to_string(n) + ",";
  text += "), }";
  constexpr std::size_t prefix = 10, alignment = 64;
  while ((prefix + text.size() + 1) % alignment != 0) text += ' ';
  text += '\n';
  std::string header("\x93NUMPY\x01\x00", 8);
  header += static_cast<char>(text.size() & 0xff);
  header += static_cast<char>(text.size() >> 8);
  return header + text;
}

template <class Value>
std::string bytes_of(const std::vector<Value>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value)};
}

/// Code points of a UTF-8 text; bytes that are not UTF-8 become U+FFFD.
std::vector<char32_t> code_points(const std::string& text) {
  std::vector<char32_t> points;
  for (std::size_t i = 0; i < text.size();) {
    const auto byte = static_cast<unsigned char>(text[i++]);
    const int more = byte < 0x80 ? 0 : byte < 0xe0 ? 1 : byte < 0xf0 ? 2 : 3;
    char32_t point = more == 0 ? byte : byte & (0x3f >> more);
    for (int k = 0; k < more && i < text.size(); ++k)
      point = point << 6 | (static_cast<unsigned char>(text[i++]) & 0x3f);
    points.push_back(byte >= 0x80 && byte < 0xc0 ? U'\ufffd' : point);
  }
  return points;
}

}  // namespace

void NpzFile::add(const std::string& name, const std::vector<std::size_t>& shape,
                  const std::vector<double>& values) {
  if (std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>()) !=
      values.size())
    throw std::logic_error("NpzFile: the shape of '" + name + "' does not fit its values");
  arrays_.emplace_back(name, npy_header("<f8", shape) + bytes_of(values));
}

void NpzFile::add(const std::string& name, const std::vector<std::int64_t>& values) {
  arrays_.emplace_back(name, npy_header("<i8", {values.size()}) + bytes_of(values));
}

void NpzFile::add(const std::string& name, const std::vector<std::string>& texts) {
  std::size_t longest = 1;
  std::vector<std::vector<char32_t>> all;
  for (const std::string& text : texts) {
    all.push_back(code_points(text));
    longest = std::max(longest, all.back().size());
  }
  std::string contents = npy_header("<U" + std::to_string(longest), {texts.size()});
  for (std::vector<char32_t>& text : all) {
    text.resize(longest);
    contents += bytes_of(text);
  }
  arrays_.emplace_back(name, std::move(contents));
}

void NpzFile::write(const std::filesystem::path& path) const {
  const auto fail = [&](const char* why) { throw FileError(path.string() + ": " + why); };
  int code = 0;
  const auto discard = [](zip_t* archive) { zip_discard(archive); };
  std::unique_ptr<zip_t, decltype(discard)> archive(
      zip_open(path.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code), discard);
  if (!archive) {
    zip_error_t error;
    zip_error_init_with_code(&error, code);
    const std::string why = zip_error_strerror(&error);
    zip_error_fini(&error);
    fail(why.c_str());
  }
  for (const auto& [name, contents] : arrays_) {
    zip_source_t* source = zip_source_buffer(archive.get(), contents.data(), contents.size(), 0);
    const zip_int64_t index =
        source ? zip_file_add(archive.get(), (name + ".npy").c_str(), source, ZIP_FL_ENC_UTF_8)
               : -1;
    if (index < 0) {
      if (source) zip_source_free(source);
      fail(zip_strerror(archive.get()));
    }
    zip_set_file_compression(archive.get(), static_cast<zip_uint64_t>(index), ZIP_CM_STORE, 0);
    zip_file_set_mtime(archive.get(), static_cast<zip_uint64_t>(index), 315532800, 0);  // 1980
  }
  if (zip_close(archive.get()) != 0) fail(zip_strerror(archive.get()));
  static_cast<void>(archive.release());
}

}  // namespace batten
