#include "program/outputs.h"

#include <exception>
#include <filesystem>
#include <set>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include <viewpeel/write.h>

namespace viewpeel::program {

void checkOutputs(const std::vector<std::string>& outputs, const std::string& checkpoint, bool with_balance) {
  namespace fs = std::filesystem;
  std::set<fs::path> named;
  const auto name = [&](const fs::path& file) {
    std::error_code failure;  // a folder that cannot be looked into is refused below
    const fs::path place = fs::weakly_canonical(fs::absolute(file, failure), failure);
    if (!named.insert(place.empty() ? file : place).second)
      throw Error(ErrorCode::bad_usage, fmt::format("{}: is to be written twice; name every file once", file.string()));
  };
  for (const std::string& output : outputs)
    for (const fs::path& file : filesOf(output, with_balance)) name(file);
  if (!checkpoint.empty()) name(checkpoint);
  for (const std::string& output : outputs) checkOutput(output, with_balance);
}

void writeOutputs(const FormFactors& form_factors, const std::vector<std::string>& outputs,
                  const FormFactors* balanced) {
  std::exception_ptr first_failure;
  for (const std::string& output : outputs) {
    try {
      writeFormFactors(form_factors, output, balanced);
    } catch (const Error&) {
      if (!first_failure) first_failure = std::current_exception();
    }
  }
  if (first_failure) std::rethrow_exception(first_failure);
}

}  // namespace viewpeel::program
