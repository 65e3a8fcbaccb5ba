#include "batten/io/sequences/sequence_files.h"

#include <map>

#include "batten/core/errors.h"
#include "batten/io/files/text.h"
#include "batten/io/sequences/sequence_readers.h"

namespace batten {

FrameRange frame_range(const SequenceOptions& options, long all, const std::string& name) {
  const long last = options.last == 0 ? all : options.last;
  if (options.first < 1 || last < options.first || last > all)
    throw InputError(name + ": found " + format_count(all, "frame") + ", expected frames " +
                     std::to_string(options.first) + " to " +
                     (options.last == 0 ? "the end" : std::to_string(last)));
  return {options.first - 1, static_cast<int>(last - options.first + 1)};
}

MeshSequence read_sequence(const std::filesystem::path& path, const SequenceOptions& options,
                           const Progress& progress) {
  static const std::map<std::string, SequenceReader*> readers{
      {".pvd", read_pvd_sequence},   {".pc2", read_pc2_sequence},  {".mdd", read_mdd_sequence},
      {".gltf", read_gltf_sequence}, {".glb", read_gltf_sequence}, {".frd", read_frd_sequence}};
  std::error_code ignored;
  const auto found = std::filesystem::is_directory(path, ignored)
                         ? readers.end()
                         : readers.find(lower_extension(path));
  SequenceReader* const read = found == readers.end() ? read_numbered_sequence : found->second;
  MeshSequence sequence = read(path, options, progress);
  check(sequence, path.string());
  sequence.shells.points = sequence.frames.front();
  return sequence;
}

}  // namespace batten
