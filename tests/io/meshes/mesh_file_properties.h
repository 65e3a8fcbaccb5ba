// SPDX-License-Identifier: MPL-2.0
// Properties of every mesh file, in any format.
#pragma once

#include <cstdio>
#include <functional>
#include <map>
#include <random>
#include <sstream>

#include "batten/core/errors.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/tests/support/catch.h"
#include "batten/tests/support/test_data.h"

namespace batten_test {
using namespace batten;

inline std::filesystem::path mesh_scratch() {
  static const std::filesystem::path folder = scratch("mesh_files");
  return folder;
}

inline std::filesystem::path file_with(const std::string& name, const std::string& bytes) {
  const auto path = mesh_scratch() / name;
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

inline std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

inline std::string with_carriage_returns(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '\n' ? std::string("\r\n") : std::string(1, c);
  return result;
}

inline std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// The message after the file's name.
inline std::string read_error(const std::string& name, const std::string& bytes) {
  const auto path = file_with(name, bytes);
  try {
    MeshFile::read(path);
  } catch (const InputError& error) {
    const std::string message = error.what();
    REQUIRE(message.starts_with(path.string() + ":"));
    return message.substr(path.string().size() + 1);
  }
  return "no mistake";
}

/// Unchanged points give the same bytes.
inline void check_identity(const std::filesystem::path& path) {
  const MeshFile file = MeshFile::read(path);
  const auto copy = mesh_scratch() / ("copy_of_" + path.filename().string());
  const auto rounding = file.write(copy, file.shells().points);
  CHECK(rounding.largest == 0);
  CHECK(rounding.max_error_label == -1);
  INFO(path.string());
  CHECK((bytes_of(copy) == bytes_of(path)));
}

/// Moves every third node by numbers with all their digits.
inline Points moved(const MeshFile& file, double amount = 1.0 / 3, int every = 3) {
  Points points = file.shells().points;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> by(-amount, amount);
  for (Eigen::Index i = 0; i < points.rows(); i += every)
    for (int c = 0; c < 3; ++c) points(i, c) += by(random);
  return points;
}

inline bool same_faces(const ShellMesh& a, const ShellMesh& b) {
  if (a.face_count() != b.face_count()) return false;
  for (int f = 0; f < a.face_count(); ++f) {
    const auto x = a.face(f), y = b.face(f);
    if (a.second_order(f) != b.second_order(f) ||
        !std::equal(x.begin(), x.end(), y.begin(), y.end()))
      return false;
  }
  return true;
}

/// Writes other points and reads them back: they are the given ones up to the reported rounding,
/// which is attained where it is reported. Returns the written file.
inline std::filesystem::path check_round_trip(const std::filesystem::path& path,
                                              const Points& points, double most_rounding,
                                              const MeshWriteOptions& options = {}) {
  const MeshFile file = MeshFile::read(path);
  const auto target = mesh_scratch() / ("moved_" + path.filename().string());
  const auto rounding = file.write(target, points, options);
  const MeshFile again = MeshFile::read(target);
  INFO(path.string());
  REQUIRE(again.shells().node_count() == file.shells().node_count());
  CHECK(same_faces(again.shells(), file.shells()));
  const Points error = (again.shells().points - points).cwiseAbs();
  CHECK(error.maxCoeff() == rounding.largest);
  CHECK(rounding.largest <= most_rounding);
  if (rounding.largest > 0) {
    const auto node = file.node_of_label(rounding.max_error_label);
    REQUIRE(node);
    CHECK(error.row(*node).maxCoeff() == rounding.largest);
  } else {
    CHECK(rounding.max_error_label == -1);
  }
  return target;
}

/// Damaged bytes give a result or an InputError, and a result can be written back unchanged.
inline void check_damage(const std::string& extension, const std::string& bytes, int times,
                         bool identical = true) {
  std::mt19937 random(11);
  const auto below = [&](size_t n) { return n == 0 ? 0 : random() % n; };
  const std::string replacements = "0123456789-+.,*$eE =\n\r\t/#&%xGQ\\";
  int read = 0;
  for (int i = 0; i < times; ++i) {
    std::string damaged = bytes;
    for (size_t hits = 1 + below(4); hits > 0 && !damaged.empty(); --hits) {
      const size_t at = below(damaged.size()),
                   length = std::min(1 + below(12), damaged.size() - at);
      switch (below(5)) {
        case 0:
          damaged.erase(at, length);
          break;
        case 1:
          damaged[at] = replacements[below(replacements.size())];
          break;
        case 2:
          damaged.insert(at, damaged.substr(below(damaged.size()), length));
          break;
        case 3:
          damaged[at] = static_cast<char>(below(256));
          break;
        default:
          if (below(8) == 0) damaged.resize(at);
      }
    }
    const auto path = file_with("damaged" + extension, damaged);
    try {
      const MeshFile file = MeshFile::read(path);
      ++read;
      const auto target = mesh_scratch() / ("rewritten" + extension);
      file.write(target, file.shells().points);
      if (identical && bytes_of(target) != damaged) {
        INFO(damaged);
        FAIL("unchanged points changed the file");
      }
      file.write(target, moved(file, 0.1, 1));
      (void)file.sets();
    } catch (const InputError&) {
    }
  }
  CHECK(read > 0);
}

/// Positions by node number from another program: lines "number x y z".
inline std::map<long, Vec3> positions_from(const std::string& command) {
  std::map<long, Vec3> positions;
  FILE* const pipe = popen(command.c_str(), "r");
  REQUIRE(pipe);
  long label = 0;
  double x = 0, y = 0, z = 0;
  while (std::fscanf(pipe, "%ld %lf %lf %lf", &label, &x, &y, &z) == 4)
    positions[label] = Vec3(x, y, z);
  pclose(pipe);
  return positions;
}

inline bool have_python_with(const std::string& module) {
  const std::string command = "/usr/bin/python3 -c 'import " + module + "' >/dev/null 2>&1";
  if (std::system(command.c_str()) == 0) return true;
  WARN("Python's " << module << " is not installed: files were written but not read by it");
  return false;
}

inline std::string other_reader(const std::string& program, const std::filesystem::path& file) {
  return "/usr/bin/python3 '" BATTEN_SOURCE_DIR "/tests/io/meshes/mesh_positions.py' " + program +
         " '" + file.string() + "'";
}

}  // namespace batten_test
