#include "batten/io/files/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "batten/core/errors.h"

namespace batten {
namespace {

// What stands in the way of reading a file, or nullptr.
const char* obstacle(const struct stat& found) {
  if (S_ISDIR(found.st_mode)) return "a folder";
  if (S_ISFIFO(found.st_mode)) return "a pipe";
  if (S_ISSOCK(found.st_mode)) return "a socket";
  if (!S_ISREG(found.st_mode)) return "a device";
  return nullptr;
}

const char* reason_of(int error) {
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      return "found no such file";
    case ELOOP:
      return "found links that lead in a circle";
    case EACCES:
    case EPERM:
      return "this file may not be read";
    default:
      return std::strerror(error);
  }
}

// A file that is open for reading.
class OpenFile {
 public:
  OpenFile(const std::filesystem::path& file, const std::string& expected, const std::string& where)
      : name_(where + file.string()), expected_(expected) {
    // A pipe is looked at before it is opened: opening one waits for its other end.
    struct stat found {};
    if (::stat(file.c_str(), &found) != 0) fail(reason_of(errno));
    if (const char* what = obstacle(found)) fail(std::string("found ") + what);
    file_ = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file_ < 0) fail(reason_of(errno));
    if (::fstat(file_, &found) != 0 || obstacle(found) != nullptr) close_and_fail();
    size_ = static_cast<std::uintmax_t>(found.st_size);
    if (size_ > kMaxInputFileSize) {
      ::close(file_);
      fail("found " + std::to_string(size_ >> 20) + " MB, more than the " +
           std::to_string(kMaxInputFileSize >> 20) + " MB that are read");
    }
  }
  ~OpenFile() { ::close(file_); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  // A file that grows meanwhile is read as long as it was.
  std::string bytes() const {
    std::string all(size_, '\0');
    size_t done = 0;
    while (done < all.size()) {
      const ssize_t got = ::read(file_, all.data() + done, all.size() - done);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) fail(reason_of(errno));
      if (got == 0) break;
      done += static_cast<size_t>(got);
    }
    all.resize(done);
    return all;
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    throw InputError(name_ + ": " + reason + ", expected " + expected_);
  }
  [[noreturn]] void close_and_fail() {
    ::close(file_);
    fail("this file cannot be read");
  }

  std::string name_, expected_;
  int file_ = -1;
  std::uintmax_t size_ = 0;
};

}  // namespace

void require_input_file(const std::filesystem::path& file, const std::string& expected,
                        const std::string& where) {
  const OpenFile open(file, expected, where);
}

std::string read_input_file(const std::filesystem::path& file, const std::string& expected,
                            const std::string& where) {
  return OpenFile(file, expected, where).bytes();
}

std::uintmax_t input_file_size(const std::filesystem::path& file) noexcept {
  struct stat found {};
  return ::stat(file.c_str(), &found) == 0 ? static_cast<std::uintmax_t>(found.st_size) : 0;
}

}  // namespace batten
