#include "batten/io/sequences/sequence_writer.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <stdexcept>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/text.h"
#include "batten/io/meshes/mesh_content.h"
#include "batten/io/meshes/mesh_file.h"
#include "batten/io/sequences/glb_writer.h"
#include "batten/io/sequences/numbered_files.h"
#include "batten/io/sequences/point_cache.h"
#include "batten/io/vtk/vtk_series.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

constexpr double kLargestNumber = 999999;

/// The numbers of the files: the times, or 1, 2, …
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
  if (times.empty()) throw InputError(path.string() + ": found no frames, expected some");
  for (size_t k = 0; k < times.size(); ++k)
    if (!std::isfinite(times[k]) || (k > 0 && !(times[k] > times[k - 1])))
      throw InputError(path.string() + ": found the time " + format_number(times[k]) +
                       " of frame " + std::to_string(k + 1) + ", expected ascending ones");
}

/// Makes one folder; the one above it has to be there.
void make_folder(const fs::path& folder) {
  std::error_code error;
  if (folder.empty() || fs::is_directory(folder, error)) return;
  fs::create_directory(folder, error);
  if (error) throw FileError(folder.string() + ": cannot make this folder: " + error.message());
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
    shells.points = mesh.points;  // their number is checked
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
    throw InputError(path.string() +
                     ": found one file for all frames, expected a place for their numbers, as " +
                     path.stem().string() + "_*" + extension);
  } else if (!single.contains(extension)) {
    throw InputError(
        path.string() + ": found the extension '" + path.extension().string() +
        "', expected numbered files as walk_*.obj, a folder, .pvd, .pc2, .mdd or .glb");
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
