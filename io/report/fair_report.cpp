#include "batten/io/report/fair_report.h"

#include "batten/core/errors.h"
#include "batten/io/report/report_json.h"

namespace batten {
namespace {

Json contents(const FairReport& r) {
  Json json = report_header(r);
  json["curves"] = json_of(r.curves);
  json["parameters"] = json_of(r.parameters);
  add_report_footer(json, r);
  return json;
}

}  // namespace

Json json_of(const Fairness& f) {
  return {{"length", f.length},
          {"bending", f.bending},
          {"variation", f.variation},
          {"largest_curvature", f.largest_curvature},
          {"largest_jump", f.largest_jump},
          {"extrema", f.extrema},
          {"inflections", f.inflections}};
}

Json json_of(const std::vector<FairedLine>& curves) {
  Json list = Json::array();
  for (const FairedLine& c : curves) {
    Json outliers = Json::array();
    for (const int i : c.outliers) outliers.push_back(i + 1);
    list.push_back(
        {{"name", c.name},
         {"points", c.points},
         {"segments", c.segments},
         {"closed", c.closed},
         {"faired", c.faired},
         {"deviation",
          {{"max", c.deviation.max}, {"rms", c.deviation.rms}, {"between", c.deviation.between}}},
         {"noise", c.noise},
         {"outliers", outliers},
         {"wavelength", c.wavelength},
         {"freedom", c.effective_dofs},
         {"rounds", c.rounds},
         {"settled", c.converged},
         {"max_residual", c.max_residual},
         {"before", c.before ? json_of(*c.before) : Json()},
         {"after", c.after ? json_of(*c.after) : Json()},
         {"seconds", c.seconds}});
  }
  return list;
}

std::vector<FailedCheck> failed_fairing_checks(const std::vector<FairedLine>& curves) {
  std::vector<FailedCheck> failed_checks;
  for (const FairedLine& c : curves) {
    if (c.exceeded_deviation)
      failed_checks.push_back(
          {"curves." + c.name + ".deviation",
           "is " + format_number(c.exceeded_deviation->second) +
               " after the stage that states at most " +
               format_number(c.exceeded_deviation->first) +
               ": is there a corner that is not one, or a condition against it?"});
    if (c.max_residual > 1e-12)
      failed_checks.push_back({"curves." + c.name + ".max_residual",
                               "is " + format_number(c.max_residual) + ", promised at most 1e-12"});
  }
  return failed_checks;
}

std::vector<FailedCheck> failed_checks(const FairReport& report) {
  Json json = contents(report);
  std::vector<FailedCheck> failed_checks = replace_non_finite_numbers(json);
  const auto conditions = failed_fairing_checks(report.curves);
  failed_checks.insert(failed_checks.end(), conditions.begin(), conditions.end());
  return failed_checks;
}

std::string to_json(const FairReport& report) { return report_text(contents(report), report); }

}  // namespace batten
