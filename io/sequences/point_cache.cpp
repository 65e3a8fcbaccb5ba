// SPDX-License-Identifier: MPL-2.0
// Reads point caches, PC2 and MDD: all positions of a mesh, frame after frame, in single precision.
// SequenceWriter writes them.
//
//   PC2  little-endian: "POINTCACHE2\0", int32 version = 1, int32 points, float start, float rate,
//        int32 frames; then x y z of each point, frame after frame
//   MDD  big-endian: int32 frames, int32 points, float time of each frame; then the same
#include <algorithm>
#include <cmath>
#include <fstream>
#include <optional>
#include <string_view>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/errors.h"
#include "batten/io/files/glb_file.h"
#include "batten/io/files/input_file.h"
#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/io/sequences/sequence_files.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kMagic{"POINTCACHE2\0", 12};

/// The file with the faces of a cache: the mesh with the same stem, else the first of the numbered
/// files that begin with its stem, else the only mesh of the folder.
fs::path mesh_beside(const fs::path& cache) {
  const std::string stem = cache.stem().string();
  std::vector<fs::path> meshes;
  std::error_code error;
  const fs::path folder = cache.has_parent_path() ? cache.parent_path() : fs::path(".");
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    if (MeshFile::can_read(entry->path()))
      meshes.push_back(cache.parent_path() / entry->path().filename());
  std::sort(meshes.begin(), meshes.end());
  for (const fs::path& mesh : meshes)
    if (mesh.stem() == stem) return mesh;
  std::optional<NumberedFile> first;
  for (const fs::path& mesh : meshes)
    for (const std::string between : {"", "_", "-", "."}) {
      const NumberedName name{mesh.parent_path(), stem + between, mesh.extension().string()};
      const auto number = name.number_of(mesh.filename().string());
      if (number && (!first || *number < first->number)) first = {mesh, *number};
    }
  if (first) return first->path;
  if (meshes.size() == 1) return meshes.front();
  throw InputError(cache.string() + ": found " + format_count(isize(meshes), "mesh file") +
                   " next to this point cache and none named " + stem +
                   ", expected a mesh with its faces");
}

struct CacheHeader {
  long points = 0, frames = 0;
  std::vector<double> times;
  std::uintmax_t first_byte = 0;
};

/// Reads the first `count` bytes of a file, or fewer if it is shorter.
std::string head_of(std::ifstream& in, size_t count) {
  std::string bytes(count, '\0');
  in.read(bytes.data(), static_cast<std::streamsize>(count));
  bytes.resize(static_cast<size_t>(in.gcount()));
  in.clear();
  return bytes;
}

void require_size(const fs::path& path, const CacheHeader& header, std::uintmax_t size) {
  // As a floating-point number, because the counts of a damaged file may overflow an integer.
  const double expected =
      static_cast<double>(header.first_byte) +
      12.0 * static_cast<double>(header.points) * static_cast<double>(header.frames);
  if (header.points < 1 || header.frames < 1)
    throw InputError(path.string() + ": found " + std::to_string(header.frames) + " frames of " +
                     std::to_string(header.points) + " points, expected at least one of each");
  constexpr double most_exact = 1e15;
  if (static_cast<double>(size) != expected)
    throw InputError(path.string() + ": found " + std::to_string(size) + " bytes, expected " +
                     (expected < most_exact ? std::to_string(static_cast<std::uintmax_t>(expected))
                                            : format_number(expected)) +
                     " for " + format_count(header.frames, "frame") + " of " +
                     format_count(header.points, "point"));
}

CacheHeader read_pc2_header(const fs::path& path, std::ifstream& in, std::uintmax_t size) {
  const std::string bytes = head_of(in, 32);
  if (!std::string_view(bytes).starts_with(kMagic.substr(0, std::min<size_t>(12, bytes.size()))) ||
      bytes.empty())
    throw InputError(path.string() + ": found " + quoted_excerpt(bytes.substr(0, 12)) +
                     ", expected 'POINTCACHE2'");
  if (bytes.size() < 32)
    throw InputError(path.string() + ": found " + std::to_string(bytes.size()) +
                     " bytes, expected 32 of a header and the frames");
  const auto integer = [&](size_t at) {
    return static_cast<long>(static_cast<std::int32_t>(load_unsigned<std::uint32_t>(&bytes[at])));
  };
  if (integer(12) != 1)
    throw InputError(path.string() + ": found version " + std::to_string(integer(12)) +
                     " of POINTCACHE2, expected 1");
  CacheHeader header{integer(16), integer(28), {}, 32};
  require_size(path, header, size);
  const double start = load_float32(&bytes[20]), rate = load_float32(&bytes[24]);
  if (!std::isfinite(start) || !std::isfinite(rate) || (header.frames > 1 && !(rate > 0)))
    throw InputError(path.string() + ": found the start " + format_number(start) +
                     " and the rate " + format_number(rate) + ", expected a rate above 0");
  for (long k = 0; k < header.frames; ++k)
    header.times.push_back(start + static_cast<double>(k) * rate);
  return header;
}

