// The options -o and --checkpoint name these files.
#pragma once
#include <string>
#include <vector>

#include <viewpeel/form_factors.h>

namespace viewpeel::program {

// That every file can be written, and none over another: before anything is computed.
//   In: checkpoint: empty where there is none
//   Throws: Error bad_usage.
void checkOutputs(const std::vector<std::string>& outputs, const std::string& checkpoint, bool with_balance = false);

// Writes all of them, also where one fails.
//   In: balanced: nullptr where --balance is not given
//   Throws: the first error of all files.
void writeOutputs(const FormFactors& form_factors, const std::vector<std::string>& outputs,
                  const FormFactors* balanced = nullptr);

}  // namespace viewpeel::program
