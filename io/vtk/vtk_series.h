// Series of VTK files: one shape for each value of a parameter, or for each moment.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace batten {

/// One file of a series and the number that it stands for, which ParaView shows as its time.
struct SeriesFile {
  double value = 0;
  std::string file;  ///< relative to the series' own file
};

/// A .pvd file: ParaView opens the whole series by it and plays it. Values are written with all
/// their digits. Whole or not at all. Throws InputError: no files, values that are not finite or do
/// not ascend or descend strictly (ParaView would merge or reorder them), a file that cannot be
/// written.
void write_pvd(const std::filesystem::path& path, const std::vector<SeriesFile>& files);

}  // namespace batten
