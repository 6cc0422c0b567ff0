// View3D is a rival (G. N. Walton, Calculation of obstructed view factors by adaptive integration, NISTIR 6925, 2002).
// These functions write its input, run its program, and read its output.
#pragma once
#include <iosfwd>
#include <string>

#include "bench/support/exchange_matrix.h"
#include "bench/support/run_time.h"
#include <viewpeel/scene.h>

namespace viewpeel::bench {

// Writes a scene as .vs3. Vertices are in input units with 17 digits, so that the same doubles are read back. Every
// polygon is a surface, with corners counter-clockwise seen from its front.
//   In: epsilon: View3D's own eps, its convergence criterion
void writeView3d(const Scene& scene, double epsilon, std::ostream& out);

// Reads View3D's text output: a line `View3D version out encl emit N`, N areas, N rows of N form factors, and
// emissivities.
//   Out: A_i F_ij in units of the file's areas, (A_i F_ij + A_j F_ji) / 2 of its rows
//   Throws: Error bad_input, naming `name`, where it is not such a file of `polygon_count` surfaces.
ExchangeMatrix readView3d(std::istream& in, uint32_t polygon_count, const std::string& name);

struct View3dRun {
  ExchangeMatrix exchange;  // input units squared
  RunTime time;             // time of the program, its reading and writing included
};

// Runs `program IN OUT` in `directory`.    Throws: Error bad_usage where the program fails; errors of readView3d.
View3dRun runView3d(const std::string& program, const Scene& scene, double epsilon, const std::string& directory);

}  // namespace viewpeel::bench
