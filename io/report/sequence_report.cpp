// SPDX-License-Identifier: MPL-2.0
#include "batten/io/report/sequence_report.h"

#include "batten/io/report/report_json.h"

namespace batten {
namespace {

Json steps_json(const std::vector<SequenceReport::Step>& steps) {
  Json json = Json::array();
  for (const auto& s : steps)
    json.push_back({{"name", s.name},
                    {"type", s.kind},
                    {"frames", s.frames},
                    {"keyframes", s.keyframes},
                    {"iterations", s.iterations},
                    {"unconverged_keyframes", s.unconverged_keyframes},
                    {"last_change", s.last_change},
                    {"seconds", s.seconds}});
  return json;
}

Json parts_json(const std::vector<SequenceReport::Handle>& parts) {
  Json json = Json::array();
  for (const auto& p : parts)
    json.push_back(
        {{"name", p.name}, {"nodes", p.vertices}, {"max_rigid_error", p.max_rigid_error}});
  return json;
}

Json foot_contacts_json(const std::vector<SequenceReport::Foot>& feet) {
  Json json = Json::array();
  for (const auto& f : feet)
    json.push_back({{"operation", f.step},
                    {"handle", f.handle},
                    {"frames", {f.first, f.last}},
                    {"foot_skate_before", f.foot_skate_before},
                    {"foot_skate", f.foot_skate}});
  return json;
}

}  // namespace

std::string to_json(const SequenceReport& report) {
  Json json = report_header(report);
  json["sequence"] = {{"file", report.file},     {"frames_before", report.frames_before},
                      {"frames", report.frames}, {"computed", {report.first, report.last}},
                      {"reused", report.found},  {"nodes", report.nodes},
                      {"faces", report.faces},   {"size", report.size}};
  json["operations"] = steps_json(report.steps);
  json["handles"] = parts_json(report.handles);
  json["features"] = parts_json(report.features);
  json["foot_plants"] = foot_contacts_json(report.feet);
  json["smoothness"] = {{"second_difference_before", report.second_difference_before},
                        {"second_difference", report.second_difference}};
  json["inverted_triangles"] = {{"before", report.inverted_triangles_before},
                                {"after", report.inverted_triangles}};
  add_report_footer(json, report);
  return report_text(std::move(json), report);
}

}  // namespace batten
