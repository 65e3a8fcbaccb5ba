#include "batten/io/files/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cstring>

#include "batten/core/errors.h"
#include "batten/io/files/toml_table.h"

namespace batten {
namespace {

// Why a file cannot be read, judged by its type; nullptr if it can.
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
      return "found a cycle of symbolic links";
    case EACCES:
    case EPERM:
      return "found no permission to read this file";
    default:
      return std::strerror(error);
  }
}

// A file opened for reading.
class OpenFile {
 public:
  OpenFile(const std::filesystem::path& file, const std::string& expected, const std::string& where)
      : name_(where + file.string()), expected_(expected) {
    // Check the type before opening, because opening a pipe waits for its other end.
    struct stat found {};
    if (::stat(file.c_str(), &found) != 0) fail(reason_of(errno));
    if (const char* what = obstacle(found)) fail(std::string("found ") + what);
    file_ = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file_ < 0) fail(reason_of(errno));
    if (::fstat(file_, &found) != 0 || obstacle(found) != nullptr) close_and_fail();
    size_ = static_cast<std::uintmax_t>(found.st_size);
    if (size_ > kMaxInputFileSize) {
      ::close(file_);
      fail("found " + std::to_string(size_ >> 20) + " MB, more than the limit of " +
           std::to_string(kMaxInputFileSize >> 20) + " MB");
    }
  }
  ~OpenFile() { ::close(file_); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  // The contents. If the file grows meanwhile, only the original size is read.
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

namespace {

// The position after a quoted string that begins at `at`, or the end of the text.
size_t behind_quotes(std::string_view text, size_t at) {
  const char quote = text[at];
  const std::string_view three = quote == '"' ? "\"\"\"" : "'''";
  const std::string_view closing = text.substr(at).starts_with(three) ? three : three.substr(0, 1);
  for (size_t i = at + closing.size(); i < text.size(); ++i) {
    if (quote == '"' && text[i] == '\\')
      ++i;
    else if (text.substr(i).starts_with(closing))
      return i + closing.size();
    else if (closing.size() == 1 && text[i] == '\n')
      return i;  // unterminated: the parser will report it
  }
  return text.size();
}

[[noreturn]] void fail(std::string_view text, size_t at, const std::string& file,
                       const std::string& what) {
  const auto line = std::count(text.begin(), text.begin() + static_cast<long>(at), '\n');
  const size_t before = at == 0 ? text.npos : text.rfind('\n', at - 1);
  const size_t column = before == text.npos ? at + 1 : at - before;
  throw InputError(format_location(file, {static_cast<int>(line) + 1, static_cast<int>(column)}) +
                   "found " + what + " in each other, expected " +
                   std::to_string(kMaxNestingDepth) + " levels at most");
}

}  // namespace

void check_nesting_depth(std::string_view text, const std::string& file) {
  int depth = 0, dots = 0;
  for (size_t i = 0; i < text.size();) {
    switch (text[i]) {
      case '"':
      case '\'':
        i = behind_quotes(text, i);
        continue;
      case '#':
        i = std::min(text.find('\n', i), text.size());
        continue;
      case '[':
      case '{':
        ++depth;
        dots = 0;
        break;
      case ']':
      case '}':
        depth = std::max(0, depth - 1);
        break;
      case '.':
        ++dots;
        break;
      case '=':
      case ',':
      case '\n':
        dots = 0;
        break;
      default:
        break;
    }
    if (depth + dots > kMaxNestingDepth) fail(text, i, file, "lists, tables or parts of a key");
    ++i;
  }
}

void check_xml_nesting_depth(std::string_view text, const std::string& file) {
  int depth = 0;
  const auto behind = [&](std::string_view ending, size_t from) {
    const size_t found = text.find(ending, from);
    return found == text.npos ? text.size() : found + ending.size();
  };
  for (size_t i = text.find('<'); i < text.size(); i = text.find('<', i)) {
    const std::string_view rest = text.substr(i);
    if (rest.starts_with("<!--")) {
      i = behind("-->", i);
    } else if (rest.starts_with("<![CDATA[")) {
      i = behind("]]>", i);
    } else if (rest.starts_with("<?")) {
      i = behind("?>", i);
    } else if (rest.starts_with("<!")) {
      i = behind(">", i);
    } else {
      const size_t start = i;
      for (++i; i < text.size() && text[i] != '>'; ++i)
        if (text[i] == '"' || text[i] == '\'') i = std::min(text.find(text[i], i + 1), text.size());
      if (rest.starts_with("</"))
        --depth;
      else if (i < text.size() && text[i - 1] != '/' && ++depth > kMaxNestingDepth)
        fail(text, start, file, "elements");
    }
  }
}

}  // namespace batten
