#include "batten/apps/commands/sequences/frame_store.h"

#include <fstream>
#include <sstream>

#include "batten/core/errors.h"
#include "batten/io/files/whole_file.h"
#include "batten/io/meshes/mesh_file.h"

namespace batten {
namespace fs = std::filesystem;

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

FrameStore::FrameStore(const fs::path& path, const fs::path& hidden, const ShellMesh& shells,
                       const std::vector<double>& times, int first, int last,
                       const std::string& fingerprint)
    : first_(first), last_(last), folder_(path.parent_path()) {
  const std::string ending = path.extension().string();
  numbered_ = ending != ".pc2" && ending != ".mdd" && ending != ".glb" && ending != ".gltf";
  whole_ = first == 0 && last + 1 == count_of(times);
  if (!whole_ && (!numbered_ || ending == ".pvd"))
    throw InputError(path.string() + ": frames " + std::to_string(first + 1) + " to " +
                     std::to_string(last + 1) + " of " + std::to_string(times.size()) +
                     " alone can be written as numbered files only, as frames/frame_*.obj");
  if (!numbered_) {
    writer_ = std::make_unique<SequenceWriter>(hidden, shells, times);
    return;
  }
  if (ending.empty()) folder_ = path;
  make_output_folder(folder_);
  writer_ = std::make_unique<SequenceWriter>(path, shells, times);
  const fs::path stamp = folder_ / ".batten-frames";
  std::string before;
  std::getline(std::ifstream(stamp) >> std::ws, before);
  if (before == fingerprint) return;
  for (int k = 0; k < count_of(times); ++k) fs::remove(writer_->file(k));
  write_whole_file(stamp, [&](std::ostream& out) { out << fingerprint << "\n"; });
}

bool FrameStore::have(int frame) const { return numbered_ && writer_->have(frame); }

Points FrameStore::read(int frame) const {
  return MeshFile::read(writer_->file(frame)).shells().points;
}

void FrameStore::write(int frame, const Points& points) { writer_->write(frame, points); }

std::vector<std::string> FrameStore::finish() {
  if (!whole_)
    return {writer_->file(first_).filename().string() + " … " +
            writer_->file(last_).filename().string()};
  writer_->finish();
  std::vector<std::string> names;
  for (const auto& file : writer_->files()) names.push_back(file.filename().string());
  return names;
}

}  // namespace batten
