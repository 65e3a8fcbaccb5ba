// Names of numbered files. Internal.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace batten {

/// A file's name with a place for a number: "walk_*.obj", "walk_%04d.obj".
struct NumberedName {
  std::filesystem::path folder;
  std::string prefix, suffix;  ///< the name around the number
  int digits = 1;              ///< at least so many, with zeros in front

  /// The name as a pattern, with its folder.
  std::string pattern() const;
  std::filesystem::path file(long number) const;
  /// The number in a file's name; none when it is named otherwise.
  std::optional<long> number_of(const std::string& file_name) const;
};

/// The name that a path with * or %d, %4d, %04d stands for; none when it has neither. * stands for
/// four digits or more in names that are written. Throws InputError: several of them, one in the
/// folder's part, a bare %.
std::optional<NumberedName> pattern_of(const std::filesystem::path& path);

struct NumberedFile {
  std::filesystem::path path;
  long number = 0;
};

/// The files of a series, ascending: of a pattern, of a folder (the one series of mesh files in it),
/// of any of its files (alone where its name has no number). `name` receives what the series is
/// called in messages. Throws InputError: no such files, several series, a number twice.
std::vector<NumberedFile> numbered_files(const std::filesystem::path& path, std::string& name);

/// Throws InputError that names the numbers missing in the stride of a series.
void require_no_gaps(const std::vector<NumberedFile>& files, const std::string& name);

}  // namespace batten
