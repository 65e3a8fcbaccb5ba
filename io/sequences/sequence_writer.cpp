// SPDX-License-Identifier: MPL-2.0
#include "batten/io/sequences/sequence_writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <stdexcept>
#include <vector>

#include "batten/core/containers.h"
#include "batten/core/eigen.h"
#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/glb_file.h"
#include "batten/io/files/text.h"
#include "batten/io/meshes/mesh_content.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/io/sequences/sequence_files.h"
#include "batten/io/vtk/vtk_files.h"

namespace batten {

// Writes a deforming mesh as binary glTF 2.0 (GLB).

/// Writes one mesh: the first frame, and all other frames as morph targets, whose weights an
/// animation blends between the times. The JSON chunk precedes the data but contains the bounds of
/// all frames. Space for it is therefore reserved, and it is written last.
class GlbWriter {
 public:
  /// Throws InputError if the file would exceed 4 GB, and the exceptions of AtomicFile.
  GlbWriter(const std::filesystem::path& path, std::vector<std::array<int, 3>> triangles,
            int points, std::vector<double> times);
  /// Appends a frame. Throws InputError if a coordinate exceeds single precision.
  void write(const Points& points);
  void finish();

 private:
  struct Bounds {
    std::array<float, 3> low{}, high{};
  };
  std::string json(const std::vector<Bounds>& bounds) const;
  void put(const std::string& bytes);

  AtomicFile file_;
  size_t triangles_;
  int points_;
  std::vector<double> times_;
  std::ofstream out_;
  size_t json_room_ = 0, binary_size_ = 0;
  Points first_;  // rounded to single precision
  std::vector<Bounds> bounds_;
};

GlbWriter::GlbWriter(const std::filesystem::path& path, std::vector<std::array<int, 3>> triangles,
                     int points, std::vector<double> times)
    : file_(path),
      triangles_(triangles.size()),
      points_(points),
      times_(std::move(times)),
      out_(file_.temporary(), std::ios::binary) {
  // Numbers with the longest possible text determine the reserved size.
  Bounds longest;
  longest.low.fill(-std::numeric_limits<float>::denorm_min());
  longest.high = longest.low;
  const size_t frames = times_.size();
  json_room_ = 0;
  binary_size_ = 12 * (triangles_ + frames * static_cast<size_t>(points_)) +
                 (frames > 1 ? 4 * frames + 4 * frames * (frames - 1) : 0);
  const std::string longest_json = json(std::vector<Bounds>(frames, longest));
  json_room_ = longest_json.size() + 16 * frames * 6;
  if (glb_header_size(json_room_) + binary_size_ > std::numeric_limits<std::uint32_t>::max())
    throw InputError(path.string() + ": this file would have " +
                     std::to_string((json_room_ + binary_size_) >> 20) +
                     " MB, expected less than the 4096 MB of GLB: choose fewer frames");
  std::string begin(glb_header_size(json_room_), ' ');
  for (const auto& triangle : triangles)
    for (const int node : triangle) append_uint32(begin, static_cast<std::uint32_t>(node));
  put(begin);
}

void GlbWriter::write(const Points& points) {
  const bool first = bounds_.empty();
  Bounds bounds;
  bounds.low.fill(std::numeric_limits<float>::max());
  bounds.high.fill(-std::numeric_limits<float>::max());
  if (first) first_.resize(points.rows(), 3);
  std::string bytes;
  bytes.reserve(static_cast<size_t>(points.rows()) * 12);
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    for (Eigen::Index c = 0; c < 3; ++c) {
      const auto value = static_cast<float>(first ? points(i, c) : points(i, c) - first_(i, c));
      if (!std::isfinite(value))
        throw InputError(file_.path().string() + ": a coordinate of node " + std::to_string(i) +
                         " is too large for single precision");
      if (first) first_(i, c) = value;
      const auto axis = static_cast<size_t>(c);
      bounds.low[axis] = std::min(bounds.low[axis], value);
      bounds.high[axis] = std::max(bounds.high[axis], value);
      append_float32(bytes, value);
    }
  bounds_.push_back(bounds);
  put(bytes);
}

void GlbWriter::finish() {
  std::string bytes;
  if (times_.size() > 1) {
    for (const double time : times_) append_float32(bytes, static_cast<float>(time));
    for (size_t k = 0; k < times_.size(); ++k)
      for (size_t target = 1; target < times_.size(); ++target)
        append_float32(bytes, target == k ? 1.f : 0.f);
  }
  put(bytes);
  std::string text = json(bounds_);
  text.resize(json_room_, ' ');
  out_.seekp(0);
  put(glb_header(std::move(text), binary_size_));
  out_.close();
  if (!out_) throw FileError(file_.path().string() + ": cannot write this file: writing failed");
  file_.commit();
}

void GlbWriter::put(const std::string& bytes) {
  out_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!out_) throw FileError(file_.path().string() + ": cannot write this file: writing failed");
}

