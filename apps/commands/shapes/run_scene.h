// The work of `batten run`: everything a scene asks for.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "batten/io/report/report.h"

namespace batten {

/// A scene made of files of lines alone, for `batten skin`: outline files, inner files.
Scene scene_of_lines(const std::vector<std::filesystem::path>& outline,
                     const std::vector<std::filesystem::path>& inner, const std::string& unit);
/// The same for `batten skin --network`: all lines of all files are one network.
Scene scene_of_network(const std::vector<std::filesystem::path>& files, const std::string& unit);

/// Makes the shape, measures it and writes all files and report.json into the folder, all of them
/// or none. A result that misses a promise is written too, and says so in report.missed. Throws
/// InputError, ConflictError, NoSolutionError, CancelledError.
Report run_scene(const Scene& scene, const std::filesystem::path& folder,
                 const Progress& progress = {});

/// One picture of the scene's shape, without any other file. Throws as above; InputError when there
/// is no display.
void view_scene(const Scene& scene, const PictureScene& look, const std::filesystem::path& file,
                const Progress& progress = {});

/// What a newcomer wants to know, a dozen lines, ending with the files. Of a network: what was
/// found, repaired, skinned, left over, and what to say in the scene to have it otherwise.
std::string summary(const Report& report, const std::filesystem::path& folder);
std::string network_summary(const Report& report, const std::filesystem::path& folder);

}  // namespace batten
