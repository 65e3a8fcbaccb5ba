// Names of numbered files such as walk_0001.obj, and series of them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace batten {

/// A file name with a placeholder for a number: "walk_*.obj", "walk_%04d.obj".
struct NumberedName {
  std::filesystem::path folder;
  std::string prefix, suffix;  ///< the name before and after the number
  int digits = 1;              ///< minimum number of digits, zero-padded

  /// The name as a pattern, with its folder.
  std::string pattern() const;
  /// The path of the file with this number.
  std::filesystem::path file(long number) const;
  /// The number in a file name; empty if the name does not match.
  std::optional<long> number_of(const std::string& file_name) const;
};

/// Parses a path with a placeholder *, %d, %4d or %04d; empty if it has none. In written names, *
/// stands for at least four digits. Throws InputError for several placeholders, one in the folder
/// part, or an invalid %.
std::optional<NumberedName> pattern_of(const std::filesystem::path& path);

/// A file of a series.
struct NumberedFile {
  std::filesystem::path path;
  long number = 0;
};

/// The files of a series, in ascending order. `path` is a pattern, a folder with a single series of
/// mesh files, or any file of the series. A file whose name has no number stands alone. `name`
/// receives the name of the series for messages. Throws InputError if there are no such files,
/// several series, or a duplicate number.
std::vector<NumberedFile> numbered_files(const std::filesystem::path& path, std::string& name);

/// Throws InputError if the stride of a series has gaps; the message lists the missing numbers.
void require_no_gaps(const std::vector<NumberedFile>& files, const std::string& name);

}  // namespace batten