std::string GlbWriter::json(const std::vector<Bounds>& bounds) const {
  using Json = nlohmann::ordered_json;
  const size_t frames = times_.size(), index_bytes = 12 * triangles_,
               frame_bytes = 12 * static_cast<size_t>(points_),
               key_begin = index_bytes + frames * frame_bytes;
  Json accessors = Json::array();
  accessors.push_back({{"bufferView", 0},
                       {"componentType", kUnsignedInt},
                       {"count", 3 * triangles_},
                       {"type", "SCALAR"}});
  for (size_t k = 0; k < frames; ++k)
    accessors.push_back({{"bufferView", 1},
                         {"byteOffset", k * frame_bytes},
                         {"componentType", kFloat},
                         {"count", points_},
                         {"type", "VEC3"},
                         {"min", bounds[k].low},
                         {"max", bounds[k].high}});
  Json views = Json::array();
  views.push_back({{"buffer", 0}, {"byteLength", index_bytes}, {"target", kIndexBuffer}});
  views.push_back({{"buffer", 0},
                   {"byteOffset", index_bytes},
                   {"byteLength", frames * frame_bytes},
                   {"byteStride", 12},
                   {"target", kVertexBuffer}});
  Json primitive, mesh, root;
  primitive["attributes"]["POSITION"] = 1;
  primitive["indices"] = 0;
  primitive["mode"] = 4;
  root["asset"] = {{"version", "2.0"}, {"generator", "Batten"}};
  root["scene"] = 0;
  root["scenes"][0]["nodes"] = std::vector<int>{0};
  root["nodes"][0]["mesh"] = 0;
  root["buffers"][0]["byteLength"] = binary_size_;
  if (frames > 1) {
    for (size_t k = 1; k < frames; ++k) primitive["targets"][k - 1]["POSITION"] = 1 + k;
    mesh["weights"] = std::vector<int>(frames - 1, 0);
    views.push_back(
        {{"buffer", 0}, {"byteOffset", key_begin}, {"byteLength", 4 * frames * frames}});
    accessors.push_back({{"bufferView", 2},
                         {"componentType", kFloat},
                         {"count", frames},
                         {"type", "SCALAR"},
                         {"min", std::vector<float>{static_cast<float>(times_.front())}},
                         {"max", std::vector<float>{static_cast<float>(times_.back())}}});
    accessors.push_back({{"bufferView", 2},
                         {"byteOffset", 4 * frames},
                         {"componentType", kFloat},
                         {"count", frames * (frames - 1)},
                         {"type", "SCALAR"}});
    Json& animation = root["animations"][0];
    animation["samplers"][0] = {
        {"input", frames + 1}, {"interpolation", "LINEAR"}, {"output", frames + 2}};
    animation["channels"][0]["sampler"] = 0;
    animation["channels"][0]["target"] = {{"node", 0}, {"path", "weights"}};
  }
  mesh["primitives"][0] = std::move(primitive);
  root["meshes"][0] = std::move(mesh);
  root["accessors"] = std::move(accessors);
  root["bufferViews"] = std::move(views);
  return root.dump();
}

// Writes a deforming mesh as a point cache, PC2 or MDD (see point_cache.cpp).

