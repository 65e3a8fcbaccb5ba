// SPDX-License-Identifier: MPL-2.0
// Output frames of a sequence run on disk, with resumption of interrupted runs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

#include "batten/io/sequences/sequence_writer.h"
#include "batten/mesh/sequence/mesh_sequence.h"

namespace batten {

/// Hash of the inputs of a run (64-bit FNV-1a). A run with the same fingerprint can reuse its
/// frames.
class Fingerprint {
 public:
  /// Adds bytes, a text, or all data of a sequence.
  void add(const void* bytes, size_t count);
  void add(const std::string& text) { add(text.data(), text.size()); }
  void add(const MeshSequence& sequence);
  /// Adds the bytes of a file; nothing if the file does not exist.
  void add_file(const std::filesystem::path& file);
  /// The fingerprint as text.
  std::string text() const;

 private:
  std::uint64_t hash_ = 14695981039346656037ULL;
};

/// Times of the frames in the output file `name`. glTF requires seconds: frame numbers are divided
/// by `frames_per_second`.
std::vector<double> written_times(const std::filesystem::path& name, std::vector<double> times,
                                  double frames_per_second);

/// Writes frames first … last of a sequence. Numbered files of a run with the same fingerprint are
/// kept; those of another run are replaced.
class FrameStore {
 public:
  /// `folder`, `name`: final location of the frames. `hidden`: folder for unfinished single files.
  /// Numbered files of this name from a run with another fingerprint are deleted.
  ///
  /// Throws the exceptions of SequenceWriter. Also throws InputError for a partial range of frames
  /// in a single file, and for numbered files that no run wrote, such as the input itself.
  FrameStore(const std::filesystem::path& folder, const std::filesystem::path& hidden,
             const std::string& name, const ShellMesh& shells, const std::vector<double>& times,
             int first, int last, const std::string& fingerprint);

  /// True if the frame exists already.
  bool has(int frame) const;
  /// Reads an existing frame.
  Points read(int frame) const;
  /// Writes a frame (n×3); see SequenceWriter::write().
  void write(int frame, const Points& points);
  /// Completes the files. The result lists their names in the folder, for the frames of this run.
  std::vector<std::string> finish();

 private:
  bool numbered_ = false, read_again_ = false, whole_ = true;
  int first_, last_;
  std::filesystem::path root_;  // folder to which names are relative
  std::unique_ptr<SequenceWriter> writer_;
};

}  // namespace batten
