// solveMatrixFree() solves the heat of scenes whose form factors would not fit in memory. Each product of the matrix
// with a vector is summed while directions are peeled.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>

#include <viewpeel/solve.h>

namespace viewpeel {

// A MatrixFreeRequest says which rows are meant, and how exact answers have to be.
struct MatrixFreeRequest {
  By by = By::polygon;
  bool two_sided = false;
  std::optional<HeatTolerance> tolerance;  // without: 1 % of all heat, or 1 K where all heat fluxes are given
  uint32_t first_directions = 32;          // of each of the 8 replicates in the first round, above 0
  int resolution = 0;      // lattice spacings across the unit ball's diameter; 0: one to a polygon's side
  double residual = 1e-7;  // conjugate gradients end there, as a share of the right side; above 0
  uint64_t seed = 1;       // the same seed gives the same bits
  uint32_t threads = 0;    // 0: one for each core
  std::optional<double> time_limit_s;
  Ranks* ranks = nullptr;  // rank 0 of several that share the sweeps (ranks.h); others call serveRanks()
};

// A MatrixFreeObserver watches a run. Each function may be empty.
struct MatrixFreeObserver {
  // The run calls this before each direction, from any thread. If it returns true the run ends with the answers of the
  // last whole round.
  std::function<bool()> should_stop;
  // The run calls this after some directions of a product of the matrix with a vector, from its own thread.
  //   product: number of the product, from 1; largest_error: the largest standard error after the last round, in the
  //   tolerance's quantity; infinite before
  std::function<void(uint64_t product, uint64_t directions, uint64_t directions_of_product, double largest_error)>
      on_progress;
};

// A MatrixFreeHeat has the answers of the last round of directions.
struct MatrixFreeHeat {
  HeatSolution heat;
  HeatTolerance tolerance;  // the request's, or the default
  uint32_t replicates = 0, rounds = 0;
  uint64_t directions = 0;    // of all replicates of the last round together
  uint64_t sweeps = 0;        // of the scene along a direction, in all rounds
  uint64_t memory_bytes = 0;  // of sweeps and vectors; the scene's memory comes on top
  int resolution = 0;         // lattice spacings across the unit ball's diameter
  double seconds = 0;
  bool is_reached = true;       // false where time was up or the observer stopped the run before the tolerance
  bool is_interrupted = false;  // the observer stopped the run
};

// Returns the bytes that form factors between these rows would take in solveScene, if each row saw each.
//   Cost: O(1).
double matrixBytes(uint64_t rows);
// Where form factors would take more than this, `viewpeel solve` makes no matrix. It is the same on all machines, so
// that the same command has the same answers.
constexpr double kMostMatrixBytes = 4.0 * (1u << 30);

// Solves the enclosure of a scene without form factors in memory: docs/solve.md, eq. (1) to (6) and (14).
//   x_ij = (2 / N) sum_u A'_ij(u) estimates the exchange areas from N common directions u. A'_ij(u) is the area of the
//   lines along u on which i and j are a facing pair. Directions are peeled again for each product of the matrix x with
//   a vector.
//   Rows whose emissivity depends on the angle are split into an emitter and a reflector, whose lines are weighted in
//   each direction: docs/method.md, section 15.
//   In: scene; materials: grey and diffuse, with bands of wavelengths, or directional; request
//   Out: see MatrixFreeHeat. The first round's answers are kept where a later one is stopped.
//   Error: standard errors come from 8 replicates, carried to first order, and from what one line more could add to a
//     row. The equations are solved to request.residual. Tests: tests/unit/matrix_free_test.cpp, against the same
//     counts in a matrix, closed forms and form factors.
//   Throws: as assignMaterials, before anything is computed; Error bad_input as solveHeat; limit where time is up, or
//   the observer stops the run, before the first round is done.
//   Cost: in each round two dozens of sweeps of all directions, more where emissivities are small; memory of 600 bytes
//     a row and some 700 more for each thread. With bands, twice the sweeps, and memory times the number of bands.
//   Source: R. Barrett et al., Templates for the Solution of Linear Systems, SIAM 1994 (conjugate gradients).
MatrixFreeHeat solveMatrixFree(const Scene& scene, const MaterialTable& materials,
                               const MatrixFreeRequest& request = {}, const MatrixFreeObserver& observer = {});

}  // namespace viewpeel