/// File formats of point caches.
enum class PointCacheFormat { Pc2, Mdd };

/// Writes a point cache frame by frame. Throws FileError like AtomicFile.
class PointCacheWriter {
 public:
  /// Throws InputError if the times of a PC2 are not evenly spaced.
  PointCacheWriter(const std::filesystem::path& path, PointCacheFormat format, int points,
                   const std::vector<double>& times);
  /// Appends a frame. Throws InputError if a coordinate exceeds single precision.
  void write(const Points& points);
  /// Completes the file and moves it to its final name.
  void finish();

 private:
  AtomicFile file_;
  PointCacheFormat format_;
  std::ofstream out_;
  std::string bytes_;  // buffer for one frame
};

PointCacheWriter::PointCacheWriter(const std::filesystem::path& path, PointCacheFormat format,
                                   int points, const std::vector<double>& times)
    : file_(path), format_(format), out_(file_.temporary(), std::ios::binary) {
  const auto frames = static_cast<std::uint32_t>(times.size());
  if (format == PointCacheFormat::Mdd) {
    append_uint32(bytes_, frames, true);
    append_uint32(bytes_, static_cast<std::uint32_t>(points), true);
    for (const double time : times) append_float32(bytes_, static_cast<float>(time), true);
  } else {
    const double rate =
        frames < 2 ? 1 : (times.back() - times.front()) / static_cast<double>(frames - 1);
    for (size_t k = 0; k < times.size(); ++k)
      if (std::abs(times[k] - (times.front() + static_cast<double>(k) * rate)) > 1e-3 * rate)
        throw InputError(path.string() + ": found the time " + format_number(times[k]) +
                         " of frame " + std::to_string(k + 1) +
                         ", expected uniform times (PC2; MDD stores any times)");
    bytes_.assign("POINTCACHE2\0", 12);
    append_uint32(bytes_, 1);
    append_uint32(bytes_, static_cast<std::uint32_t>(points));
    append_float32(bytes_, static_cast<float>(times.front()));
    append_float32(bytes_, static_cast<float>(rate));
    append_uint32(bytes_, frames);
  }
  out_ << bytes_;
}

void PointCacheWriter::write(const Points& points) {
  const bool big_endian = format_ == PointCacheFormat::Mdd;
  bytes_.clear();
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    for (Eigen::Index c = 0; c < 3; ++c) {
      const auto value = static_cast<float>(points(i, c));
      if (!std::isfinite(value))
        throw InputError(file_.path().string() + ": a coordinate of node " + std::to_string(i) +
                         " is too large for single precision");
      append_float32(bytes_, value, big_endian);
    }
  out_ << bytes_;
  if (!out_) throw FileError(file_.path().string() + ": cannot write this file: writing failed");
}

void PointCacheWriter::finish() {
  out_.close();
  if (!out_) throw FileError(file_.path().string() + ": cannot write this file: writing failed");
  file_.commit();
}

namespace fs = std::filesystem;
namespace {

constexpr double kLargestNumber = 999999;

/// The numbers of the files: the times if these are suitable integers, else 1, 2, …
std::vector<long> numbers_of(const std::vector<double>& times) {
  const bool integer = std::ranges::all_of(times, [](double time) {
    return time >= 0 && time <= kLargestNumber && time == std::floor(time);
  });
  std::vector<long> numbers;
  for (const double time : times)
    numbers.push_back(integer ? static_cast<long>(time) : isize(numbers) + 1);
  return numbers;
}

std::vector<std::array<int, 3>> triangles_of(const ShellMesh& shells) {
  std::vector<std::array<int, 3>> triangles;
  for (int f = 0; f < shells.face_count(); ++f)
    for (const auto& triangle : triangles_of(shells, f)) triangles.push_back(triangle);
  return triangles;
}

void require_times(const fs::path& path, const std::vector<double>& times) {
  if (times.empty()) throw InputError(path.string() + ": found no frames, expected at least one");
  for (size_t k = 0; k < times.size(); ++k)
    if (!std::isfinite(times[k]) || (k > 0 && !(times[k] > times[k - 1])))
      throw InputError(path.string() + ": found the time " + format_number(times[k]) +
                       " of frame " + std::to_string(k + 1) + ", expected ascending ones");
}

/// Creates a folder; its parent must exist.
void make_folder(const fs::path& folder) {
  std::error_code error;
  if (folder.empty() || fs::is_directory(folder, error)) return;
  fs::create_directory(folder, error);
  if (error) throw FileError(folder.string() + ": cannot create this folder: " + error.message());
}

}  // namespace

