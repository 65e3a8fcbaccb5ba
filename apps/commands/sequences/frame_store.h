// Frames of a run on the disk: those that are there, and those that are written.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "batten/io/sequences/sequence_writer.h"
#include "batten/mesh/sequence/mesh_sequence.h"

namespace batten {

/// A number for what a run is made from, by which another run knows its frames as its own: 64-bit
/// FNV-1a of all that is added.
class Fingerprint {
 public:
  void add(const void* bytes, size_t count);
  void add(const std::string& text) { add(text.data(), text.size()); }
  void add(const MeshSequence& sequence);
  /// The bytes of a file; nothing where there is none.
  void add_file(const std::filesystem::path& file);
  std::string text() const;

 private:
  std::uint64_t hash_ = 14695981039346656037ULL;
};

/// Writes frames first … last of a sequence. Numbered files of a run with the same fingerprint are
/// kept, those of another one are written anew.
class FrameStore {
 public:
  /// `folder` and `name`: where the frames appear. `hidden`: where single files are written
  /// meanwhile. Numbered files of this name that a run with another fingerprint made are removed.
  /// Throws InputError: what SequenceWriter throws; a part of the frames into a single file; numbered
  /// files that no such run made, as the input itself.
  FrameStore(const std::filesystem::path& folder, const std::filesystem::path& hidden,
             const std::string& name, const ShellMesh& shells, const std::vector<double>& times,
             int first, int last, const std::string& fingerprint);

  bool has(int frame) const;
  /// A frame that is there.
  Points read(int frame) const;
  void write(int frame, const Points& points);
  /// Ends the files; their names in the folder, those that this run was to make.
  std::vector<std::string> finish();

 private:
  bool numbered_ = false, read_again_ = false, whole_ = true;
  int first_, last_;
  std::filesystem::path root_;  // what names are relative to
  std::unique_ptr<SequenceWriter> writer_;
};

}  // namespace batten
