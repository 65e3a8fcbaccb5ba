// SPDX-License-Identifier: MPL-2.0
#include "batten/io/sessions/session_log.h"

#include <optional>
#include <sstream>

#include "batten/io/files/atomic_file.h"
#include "batten/io/files/input_file.h"
#include "batten/io/scene/scene_parsing.h"
#include "batten/io/sessions/session_log_entities.h"

namespace batten {
namespace {

using namespace session_log;
using session_log::json_of;

LogJson json_of(const Operation::Edit& edit) {
  return std::visit(
      Overloaded{
          [](const Operation::Add& add) {
            LogJson json = {{"do", "add"}};
            const char* key[] = {"load", "stiffness", "constraint", "offset", "curve"};
            std::visit([&](const auto& what) { json[key[add.what.index()]] = json_of(what); },
                       add.what);
            for (const auto& p : add.parameters) json["parameters"].push_back(json_of(p));
            return json;
          },
          [](const Operation::Change& change) {
            return LogJson{{"do", "change"}, {"constraint", json_of(change.constraint)}};
          },
          [](const Operation::Remove& remove) {
            return LogJson{{"do", "remove"}, {"name", remove.name}};
          },
          [](const Operation::SetLine& set) {
            return LogJson{
                {"do", "set_curve"}, {"name", set.line}, {"geometry", json_of(set.curve)}};
          },
          [](const Refinement& r) {
            LogJson json = {{"do", "refine"}};
            if (const auto* brush = std::get_if<Refinement::Brush>(&r.where))
              json["strokes"] = json_of(brush->strokes);
            else
              json["fraction"] = json_number(std::get<Refinement::JumpIndicator>(r.where).fraction);
            json["min_edge_length"] = json_number(r.smallest);
            json["max_triangles"] = r.max_triangles;
            return json;
          },
          [](const Motion& m) {
            return LogJson{{"do", "start_motion"},
                           {"dt", json_number(m.dt)},
                           {"density", json_number(m.density)},
                           {"damping", json_number(m.damping)},
                           {"theta", json_number(m.theta)}};
          },
          [](const Operation::AddParameter& add) {
            return LogJson{{"do", "add_parameter"}, {"parameter", json_of(add.parameter)}};
          },
          [](const Operation::SetRule& set_rule) {
            return LogJson{{"do", "drive"},
                           {"name", set_rule.parameter},
                           {"terms", json_of(set_rule.rule_terms)},
                           {"offset", json_number(set_rule.offset)}};
          }},
      edit);
}

LogJson json_of(const Operation& operation) {
  using Kind = Operation::Kind;
  switch (operation.kind) {
    case Kind::Set:
      return {
          {"do", "set"}, {"parameter", operation.index}, {"value", json_number(operation.value)}};
    case Kind::SolvePreview:
      return {{"do", "update"},
              {"iterations", operation.index},
              {"tolerance", json_number(operation.value)}};
    case Kind::Time:
      return {{"do", "time"}, {"value", json_number(operation.value)}};
    case Kind::SolveToEquilibrium:
      return {{"do", "solve"}};
    case Kind::Step:
      return {{"do", "step"}};
    case Kind::StopMotion:
      return {{"do", "stop_motion"}};
    case Kind::Undo:
      return {{"do", "undo"}};
    case Kind::Redo:
      return {{"do", "redo"}};
    case Kind::Edit:
      break;
  }
  if (!operation.edit)
    throw InputError("session log: found an edit operation without data, expected its data");
  return json_of(*operation.edit);
}

/// The JSON object of one operation, with its position in the log.
struct OperationObject {
  const LogJson& json;
  const std::string& where;
  /// The object, checked to have no other keys than "do" and these.
  LogObject with(std::vector<std::string> keys) const {
    keys.emplace_back("do");
    return LogObject(json, where, "the operation", keys);
  }
};

/// The value of "do"; other keys are not checked.
std::string operation_name(const OperationObject& operation) {
  if (!operation.json.is_object() || !operation.json.contains("do"))
    throw InputError(operation.where + "found no \"do\", expected {\"do\": …}");
  std::vector<std::string> all;
  for (const auto& [key, value] : operation.json.items()) all.push_back(key);
  return LogObject(operation.json, operation.where, "the operation", all).text("do");
}

/// Parses an operation without edit data: parameter values, solves, time steps, undo. nullopt for
/// other names.
std::optional<Operation> simple_operation_of(const std::string& operation_kind,
                                             const OperationObject& operation) {
  using Kind = Operation::Kind;
  if (operation_kind == "set") {
    const LogObject o = operation.with({"parameter", "value"});
    return Operation{Kind::Set, o.integer("parameter", 0), o.number("value"), nullptr};
  }
  if (operation_kind == "update") {
    const LogObject o = operation.with({"iterations", "tolerance"});
    return Operation{Kind::SolvePreview, o.integer("iterations", 0), o.number("tolerance"),
                     nullptr};
  }
  if (operation_kind == "time")
    return Operation{Kind::Time, 0, operation.with({"value"}).number("value"), nullptr};
  for (const auto& [kind, name] : {std::pair{Kind::SolveToEquilibrium, "solve"},
                                   {Kind::Step, "step"},
                                   {Kind::StopMotion, "stop_motion"},
                                   {Kind::Undo, "undo"},
                                   {Kind::Redo, "redo"}})
    if (operation_kind == name) {
      operation.with({});
      return Operation{kind, 0, 0, nullptr};
    }
  return std::nullopt;
}

/// Parses an addition: one entity with its parameters.
Operation::Add addition_of(const OperationObject& operation) {
  const std::vector<std::string> kinds = {"load", "stiffness", "constraint", "offset", "curve"};
  std::vector<std::string> keys = kinds;
  keys.emplace_back("parameters");
  const LogObject o = operation.with(keys);
  const auto what = [&]() -> decltype(Operation::Add::what) {
    if (o.has("load")) return load_of(o);
    if (o.has("stiffness")) return stiffness_of(o);
    if (o.has("constraint")) return constraint_of(o);
    if (o.has("offset")) return offset_of(o);
    if (o.has("curve")) return character_line_of(o);
    o.fail("'add' without an item", "one of: " + comma_separated(kinds));
  };
  return {what(), parameters_of(o)};
}

/// Parses a mesh refinement: where and how far triangles are bisected.
Refinement refinement_of(const OperationObject& operation) {
  const LogObject o = operation.with({"strokes", "fraction", "min_edge_length", "max_triangles"});
  Refinement refinement;
  if (o.has("strokes"))
    refinement.where = Refinement::Brush{strokes_of(o, "strokes")};
  else
    refinement.where = Refinement::JumpIndicator{o.number("fraction")};
  refinement.smallest = o.number("min_edge_length");
  refinement.max_triangles = o.integer("max_triangles", 1);
  return refinement;
}

/// Parses an edit. nullopt for other names.
std::optional<Operation::Edit> edit_of(const std::string& operation_kind,
                                       const OperationObject& operation) {
  if (operation_kind == "add") return addition_of(operation);
  if (operation_kind == "change")
    return Operation::Change{constraint_of(operation.with({"constraint"}))};
  if (operation_kind == "remove") return Operation::Remove{operation.with({"name"}).text("name")};
  if (operation_kind == "set_curve") {
    const LogObject o = operation.with({"name", "geometry"});
    return Operation::SetLine{o.text("name"), curve_of(o, "geometry")};
  }
  if (operation_kind == "refine") return refinement_of(operation);
  if (operation_kind == "start_motion") {
    const LogObject o = operation.with({"dt", "density", "damping", "theta"});
    return Motion{o.number("dt"), o.number("density"), o.number("damping"), o.number("theta")};
  }
  if (operation_kind == "add_parameter")
    return Operation::AddParameter{parameter_of(operation.with({"parameter"}))};
  if (operation_kind == "drive") {
    const LogObject o = operation.with({"name", "terms", "offset"});
    return Operation::SetRule{o.text("name"), terms_of(o, "terms"), o.number("offset")};
  }
  return std::nullopt;
}

/// Parses any operation.
Operation operation_of(const LogJson& json, const std::string& where) {
  const OperationObject operation{json, where};
  const std::string name = operation_name(operation);
  if (const auto plain = simple_operation_of(name, operation)) return *plain;
  if (auto edit = edit_of(name, operation))
    return {Operation::Kind::Edit, 0, 0, std::make_shared<const Operation::Edit>(std::move(*edit))};
  const std::vector<std::string> names = {
      "add_parameter", "drive", "time", "set",    "solve",  "update",    "step",   "stop_motion",
      "undo",          "redo",  "add",  "change", "remove", "set_curve", "refine", "start_motion"};
  throw InputError(where + "found \"do\": \"" + name + "\", expected " +
                   expected_one_of(name, names));
}

constexpr int kVersion = 2;

/// Throws InputError if the header of a log names another version of the format.
void check_version(const LogJson& header, const std::string& where) {
  const bool given = header.contains("version");
  if (!given || header["version"] != kVersion)
    throw InputError(where + "found " +
                     (given ? "version " + header["version"].dump() : "no version") +
                     " of the session log format, expected version " + std::to_string(kVersion) +
                     ": record the session again with this program");
}

}  // namespace

std::string session_log_text(const std::vector<Operation>& operations) {
  std::string text = LogJson{{"batten", "session"}, {"version", kVersion}}.dump() + "\n";
  for (const Operation& operation : operations)
    text += json_of(operation).dump(-1, ' ', false, LogJson::error_handler_t::replace) + "\n";
  return text;
}

void write_session_log(const std::filesystem::path& file,
                       const std::vector<Operation>& operations) {
  const std::string text = session_log_text(operations);
  write_file_atomically(file, [&](std::ostream& out) { out << text; });
}

std::vector<Operation> parse_session_log(const std::string& text,
                                         const std::filesystem::path& file) {
  check_nesting_depth(text, file.string());
  std::vector<Operation> operations;
  std::istringstream lines(text);
  int count = 0;
  for (std::string line; std::getline(lines, line);) {
    const std::string where = file.string() + ":" + std::to_string(++count) + ": ";
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    LogJson json;
    try {
      json = LogJson::parse(line);
    } catch (const LogJson::exception&) {
      throw InputError(where + "found a line that is not JSON or is cut off, expected {\"do\": …}");
    }
    if (count == 1) {
      if (!json.is_object() || !json.contains("batten") || json["batten"] != "session")
        throw InputError(
            where + "found another file than a session log, expected {\"batten\":\"session\",…}");
      check_version(json, where);
      continue;
    }
    try {
      operations.push_back(operation_of(json, where));
    } catch (const InputError& e) {
      const std::string message = e.what();
      throw InputError(message.starts_with(where) ? message : where + message);
    }
  }
  if (count == 0)
    throw InputError(file.string() + ":1: found an empty file, expected a session log");
  return operations;
}

std::vector<Operation> read_session_log(const std::filesystem::path& file) {
  return parse_session_log(read_input_file(file, "a session log"), file);
}

}  // namespace batten
