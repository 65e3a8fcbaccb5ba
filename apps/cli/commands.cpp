#include "batten/apps/cli/commands.h"

#include <algorithm>
#include <iostream>

#include "batten/apps/cli/terminal.h"
#include "batten/io/files/length_units.h"

namespace batten {

void add_common(const Subcommand& subcommand, CommonOptions& common) {
  subcommand.option("--threads", common.threads, "Threads to use; the number of cores unless given")
      .in_range(1, 1024);
  subcommand
      .option("--memory", common.memory,
              "GB that may be used; what is there unless given. More is refused beforehand")
      .positive();
  subcommand.flag("--quiet", common.quiet, "Print errors only");
}

void add_unit(const Subcommand& subcommand, std::string& unit) {
  subcommand.option("--unit", unit, "Unit of lengths").one_of(length_units()).show_default();
}

void add_schema(const Subcommand& subcommand, bool& ap242) {
  subcommand.enum_option(
      "--schema", {"ap214", "ap242"},
      [&ap242](const std::string& word) { ap242 = word == "ap242"; }, "Of STEP: ap214 or ap242");
}

void add_step_options(const Subcommand& subcommand, StepFileArguments& step) {
  subcommand.flag("--step-lines", step.lines,
                  "The STEP file holds the lines too, as curves in a product 'lines'");
  add_schema(subcommand, step.ap242);
}

int print_result(const RunReport& report, const std::string& text, const CommonOptions& common) {
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
  list("promise missed", report.failed_checks,
       [](const auto& m) { return m.what + " " + m.detail; });
  return report.failed_checks.empty() ? kDone : kCheckFailed;
}

}  // namespace batten
