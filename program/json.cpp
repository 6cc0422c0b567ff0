#include "program/json.h"

#include <iostream>

#include <fmt/format.h>

#include "program/command_line.h"
#include "program/json_error.h"
#include "program/warnings.h"
#include "io/writers.h"

namespace viewpeel::program {
namespace {

// Returns a JSON number where the text is a number, else the text.
Json valueOf(const std::string& text) {
  Json number = Json::parse(text, nullptr, false);
  return number.is_number() ? number : Json(text);
}

Json givenJson(const GivenOption& option) {
  if (option.is_flag) return true;
  Json values = Json::array();
  for (const std::string& value : option.values) values.push_back(option.is_text ? Json(value) : valueOf(value));
  return values.size() == 1 ? values[0] : values;
}

std::string textOf(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace); }

}  // namespace

Json startReport() {
  Json options = Json::object();
  for (const GivenOption& option : givenOptions()) options[option.name] = givenJson(option);
  return {{"version", VIEWPEEL_VERSION},
          {"command", commandName()},
          {"command_line", commandLine()},
          {"options", std::move(options)}};
}

Json jsonOf(const std::vector<PlannedFile>& files) {
  Json all = Json::array();
  for (const PlannedFile& file : files) all.push_back({{"name", file.name}, {"replaced", file.replaces}});
  return all;
}

Json jsonOf(const std::vector<std::pair<std::string, std::string>>& settings) {
  Json all = Json::object();
  for (const auto& [name, value] : settings) all[name] = valueOf(value);
  return all;
}

void printReport(Json report) {
  report["warnings"] = warnings();
  fmt::print("{}\n", textOf(report));
}

void printReport(Json report, const OutputContent& content) {
  report["warnings"] = warnings();
  const std::string text = textOf(report);
  std::cout << text.substr(0, text.rfind("\n}")) << ",\n";
  writeJsonMembers(content, std::cout);
  std::cout << "\n}\n" << std::flush;
}

std::string errorAsJson(const std::string& message, int status) {
  Json report = {{"version", VIEWPEEL_VERSION}};
  if (!commandName().empty()) report["command"] = commandName();
  report["command_line"] = commandLine();
  report["error"] = message;
  report["status"] = status;
  report["warnings"] = warnings();
  return textOf(report) + "\n";
}

}  // namespace viewpeel::program
