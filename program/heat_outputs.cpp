#include "program/heat_outputs.h"

#include <filesystem>

#include <fmt/format.h>

#include "program/outputs.h"
#include <viewpeel/error.h>

namespace viewpeel::program {
namespace {

bool hasFormFactors(const std::string& output) {
  return output.ends_with(".h5") || output.ends_with(".html") || output.ends_with(".vtp");
}

}  // namespace

std::string exchangeFileOf(const std::string& output, ExchangeKind kind) {
  return std::filesystem::path(output).replace_extension(exchangeExtension(kind)).string();
}

std::vector<std::string> heatFilesOf(const std::vector<std::string>& outputs, std::optional<ExchangeKind> exchange) {
  std::vector<std::string> names;
  for (const std::string& output : outputs) {
    names.push_back(output);
    if (exchange) names.push_back(exchangeFileOf(output, *exchange));
  }
  return names;
}

void checkHeatOutputs(const std::vector<std::string>& outputs, std::optional<ExchangeKind> exchange, bool has_scene) {
  if (exchange && outputs.empty())
    throw Error(ErrorCode::bad_usage, "--exchange writes NAME.exchange.csv beside NAME.csv; give -o NAME.csv");
  const std::vector<std::string> names = heatFilesOf(outputs, exchange);
  requireDistinct({names.begin(), names.end()});
  for (const std::string& output : outputs) {
    if (hasFormFactors(output)) checkOutput(output, false, has_scene);
    else if (output.ends_with(".csv")) checkHeatOutput(output);
    else
      throw Error(
          ErrorCode::bad_usage,
          fmt::format("{}: unknown output format of heat; use a name that ends in .csv, .h5, .vtp or .html", output));
    if (exchange) checkExchangeOutput(exchangeFileOf(output, *exchange), *exchange);
  }
}

void writeHeatOutputs(const OutputContent& content, By by, const std::vector<std::string>& outputs) {
  for (const std::string& output : outputs)
    if (hasFormFactors(output)) writeFormFactors(content, output);
    else writeHeat(*content.heat, by, output);
}

}  // namespace viewpeel::program
