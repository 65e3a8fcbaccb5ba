// SPDX-License-Identifier: MPL-2.0
// libFuzzer for the file readers, in one process: `batten info` on a file with the extension in
// BATTEN_FUZZ_ENDING (".csv"). scripts/fuzz readers builds and runs it.
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <new>
#include <string>

#include "batten/core/errors.h"
#include "batten/io/sessions/session_log.h"
#include "batten/scenes/commands.h"

namespace {

// In memory, if there is a file system for it.
const std::filesystem::path& input() {
  static const std::filesystem::path file = [] {
    const char* ending = std::getenv("BATTEN_FUZZ_ENDING");
    if (!ending) std::abort();
    const std::filesystem::path memory = "/dev/shm";
    return (std::filesystem::is_directory(memory) ? memory
                                                  : std::filesystem::temp_directory_path()) /
           ("batten_fuzz_" + std::to_string(getpid()) + ending);
  }();
  return file;
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  std::atexit([] { std::filesystem::remove(input()); });
  return 0;
}

// Every exception other than the documented ones stops the fuzzer.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::ofstream(input(), std::ios::binary)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    if (input().extension() == ".jsonl")
      batten::read_session_log(input());
    else
      batten::file_info(input(), "mm");
  } catch (const batten::Error&) {
  } catch (const std::bad_alloc&) {
  }
  return 0;
}
