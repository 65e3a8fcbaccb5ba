// Recognises CAD file formats and detects truncated files. Internal; does not need OpenCASCADE.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace batten {

/// CAD file formats. `Patches`: spline patches of G+Smo (.xml), which are only read.
enum class CadFormat { Step, Iges, Brep, Patches };

/// File extensions of CAD files, with the dot.
const std::vector<std::string>& cad_extensions();

/// The format that corresponds to the file's extension. Throws InputError for an unknown extension.
CadFormat cad_format(const std::filesystem::path& file);

/// True if the content of a BREP file is in the binary form.
bool is_binary_brep(const std::string& bytes);

/// Checks that a file has the given format and is complete, as far as its text shows. Throws
/// InputError with the line (for binary files: the byte). This check is needed because OpenCASCADE
/// silently reads the intact part of a truncated file. O(file size).
void check_cad_text(const std::filesystem::path& file, CadFormat format);

}  // namespace batten
