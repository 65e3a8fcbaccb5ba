// The kinds of CAD files, and whether one is whole. Internal; needs no OpenCASCADE.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace batten {

/// The formats of CAD files.
enum class CadFormat { Step, Iges, Brep, Patches };

/// Endings of CAD files, with their dots.
const std::vector<std::string>& cad_extensions();

/// The format that a file's ending says. Throws InputError for another ending.
CadFormat cad_format(const std::filesystem::path& file);

/// Whether the bytes of a BREP file are its binary form.
bool is_binary_brep(const std::string& bytes);

/// Throws InputError, with the line (of binary files the byte), for a file that is not of this
/// format or is cut short where its text shows that: OpenCASCADE reads what it can of one, and says
/// nothing. O(size).
void check_cad_text(const std::filesystem::path& file, CadFormat format);

}  // namespace batten
