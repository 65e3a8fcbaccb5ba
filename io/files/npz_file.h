// SPDX-License-Identifier: MPL-2.0
// Arrays in a file that numpy.load() reads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace batten {

/// An archive of NumPy arrays (.npz): a ZIP file of .npy files, version 1.0, as numpy.savez() writes
/// it.
class NpzFile {
 public:
  /// Adds an array of 64-bit floating-point numbers, in C order. Throws std::logic_error unless the
  /// number of values is the product of the shape.
  void add(const std::string& name, const std::vector<std::size_t>& shape,
           const std::vector<double>& values);
  /// Adds a one-dimensional array of 64-bit integers.
  void add(const std::string& name, const std::vector<std::int64_t>& values);
  /// Adds a one-dimensional array of texts (UTF-8; numbers and names).
  void add(const std::string& name, const std::vector<std::string>& texts);

  /// Writes the archive. Throws FileError if that fails.
  void write(const std::filesystem::path& path) const;

 private:
  std::vector<std::pair<std::string, std::string>> arrays_;  // name and contents of each .npy file
};

}  // namespace batten
