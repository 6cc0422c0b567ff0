// writeExchange() writes exchange factors as tables, and as conductors of thermal networks.
//   Sources: ESATAN-TMS's model files, $CONDUCTORS; SINDA's, HEADER CONDUCTOR DATA, where a negative number makes a
//   conductor radiative.
#include <viewpeel/solve.h>

#include <fmt/ostream.h>

#include "io/csv.h"
#include "io/write_file.h"
#include <viewpeel/error.h>

namespace viewpeel {
namespace {

void writeTable(const ExchangeFactors& factors, bool is_gebhart, std::ostream& out) {
  fmt::print(out, "from,to,{},conductor\n", is_gebhart ? "gebhart" : "script_f");
  std::vector<std::vector<std::pair<uint32_t, double>>> rows(factors.names.size());
  for (const ExchangeFactors::Entry& entry : factors.entries)
    if (entry.j < kEnvironment && entry.j != entry.i) rows[entry.j].emplace_back(entry.i, entry.conductor);
  for (const ExchangeFactors::Entry& entry : factors.entries) rows[entry.i].emplace_back(entry.j, entry.conductor);
  for (size_t i = 0; i < rows.size(); ++i) {
    const double all = factors.areas[i] * (is_gebhart ? factors.emissivities[i] : 1);
    for (const auto& [j, conductor] : rows[i])
      fmt::print(out, "{},{},{},{}\n", quoteName(factors.names[i]),
                 j == kEnvironment ? "environment" : quoteName(factors.names[j]), conductor / all, conductor);
  }
}

// Returns a name without control characters, for a comment of one line.
std::string oneLine(std::string name) {
  for (char& c : name)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = '?';
  return name;
}

void writeNetwork(const ExchangeFactors& factors, bool is_esatan, std::ostream& out) {
  if (factors.names.size() >= kEnvironmentNode)
    throw Error(ErrorCode::limit,
                fmt::format("a thermal network has up to {} rows here; use --by surface", kEnvironmentNode - 1));
  const char* comment = is_esatan ? "#" : "C";
  fmt::print(out, "{} Radiation conductors A e B in units of length squared; sigma is not in them.\n", comment);
  for (size_t i = 0; i < factors.names.size(); ++i)
    fmt::print(out, "{} node {}: {}, area {}, emissivity {}\n", comment, i + 1, oneLine(factors.names[i]),
               factors.areas[i], factors.emissivities[i]);
  fmt::print(out, "{} node {}: environment\n{}\n", comment, kEnvironmentNode,
             is_esatan ? "$CONDUCTORS" : "HEADER CONDUCTOR DATA, MAIN");
  uint64_t number = 0;
  for (const ExchangeFactors::Entry& entry : factors.entries) {
    if (entry.i == entry.j) continue;
    const uint32_t to = entry.j == kEnvironment ? kEnvironmentNode : entry.j + 1;
    if (is_esatan) fmt::print(out, "GR({},{}) = {};\n", entry.i + 1, to, entry.conductor);
    else fmt::print(out, "      -{}, {}, {}, {}\n", ++number, entry.i + 1, to, entry.conductor);
  }
}

void requireExtension(const std::filesystem::path& file, ExchangeKind kind) {
  const std::filesystem::path extension = std::filesystem::path(exchangeExtension(kind)).extension();
  if (file.extension() != extension)
    throw Error(ErrorCode::bad_usage, fmt::format("{}: exchange factors of this kind need a name that ends in {}",
                                                  file.string(), extension.string()));
}

}  // namespace

const char* exchangeExtension(ExchangeKind kind) {
  return kind == ExchangeKind::esatan ? ".exchange.d" : kind == ExchangeKind::sinda ? ".exchange.inp" : ".exchange.csv";
}

void writeExchange(const ExchangeFactors& factors, ExchangeKind kind, std::ostream& out) {
  if (kind == ExchangeKind::gebhart || kind == ExchangeKind::script_f)
    writeTable(factors, kind == ExchangeKind::gebhart, out);
  else writeNetwork(factors, kind == ExchangeKind::esatan, out);
}

void writeExchange(const ExchangeFactors& factors, ExchangeKind kind, const std::filesystem::path& file) {
  requireExtension(file, kind);
  writeFile(file, [&](std::ostream& out) { writeExchange(factors, kind, out); });
}

void checkExchangeOutput(const std::filesystem::path& file, ExchangeKind kind) {
  requireExtension(file, kind);
  checkWritable(file);
}

}  // namespace viewpeel
