// These tests read radiation conductors of thermal networks by the rules of ESATAN's and SINDA's model files.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <viewpeel/error.h>
#include <viewpeel/solve.h>
#include "tests/support/enclosures.h"
#include "tests/support/python.h"
#include "tests/support/random_form_factors.h"
#include "tests/support/test_folder.h"

namespace viewpeel {
namespace {

namespace te = test_enclosures;

class Conductors : public TestFolder {};

// Returns the form factors of an open enclosure. All numbers differ, and no network would accept its names.
FormFactors openEnclosure() {
  Ids ids;
  for (uint32_t k = 0; k < 6; ++k) {
    ids.names.push_back(fmt::format("wall {};\n#{}", k, k));
    ids.areas.push_back(1 + 0.37 * k);
    ids.surface.push_back(k);
  }
  const FormFactors f = randomFormFactors(ids, 31, 0.8);
  std::vector<FormFactors::Entry> entries;
  for (const FormFactors::Entry& entry : f.entries())
    if (entry.j != kLeak) entries.push_back(entry);
  return {ids, std::move(entries), f.rowSums()};
}

// A network of these conductors has the heat flows that solve finds: sigma sum_j GR_ij (T_i^4 - T_j^4).
TEST_F(Conductors, NetworksHaveTheHeatFlowsOfTheEnclosure) {
  const FormFactors f = openEnclosure();
  std::vector<Material> materials;
  std::vector<double> temperatures;
  for (uint32_t k = 0; k < f.ids().count(); ++k) {
    temperatures.push_back(300 + 50.0 * k);
    materials.push_back(te::hot(0.35 + 0.1 * k, temperatures.back()));
  }
  Enclosure enclosure = te::enclosureOf(f, materials);
  enclosure.environment_temperature = 200;
  const HeatSolution solution = solveHeat(f, enclosure);
  const ExchangeFactors factors = findExchangeFactors(f, enclosure);
  for (const ExchangeKind kind : {ExchangeKind::esatan, ExchangeKind::sinda})
    writeExchange(factors, kind, folder_ / (std::string("net") + exchangeExtension(kind)));
  std::vector<double> flows;
  for (const HeatRow& row : solution.rows) flows.push_back(row.heat_flow.value);
  const PythonResult result =
      runPython(folder_, fmt::format("T, Q, sigma = {}, {}, {}\n", temperatures, flows, kStefanBoltzmann) + R"(
import re, numpy as np
# ESATAN: statements end with ';', comments begin with '#', blocks with '$'.
def esatan():
    text = re.sub('#[^\n]*', '', open('net.exchange.d').read())
    block, body = text.split('$CONDUCTORS')
    assert not block.strip()
    for statement in body.split(';')[:-1]:
        name, a, b, value = re.fullmatch(r'\s*(GR)\((\d+),(\d+)\) = (\S+)\s*', statement).groups()
        yield int(a), int(b), float(value)
    assert not body.split(';')[-1].strip()
# SINDA: a C in column 1 begins a comment, HEADER a block; number, nodes, value; radiative where the number is negative.
def sinda():
    numbers, block = set(), ''
    for line in open('net.exchange.inp'):
        if line.startswith('C'):
            continue
        if line.startswith('HEADER'):
            block = line.strip()
            continue
        assert block == 'HEADER CONDUCTOR DATA, MAIN'
        number, a, b, value = line.split(',')
        assert int(number) < 0 and int(number) not in numbers
        numbers.add(int(number))
        yield int(a), int(b), float(value)
def flows(conductors, order=range(6)):
    power = {k + 1: sigma * T[order[k]]**4 for k in range(6)} | {99999: sigma * 200.**4}
    q = dict.fromkeys(power, 0.)
    for a, b, value in conductors:
        q[a] += value * (power[a] - power[b])
        q[b] -= value * (power[a] - power[b])
    return np.array([q[k + 1] for k in range(6)])
both = list(esatan()), list(sinda())
assert both[0] == both[1] and len({(a, b) for a, b, _ in both[0]}) == len(both[0]) and all(a < b for a, b, _ in both[0])
scale = max(map(abs, Q))
assert abs(flows(both[0]) - Q).max() < 1e-10 * scale, abs(flows(both[0]) - Q).max() / scale
assert abs(flows(both[0], [1, 0, 2, 3, 4, 5]) - Q).max() > 1e-2 * scale
print('passed')
)");
  EXPECT_NE(result.output.find("passed"), std::string::npos) << result.output;
}

TEST_F(Conductors, ConductorsNeedTheirEndings) {
  const ExchangeFactors none;
  EXPECT_THROW(writeExchange(none, ExchangeKind::esatan, folder_ / "net.csv"), Error);
  EXPECT_THROW(checkExchangeOutput(folder_ / "net.d", ExchangeKind::sinda), Error);
  EXPECT_NO_THROW(checkExchangeOutput(folder_ / "net.d", ExchangeKind::esatan));
}

}  // namespace
}  // namespace viewpeel
