#include "batten/io/sequences/numbered_files.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <numeric>

#include "batten/core/errors.h"
#include "batten/core/isize.h"
#include "batten/io/files/text.h"
#include "batten/io/files/toml_table.h"
#include "batten/io/meshes/mesh_file.h"

namespace batten {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kDigits = "0123456789";

/// A file's name around the last number in its stem; none without a number.
std::optional<NumberedName> name_around(const fs::path& path) {
  const std::string stem = path.stem().string();
  const size_t last = stem.find_last_of(kDigits);
  if (last == stem.npos) return {};
  const size_t prefix = stem.find_last_not_of(kDigits, last);
  const size_t first = prefix == stem.npos ? 0 : prefix + 1;
  return NumberedName{path.parent_path(), stem.substr(0, first),
                      stem.substr(last + 1) + path.extension().string(),
                      static_cast<int>(last + 1 - first)};
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(folder.empty() ? "." : folder, error), end;
       !error && entry != end; entry.increment(error))
    if (std::error_code ignored; entry->is_regular_file(ignored))
      files.push_back(folder / entry->path().filename());
  if (error) throw InputError(folder.string() + ": cannot read this folder: " + error.message());
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<NumberedFile> files_of(const NumberedName& name) {
  std::vector<NumberedFile> files;
  for (const fs::path& file : files_in(name.folder))
    if (const auto number = name.number_of(file.filename().string()))
      files.push_back({file, *number});
  std::stable_sort(files.begin(), files.end(), [](const NumberedFile& a, const NumberedFile& b) {
    return a.number < b.number;
  });
  for (size_t i = 1; i < files.size(); ++i)
    if (files[i].number == files[i - 1].number)
      throw InputError(files[i].path.string() + ": found the number " +
                       std::to_string(files[i].number) + " also in " +
                       files[i - 1].path.filename().string() + ", expected each number once");
  return files;
}

/// The one series of mesh files in a folder; single files count where there is nothing else.
NumberedName series_in(const fs::path& folder) {
  std::map<std::string, std::vector<NumberedName>> series;
  for (const fs::path& file : files_in(folder))
    if (MeshFile::can_read(file))
      if (const auto name = name_around(file)) series[name->pattern()].push_back(*name);
  std::vector<std::string> found;
  for (const size_t least : {2, 1}) {
    for (const auto& [pattern, files] : series)
      if (files.size() >= least) found.push_back(fs::path(pattern).filename().string());
    if (!found.empty()) break;
  }
  if (found.size() == 1) return series.at((folder / found.front()).string()).front();
  if (found.empty())
    throw InputError(folder.string() +
                     ": found no numbered mesh files in this folder, expected some");
  throw InputError(folder.string() + ": found " + std::to_string(found.size()) +
                   " series of files, " + comma_separated(found) + "; name one of them");
}

}  // namespace

std::string NumberedName::pattern() const { return (folder / (prefix + "*" + suffix)).string(); }

fs::path NumberedName::file(long number) const {
  std::string text = std::to_string(number);
  if (text.size() < static_cast<size_t>(digits))
    text.insert(0, static_cast<size_t>(digits) - text.size(), '0');
  return folder / (prefix + text + suffix);
}

std::optional<long> NumberedName::number_of(const std::string& file_name) const {
  if (file_name.size() <= prefix.size() + suffix.size() || !file_name.starts_with(prefix) ||
      !file_name.ends_with(suffix))
    return {};
  const char* const first = file_name.data() + prefix.size();
  const char* const last = file_name.data() + file_name.size() - suffix.size();
  long number = 0;
  const auto [end, error] = std::from_chars(first, last, number);
  if (*first == '-' || end != last || error != std::errc()) return {};
  return number;
}

std::optional<NumberedName> pattern_of(const fs::path& path) {
  const std::string name = path.filename().string();
  const auto refuse = [&](const std::string& found) {
    throw InputError(path.string() + ": found " + found +
                     ", expected one * or %04d in the file's name");
  };
  if (path.parent_path().string().find('*') != std::string::npos) refuse("a * in the folder");
  const size_t at = name.find_first_of("*%");
  if (at == name.npos) return {};
  NumberedName result{path.parent_path(), name.substr(0, at), "", 4};
  size_t end = at + 1;
  if (name[at] == '%') {
    end = name.find_first_not_of(kDigits, end);
    const std::string digits = name.substr(at + 1, std::min(end, name.size()) - at - 1);
    if (end == name.npos || name[end] != 'd' || digits.size() > 2) refuse("a % without digits, d");
    result.digits = digits.empty() ? 1 : std::max(1, std::stoi(digits));
    ++end;
  }
  result.suffix = name.substr(end);
  if (result.suffix.find_first_of("*%") != std::string::npos) refuse("several places for a number");
  return result;
}

std::vector<NumberedFile> numbered_files(const fs::path& path, std::string& name) {
  std::error_code ignored;
  std::optional<NumberedName> series;
  if (fs::is_directory(path, ignored)) {
    series = series_in(path);
  } else if (fs::exists(path, ignored) || !(series = pattern_of(path))) {
    if (!MeshFile::can_read(path))
      throw InputError(path.string() +
                       ": expected a folder, a pattern as walk_*.obj, a mesh file, .pvd, .pc2, "
                       ".mdd, .gltf, .glb or .frd");
    series = name_around(path);
    if (!series || !fs::exists(path, ignored)) {
      name = path.string();
      return {{path, 1}};
    }
  }
  name = series->pattern();
  std::vector<NumberedFile> files = files_of(*series);
  if (files.empty()) throw InputError(name + ": found no such files, expected numbered ones");
  return files;
}

void require_no_gaps(const std::vector<NumberedFile>& files, const std::string& name) {
  long stride = 0;
  for (size_t i = 1; i < files.size(); ++i)
    stride = std::gcd(stride, files[i].number - files[i - 1].number);
  std::vector<std::string> missing;
  long count = 0;
  for (size_t i = 1; i < files.size(); ++i) {
    count += (files[i].number - files[i - 1].number) / stride - 1;
    for (long n = files[i - 1].number + stride; n < files[i].number && missing.size() < 8;
         n += stride)
      missing.push_back(std::to_string(n));
  }
  if (count == 0) return;
  throw InputError(name + ": found no file for " + (count == 1 ? "number " : "the numbers ") +
                   comma_separated(missing) +
                   (count > isize(missing)
                        ? " and " + std::to_string(count - isize(missing)) + " more"
                        : std::string()) +
                   ", expected all from " + std::to_string(files.front().number) + " to " +
                   std::to_string(files.back().number) +
                   (stride > 1 ? " in steps of " + std::to_string(stride) : std::string()));
}

}  // namespace batten
