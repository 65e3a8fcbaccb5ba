// SPDX-License-Identifier: MPL-2.0
// Damaged CAD files: an error from each reader every time, and no output.
#include <BinTools.hxx>

#include <random>

#include "batten/core/errors.h"
#include "batten/io/cad/cad_convert.h"
#include "batten/tests/io/cad/cad_files.h"
#include "batten/tests/support/error_message.h"

using namespace batten_test;

namespace {

std::string bytes_of(const fs::path& file) {
  std::ostringstream out;
  out << std::ifstream(file, std::ios::binary).rdbuf();
  return out.str();
}

/// A block with a hole in the format of the extension; ".brep binary" is BREP's binary format.
std::string sound_bytes(const fs::path& folder, const std::string& kind) {
  if (kind != ".brep binary")
    return bytes_of(written(folder / ("a" + kind), painted("block", drilled_block())));
  std::ostringstream out;
  BinTools::Write(drilled_block(), out);
  return out.str();
}

std::string ending_of(const std::string& kind) { return kind.substr(0, kind.find(' ')); }

/// Every reader rejects the file, with its name in the message.
void check_refused(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
  const fs::path out = file.parent_path() / "out.step";
  for (const std::string& message : {error_message([&] { read_cad_contents(file); }),
                                     error_message([&] { tessellate_cad(file); }),
                                     error_message([&] { convert_cad(file, out); })}) {
    CHECK(message.find(file.filename().string()) != std::string::npos);
  }
  CHECK_FALSE(fs::exists(out));
}

}  // namespace

TEST_CASE("CAD files that are cut short at fifty positions are refused", "[io][cad]") {
  const SandboxScope child;
  const fs::path folder = scratch("cad_cut");
  for (const std::string kind : {".step", ".iges", ".brep", ".brep binary"}) {
    const std::string whole = sound_bytes(folder, kind);
    for (size_t k = 0; k < 50; ++k) {
      const size_t length = whole.size() * k / 50;
      INFO(kind << " cut after " << length << " of " << whole.size());
      check_refused(folder / ("cut" + ending_of(kind)), whole.substr(0, length));
    }
  }
}

TEST_CASE("bytes at random, renamed text and impossible counts are refused as CAD", "[io][cad]") {
  const SandboxScope child;
  const fs::path folder = scratch("cad_random");
  std::mt19937 random(7);
  for (const std::string ending : {".step", ".stp", ".iges", ".igs", ".brep", ".brp"}) {
    INFO(ending);
    const fs::path file = folder / ("a" + ending);
    check_refused(file, "");
    check_refused(file, "solid a\nendsolid a\n");
    check_refused(file, "x,y,z\n0,0,0\n1,0,0\n");
    for (int k = 0; k < 5; ++k) {
      std::string bytes(2000, ' ');
      for (char& c : bytes) c = static_cast<char>(random());
      check_refused(file, bytes);
    }
  }
  const std::string brep = bytes_of(written(folder / "b.brep", painted("block", drilled_block())));
  for (const std::string section :
       {"Locations ", "Curve2ds ", "Curves ", "Surfaces ", "TShapes "}) {
    const size_t at = brep.find("\n" + section) + 1 + section.size();
    std::string huge = brep;
    huge.replace(at, brep.find('\n', at) - at, "2000000000");
    INFO(section);
    check_refused(folder / "huge.brep", huge);
  }
}

TEST_CASE("damaged bytes in valid CAD files are read or refused, and crash nothing", "[io][cad]") {
  const SandboxScope child;
  const fs::path folder = scratch("cad_damaged");
  std::mt19937 random(11);
  for (const std::string kind : {".step", ".iges", ".brep", ".brep binary"}) {
    const std::string whole = sound_bytes(folder, kind), ending = ending_of(kind);
    const bool binary = kind != ending;
    for (int k = 0; k < (binary ? 60 : 15); ++k) {
      std::string bytes = whole;
      for (int i = 0; i < 3; ++i)
        bytes[random() % bytes.size()] = static_cast<char>(binary ? random() : '0' + random() % 10);
      const fs::path file = folder / ("bad" + ending);
      std::ofstream(file, std::ios::binary) << bytes;
      try {
        const CadFacets facets = tessellate_cad(file);
        CHECK(facets.mesh.points.allFinite());
      } catch (const InputError& error) {
        CHECK(std::string(error.what()).find("bad" + ending) != std::string::npos);
      }
    }
  }
}