CacheHeader read_mdd_header(const fs::path& path, std::ifstream& in, std::uintmax_t size) {
  std::string bytes = head_of(in, 8);
  if (bytes.size() < 8)
    throw InputError(path.string() + ": found " + std::to_string(bytes.size()) +
                     " bytes, expected 8 of a header, times and frames");
  const auto integer = [&](size_t at) {
    return static_cast<long>(
        static_cast<std::int32_t>(load_unsigned<std::uint32_t>(&bytes[at], true)));
  };
  CacheHeader header{integer(4), integer(0), {}, 0};
  header.first_byte = 8 + 4 * static_cast<std::uintmax_t>(std::max(header.frames, 0L));
  require_size(path, header, size);
  bytes = head_of(in, static_cast<size_t>(header.frames) * 4);
  if (bytes.size() < static_cast<size_t>(header.frames) * 4)
    throw InputError(path.string() + ": the times of the frames cannot be read");
  for (long k = 0; k < header.frames; ++k)
    header.times.push_back(load_float32(&bytes[static_cast<size_t>(4 * k)], true));
  return header;
}

MeshSequence read_cache(const fs::path& path, bool is_mdd, const SequenceOptions& options,
                        const Progress& progress) {
  require_input_file(path, "a point cache");
  progress.update("reading frames", 0);
  std::ifstream in(path, std::ios::binary);
  const CacheHeader header =
      (is_mdd ? read_mdd_header : read_pc2_header)(path, in, input_file_size(path));
  const FrameRange range = frame_range(options, header.frames, path.string());
  const fs::path mesh = options.mesh.empty() ? mesh_beside(path) : options.mesh;
  MeshSequence sequence;
  sequence.shells = MeshFile::read(mesh).shells();
  if (sequence.node_count() != header.points)
    throw InputError(path.string() + ": found " + format_count(header.points, "point") +
                     " in each frame, expected " + std::to_string(sequence.node_count()) +
                     " as the mesh " + mesh.string() + " has nodes");
  const size_t bytes_a_frame = static_cast<size_t>(header.points) * 12;
  in.seekg(static_cast<std::streamoff>(header.first_byte +
                                       static_cast<std::uintmax_t>(range.first) * bytes_a_frame));
  for (int k = 0; k < range.count; ++k) {
    progress.update("reading frames", static_cast<double>(k) / range.count);
    const std::string bytes = head_of(in, bytes_a_frame);
    if (bytes.size() < bytes_a_frame)
      throw InputError(path.string() + ": frame " + std::to_string(range.first + k + 1) +
                       " cannot be read");
    Points& points = sequence.frames.emplace_back(header.points, 3);
    for (Eigen::Index i = 0; i < points.rows(); ++i)
      for (Eigen::Index c = 0; c < 3; ++c)
        points(i, c) = load_float32(&bytes[static_cast<size_t>(12 * i + 4 * c)], is_mdd);
    for (Eigen::Index i = 0; i < points.rows(); ++i)
      if (!points.row(i).allFinite())
        throw InputError(path.string() + ": frame " + std::to_string(range.first + k + 1) +
                         ": a coordinate of point " + std::to_string(i) + " is not finite");
    sequence.times.push_back(header.times[static_cast<size_t>(range.first + k)]);
  }
  return sequence;
}

}  // namespace

MeshSequence read_pc2_sequence(const fs::path& path, const SequenceOptions& options,
                               const Progress& progress) {
  return read_cache(path, false, options, progress);
}

MeshSequence read_mdd_sequence(const fs::path& path, const SequenceOptions& options,
                               const Progress& progress) {
  return read_cache(path, true, options, progress);
}

}  // namespace batten
