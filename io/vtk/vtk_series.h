// Writes series of VTK files: one shape for each value of a parameter, or for each moment.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace batten {

/// One file of a series and the number that it stands for, which ParaView shows as its time.
struct SeriesFile {
  double value = 0;
  std::string file;  ///< path relative to the .pvd file
};

/// Writes a .pvd file, by which ParaView opens and plays the whole series. Values have all their
/// digits. The file appears whole or not at all. Throws InputError: no files, values that are not
/// finite or do not ascend or descend strictly (ParaView would merge or reorder them), a file that
/// cannot be written.
void write_pvd(const std::filesystem::path& path, const std::vector<SeriesFile>& files);

}  // namespace batten
