// SPDX-License-Identifier: MPL-2.0
#include "batten/scenes/sequences/frame_store.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "batten/core/errors.h"
#include "batten/io/files/atomic_file.h"
#include "batten/io/files/text.h"
#include "batten/io/meshes/mesh_file.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

/// A file name with * in place of its last number.
std::string without_number(const fs::path& file) {
  std::string name = file.filename().string();
  const size_t last = name.find_last_of("0123456789", name.rfind('.'));
  if (last == name.npos) return name;
  const size_t before = name.find_last_not_of("0123456789", last);
  const size_t first = before == name.npos ? 0 : before + 1;
  return name.replace(first, last + 1 - first, "*");
}

}  // namespace

void Fingerprint::add(const void* bytes, size_t count) {
  const auto* byte = static_cast<const unsigned char*>(bytes);
  for (size_t i = 0; i < count; ++i) hash_ = (hash_ ^ byte[i]) * 1099511628211ULL;
}

void Fingerprint::add(const MeshSequence& sequence) {
  for (const Points& p : sequence.frames)
    add(p.data(), sizeof(double) * static_cast<size_t>(p.size()));
  for (int f = 0; f < sequence.shells.face_count(); ++f)
    add(sequence.shells.face(f).data(), sequence.shells.face(f).size_bytes());
}

void Fingerprint::add_file(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::vector<char> block(1 << 20);
  while (in) {
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    add(block.data(), static_cast<size_t>(in.gcount()));
  }
}

std::string Fingerprint::text() const {
  std::ostringstream out;
  out << std::hex << hash_;
  return out.str();
}

std::vector<double> written_times(const fs::path& name, std::vector<double> times,
                                  double frames_per_second) {
  const bool numbered =
      std::all_of(times.begin(), times.end(), [](double t) { return t == std::floor(t); });
  if (lower_extension(name) != ".glb" || !numbered || times.empty()) return times;
  const double start = times.front();
  for (double& t : times) t = (t - start) / frames_per_second;
  return times;
}

FrameStore::FrameStore(const fs::path& folder, const fs::path& hidden, const std::string& name,
                       const ShellMesh& shells, const std::vector<double>& times, int first,
                       int last, const std::string& fingerprint)
    : first_(first), last_(last) {
  const std::string ending = lower_extension(name);
  numbered_ = ending != ".pc2" && ending != ".mdd" && ending != ".glb";
  read_again_ = numbered_ && ending != ".stl";  // STL stores corners only, no nodes
  whole_ = first == 0 && last + 1 == isize(times);
  const fs::path path = folder / name;
  if (!whole_ && (!numbered_ || ending == ".pvd"))
    throw InputError(path.string() + ": found frames " + std::to_string(first + 1) + " to " +
                     std::to_string(last + 1) + " of " + std::to_string(times.size()) +
                     " for a single file, expected numbered files such as frames/frame_*.obj");
  root_ = folder;
  if (!numbered_) {
    root_ = hidden;
    for ([[maybe_unused]] const auto& part : fs::path(name)) root_ = root_.parent_path();
    writer_ = std::make_unique<SequenceWriter>(hidden, shells, times);
    return;
  }
  const fs::path place = ending.empty() ? path : path.parent_path();
  make_output_folder(place);
  writer_ = std::make_unique<SequenceWriter>(path, shells, times);
  const fs::path stamp = place / ".batten-frames";
  std::string before;
  std::vector<std::string> left;
  {
    std::ifstream in(stamp);
    std::getline(in, before);
    for (std::string file; std::getline(in, file);) left.push_back(file);
  }
  if (before == fingerprint) return;
  for (int k = 0; k < isize(times); ++k)
    if (fs::exists(writer_->file(k)) &&
        std::ranges::find(left, writer_->file(k).filename().string()) == left.end())
      throw InputError(writer_->file(k).string() +
                       ": found a file that was not written by batten sequence and would be "
                       "overwritten, expected another folder or name");
  const fs::path of_frames = writer_->file(0).parent_path();
  const std::string like = without_number(writer_->file(0));
  for (const std::string& file : left)  // an earlier run may have had more frames
    if (without_number(file) == like) fs::remove(of_frames / fs::path(file).filename());
  std::erase_if(left, [&](const std::string& file) { return without_number(file) == like; });
  write_file_atomically(stamp, [&](std::ostream& out) {
    out << fingerprint << "\n";
    for (int k = 0; k < isize(times); ++k) out << writer_->file(k).filename().string() << "\n";
    for (const std::string& file : left) out << file << "\n";  // files with other names
  });
}

bool FrameStore::has(int frame) const { return read_again_ && writer_->has(frame); }

Points FrameStore::read(int frame) const {
  return MeshFile::read(writer_->file(frame)).shells().points;
}

void FrameStore::write(int frame, const Points& points) { writer_->write(frame, points); }

std::vector<std::string> FrameStore::finish() {
  std::vector<std::string> names;
  const auto add = [&](const fs::path& file) {
    names.push_back(file.lexically_relative(root_).string());
  };
  if (!whole_) {
    for (int k = first_; k <= last_; ++k) add(writer_->file(k));
    return names;
  }
  writer_->finish();
  for (const auto& file : writer_->files()) add(file);
  return names;
}

}  // namespace batten