class SequenceWriter::Output {
 public:
  Output(const ShellMesh& shells, std::vector<double> times)
      : shells(shells), times(std::move(times)) {}
  virtual ~Output() = default;
  virtual fs::path file(int frame) const = 0;
  virtual bool has(int) const { return false; }
  virtual bool has_a_file_for_each() const { return false; }
  virtual void write(int frame, const Points& points) = 0;
  virtual void finish() {}
  virtual std::vector<fs::path> files() const = 0;

  ShellMesh shells;
  std::vector<double> times;
};

class SequenceWriter::Numbered : public Output {
 public:
  Numbered(NumberedName name, const ShellMesh& mesh, std::vector<double> times,
           std::optional<fs::path> pvd = {})
      : Output(mesh, std::move(times)),
        name_(std::move(name)),
        numbers_(numbers_of(this->times)),
        pvd_(std::move(pvd)) {
    make_folder(name_.folder);
    if (lower_extension(name_.file(0)) != ".stl") return;
    ShellMesh faces;
    faces.points = mesh.points;
    for (const auto& triangle : triangles_of(mesh)) faces.add_face(triangle);
    shells = std::move(faces);
  }
  fs::path file(int frame) const override {
    return name_.file(numbers_.at(static_cast<size_t>(frame)));
  }
  bool has(int frame) const override {
    std::error_code ignored;
    return fs::is_regular_file(file(frame), ignored);
  }
  bool has_a_file_for_each() const override { return true; }
  void write(int frame, const Points& points) override {
    shells.points = points;
    write_mesh(file(frame), shells);
  }
  void finish() override {
    if (!pvd_) return;
    std::vector<SeriesFile> series;
    for (int k = 0; k < isize(times); ++k)
      series.push_back(
          {times[static_cast<size_t>(k)], (name_.folder.filename() / file(k).filename()).string()});
    write_pvd(*pvd_, series);
  }
  std::vector<fs::path> files() const override {
    std::vector<fs::path> all;
    for (int k = 0; k < isize(times); ++k) all.push_back(file(k));
    if (pvd_) all.push_back(*pvd_);
    return all;
  }

 private:
  NumberedName name_;
  std::vector<long> numbers_;
  std::optional<fs::path> pvd_;
};

class SequenceWriter::Cache : public Output {
 public:
  Cache(const fs::path& path, PointCacheFormat format, const ShellMesh& mesh,
        std::vector<double> times)
      : Output(mesh, std::move(times)),
        path_(path),
        cache_(path, format, mesh.node_count(), this->times) {}
  fs::path file(int) const override { return path_; }
  void write(int frame, const Points& points) override {
    if (frame == 0) shells.points = points;
    cache_.write(points);
  }
  void finish() override {
    write_mesh(mesh_path(), shells);
    cache_.finish();
  }
  std::vector<fs::path> files() const override { return {path_, mesh_path()}; }

 private:
  fs::path mesh_path() const { return fs::path(path_).replace_extension(".obj"); }
  fs::path path_;
  PointCacheWriter cache_;
};

class SequenceWriter::Glb : public Output {
 public:
  Glb(const fs::path& path, const ShellMesh& mesh, std::vector<double> times)
      : Output({}, std::move(times)),
        path_(path),
        writer_(path, triangles_of(mesh), mesh.node_count(), this->times) {
    shells.points = mesh.points;  // the point count is validated against these
  }
  fs::path file(int) const override { return path_; }
  void write(int, const Points& points) override { writer_.write(points); }
  void finish() override { writer_.finish(); }
  std::vector<fs::path> files() const override { return {path_}; }

