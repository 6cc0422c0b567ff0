// A SolveCommand has the options of `viewpeel solve`. Here are the functions that solve.cpp, solve_stored.cpp and
// solve_matrix_free.cpp share. The first computes form factors, the second reads them, the third keeps none.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include <viewpeel/matrix_free.h>
#include <viewpeel/solve.h>

#include "program/outputs.h"

namespace viewpeel::program {

// MatrixFree says whether solve goes without a matrix in memory. It then computes products of exchange areas with
// radiosities while it peels directions (docs/solve.md, eq. (14)). `automatic` does so where the matrix would not fit
// in memory and no other option needs it.
enum class MatrixFree { automatic, on, off };

struct SolveCommand {
  std::vector<std::string> scene;  // its files
  std::string groups, materials;
  std::vector<std::string> outputs, stored;
  std::vector<PlannedFile> files;  // all outputs, and whether each existed before the run
  Request request;
  std::optional<double> form_factor_tolerance, epsilon;
  double delta = EpsilonDelta{}.delta;
  std::optional<HeatTolerance> tolerance;
  std::optional<ExchangeKind> exchange;
  double drop_below = 0;
  std::optional<glm::dvec3> up;
  MatrixFree matrix_free = MatrixFree::automatic;
  bool quiet = false, json = false;

  bool talks() const { return !quiet && !json; }
};

// Describes the materials in one line.
std::string describeMaterials(const MaterialTable& table, const HeatSolution& solution);
// Describes a tolerance beside the error that was reached.
std::string describeTolerance(const HeatTolerance& tolerance, double reached);
// Warns where the environment of the materials has no effect.
void warnOfEnvironment(const MaterialTable& table, const HeatSolution& solution);

// Reads the materials, with warnings.    Throws: as readMaterials; Error bad_usage for --up without sky and ground.
MaterialTable readTable(const SolveCommand& command);
// Writes exchange factors beside each output.
void writeExchanges(const SolveCommand& command, const FormFactors& form_factors, const Enclosure& enclosure);
// Writes answers and the form factors that they were computed from, and prints the answers.
//   In: content: with the solution in content.heat
void conclude(const SolveCommand& command, const MaterialTable& table, const HeatSolution& solution,
              const OutputContent& content);
// Prints answers, and the form factors that they were computed from, as JSON.
//   In: found: the run on a scene; nullptr where form factors come from files
void printJson(const SolveCommand& command, const HeatSolution& heat, const FormFactors& form_factors,
               const Estimate& estimate, const SceneHeat* found);
// Solves with the form factors of --from-result. Returns the exit status.
int solveStored(const SolveCommand& command);

// Refuses --matrix-free on, or directional emissivities, beside an option or a material that needs form factors.
//   Throws: Error bad_usage.
void checkMatrixFree(const SolveCommand& command, const MaterialTable& table);
// Returns whether the answers are to be found without a matrix. checkMatrixFree() has to come first.
bool isMatrixFree(const SolveCommand& command, const MaterialTable& table, const Scene& scene);
// Solves without a matrix, and prints and writes the answers. Returns the exit status.
int solveWithoutMatrix(const SolveCommand& command, const MaterialTable& table, const Scene& scene);

}  // namespace viewpeel::program
