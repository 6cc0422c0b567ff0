// The options -o and --exchange of `solve` name the files of this header.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include <viewpeel/solve.h>
#include <viewpeel/write.h>

namespace viewpeel::program {

// Returns the file of exchange factors beside an output: NAME.exchange.csv beside NAME.csv. The extension depends on
// the kind.
std::string exchangeFileOf(const std::string& output, ExchangeKind kind);

// Returns the names of all files that solve writes: each output, followed by its exchange factors if they are
// requested.
std::vector<std::string> heatFilesOf(const std::vector<std::string>& outputs, std::optional<ExchangeKind> exchange);

// Refuses files that cannot be written, and names that occur twice, before the computation.
//   In: has_scene: whether the outputs will have the scene    Throws: Error bad_usage.
void checkHeatOutputs(const std::vector<std::string>& outputs, std::optional<ExchangeKind> exchange, bool has_scene);

// Writes the answers in content.heat: alone in a .csv, with the form factors, unless the heat is alone, in other
// formats.
void writeHeatOutputs(const OutputContent& content, By by, const std::vector<std::string>& outputs);

}  // namespace viewpeel::program