 private:
  fs::path path_;
  GlbWriter writer_;
};

void SequenceWriter::check_name(const fs::path& path) {
  static const std::set<std::string> numbered{".obj", ".off", ".ply", ".stl", ".vtp", ".vtu"};
  static const std::set<std::string> single{"", ".pvd", ".pc2", ".mdd", ".glb"};
  const std::string extension = lower_extension(path);
  if (pattern_of(path)) {
    if (!numbered.contains(extension))
      throw InputError(path.string() + ": found numbered files '" + extension +
                       "', expected .obj, .off, .ply, .stl, .vtp or .vtu");
  } else if (numbered.contains(extension)) {
    throw InputError(
        path.string() +
        ": found one file for all frames, expected a pattern for their numbers, such as " +
        path.stem().string() + "_*" + extension);
  } else if (!single.contains(extension)) {
    throw InputError(
        path.string() + ": found the extension '" + path.extension().string() +
        "', expected numbered files such as walk_*.obj, a folder, .pvd, .pc2, .mdd or .glb");
  }
}

SequenceWriter::SequenceWriter(const fs::path& path, const ShellMesh& shells,
                               std::vector<double> times) {
  require_times(path, times);
  const std::string extension = lower_extension(path);
  std::error_code ignored;
  if (!path.has_filename() || fs::is_directory(path, ignored) ||
      (extension.empty() && !pattern_of(path))) {
    const fs::path folder = path.has_filename() ? path : path.parent_path();
    output_ = std::make_unique<Numbered>(NumberedName{folder, "frame_", ".obj", 4}, shells,
                                         std::move(times));
    return;
  }
  check_name(path);
  if (const auto name = pattern_of(path)) {
    output_ = std::make_unique<Numbered>(*name, shells, std::move(times));
    return;
  }
  make_folder(path.parent_path());
  if (extension == ".pvd") {
    const fs::path folder = path.parent_path() / path.stem();
    output_ =
        std::make_unique<Numbered>(NumberedName{folder, path.stem().string() + "_", ".vtp", 4},
                                   shells, std::move(times), path);
  } else if (extension == ".glb") {
    output_ = std::make_unique<Glb>(path, shells, std::move(times));
  } else {
    const auto format = extension == ".pc2" ? PointCacheFormat::Pc2 : PointCacheFormat::Mdd;
    output_ = std::make_unique<Cache>(path, format, shells, std::move(times));
  }
}

SequenceWriter::~SequenceWriter() = default;

int SequenceWriter::frame_count() const { return isize(output_->times); }
fs::path SequenceWriter::file(int frame) const { return output_->file(frame); }
bool SequenceWriter::has(int frame) const { return output_->has(frame); }
std::vector<fs::path> SequenceWriter::files() const { return output_->files(); }

void SequenceWriter::write(int frame, const Points& points) {
  if (frame < next_ || frame >= frame_count())
    throw std::logic_error("SequenceWriter: frame " + std::to_string(frame) + " after " +
                           std::to_string(next_) + " of " + std::to_string(frame_count()));
  for (; next_ < frame; ++next_)
    if (!output_->has_a_file_for_each())
      throw std::logic_error("SequenceWriter: frame " + std::to_string(next_) + " is left out");
  const std::string name = file(frame).string();
  if (points.rows() != output_->shells.node_count())
    throw InputError(name + ": found " + format_count(points.rows(), "point") + ", expected " +
                     std::to_string(output_->shells.node_count()));
  for (int i = 0; i < points.rows(); ++i)
    if (!points.row(i).allFinite())
      throw InputError(name + ": frame " + std::to_string(frame + 1) + ": a coordinate of node " +
                       std::to_string(i) + " is not finite");
  output_->write(frame, points);
  ++next_;
}

void SequenceWriter::finish() {
  for (int k = output_->has_a_file_for_each() ? 0 : next_; k < frame_count(); ++k)
    if (!has(k))
      throw std::logic_error("SequenceWriter: frame " + std::to_string(k) + " is missing");
  output_->finish();
}

}  // namespace batten
