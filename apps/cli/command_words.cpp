#include "batten/apps/cli/command_words.h"

#include <algorithm>
#include <cmath>
#include <iostream>

#include "batten/apps/cli/terminal.h"
#include "batten/io/files/length_units.h"

namespace batten {

const CLI::Validator kPositive(
    [](std::string& text) {
      double value = 0;
      return CLI::detail::lexical_cast(text, value) && value > 0 && std::isfinite(value)
                 ? std::string()
                 : "found " + text + ", expected a number above 0";
    },
    "POSITIVE");

void add_common(CLI::App* sub, CommonWords& common) {
  sub->add_option("--threads", common.threads, "Threads to use; the number of cores unless given")
      ->check(CLI::Range(1, 1024));
  sub->add_option("--memory", common.memory,
                  "GB that may be used; what is there unless given. More is refused beforehand")
      ->check(kPositive);
  sub->add_flag("--quiet", common.quiet, "Print errors only");
}

CLI::Option* repeated(CLI::Option* option) { return option->take_all()->allow_extra_args(false); }

void add_unit(CLI::App* sub, std::string& unit) {
  sub->add_option("--unit", unit, "Unit of lengths")
      ->check(CLI::IsMember(length_units()))
      ->capture_default_str();
}

int finish(const RunReport& report, const std::string& text, const CommonWords& common) {
  end_progress();
  if (!common.quiet) std::cout << text;
  constexpr size_t most = 10;  // of a kind: the report has all
  const auto list = [&](const char* label, const auto& items, const auto& text_of) {
    for (size_t i = 0; i < std::min(items.size(), most); ++i)
      std::cerr << label << ": " << text_of(items[i]) << "\n";
    if (items.size() > most)
      std::cerr << label << ": and " << items.size() - most << " more (the report has all)\n";
  };
  list("warning", report.warnings, [](const auto& w) { return w; });
  list("promise missed", report.missed, [](const auto& m) { return m.what + " " + m.detail; });
  return report.missed.empty() ? kDone : kMissed;
}

}  // namespace batten
