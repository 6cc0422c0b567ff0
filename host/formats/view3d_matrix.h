// View3dMatrix holds the matrix that View3D's programs exchange: areas, emissivities and exchange areas. The functions
// scale its rows to given sums, include reflections, and write it.
//   Source: G. N. Walton, Calculation of obstructed view factors by adaptive integration, NISTIR 6925, 2002; View3D
//   4.0, viewpp.c and savevf.c. H. C. Hottel & A. F. Sarofim, Radiative Transfer, McGraw-Hill, 1967, 84-86.
#pragma once
#include <cstdint>
#include <ostream>
#include <vector>

#include <viewpeel/form_factors.h>

#include "scene/read_vs3.h"

namespace viewpeel {

struct View3dMatrix {
  struct Entry {
    uint32_t i, j;         // i <= j
    double exchange_area;  // A_i F_ij
  };
  std::vector<double> areas, emissivities;  // of each row
  std::vector<Entry> entries;               // sorted by (i, j)

  uint32_t rowCount() const { return static_cast<uint32_t>(areas.size()); }
};

// Returns the matrix of the first rows of a result, empty rows included: as many rows as there are emissivities.
//   In: emissivities: of these rows    Cost: O(nonzeros).
View3dMatrix makeView3dMatrix(const FormFactors& form_factors, std::vector<double> emissivities);

// Removes pairs of rows whose centres, the means of their corners, are farther apart than the file's maxD.
//   In: surface_of: Vs3Scene::surface_of, the row of each surface of the file    Cost: O(corners + entries).
void dropDistantPairs(View3dMatrix& matrix, const Vs3File& file, const std::vector<uint32_t>& surface_of);

// Returns the sum of F_ij over j, for each row i.    Cost: O(entries).
std::vector<double> sumRows(const View3dMatrix& matrix);

// Scales rows and columns in turn until row i sums to sums[i], as View3D closes an enclosure.
//   Out: whether all rows reach their sums to 1e-7 within 100 sweeps    Cost: O(nonzeros) for each sweep.
bool closeRows(View3dMatrix& matrix, const std::vector<double>& sums);

// Replaces form factors by Hottel's script-F, E (I - F R)^-1 F E with E = diag(emissivity) and R = I - E. The lack of a
// row counts as radiation that is lost.
//   Error: a few ulps of the largest entry times n. Tests: tests/files/view3d_files_test.cpp.
//   Throws: Error limit beyond 20,000 rows.    Cost: O(n^3) work, O(n^2) memory.
void includeReflections(View3dMatrix& matrix);

// View3dHeader is the first line of View3D's output. It has 30 characters and the end of line.
struct View3dHeader {
  uint32_t layout = 0;
  bool is_closed = false, has_emissivities = false;
};

// Writes areas, all F_ij with 6 digits after the point, and emissivities, as text.    Cost: O(n^2).
void writeView3dText(const View3dMatrix& matrix, const View3dHeader& header, std::ostream& out);
// Writes areas, F_ij and emissivities as little-endian float32, 32 + 4 (n^2 + 2 n) bytes with the header of 32 bytes.
//   Cost: O(n^2).
void writeView3dBinary(const View3dMatrix& matrix, const View3dHeader& header, std::ostream& out);
// Writes a line `i j F_ij`, with i and j counted from 1, for each F_ij of at least 5e-7.    Cost: O(nonzeros).
void writeView3dSparse(const View3dMatrix& matrix, std::ostream& out);

}  // namespace viewpeel
