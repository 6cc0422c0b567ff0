#include "formats/view3d_matrix.h"

#include <bit>
#include <cmath>

#include <Eigen/Cholesky>
#include <fmt/ostream.h>
#include <glm/glm.hpp>

#include <viewpeel/error.h>

namespace viewpeel {
namespace {

static_assert(std::endian::native == std::endian::little, "the binary layout is little-endian");

constexpr double kCloseTolerance = 1e-7, kLeastSparse = 5e-7;
constexpr int kMostSweeps = 100;
constexpr uint32_t kMostReflectingRows = 20000;
constexpr size_t kHeaderBytes = 30;

// Returns for every row its columns in ascending order, each with the index of its entry. Both directions of a pair are
// present.
std::vector<std::vector<std::pair<uint32_t, uint32_t>>> rowsOf(const View3dMatrix& matrix) {
  std::vector<std::vector<std::pair<uint32_t, uint32_t>>> rows(matrix.rowCount());
  for (uint32_t k = 0; k < matrix.entries.size(); ++k)
    if (const auto& entry = matrix.entries[k]; entry.i != entry.j) rows[entry.j].emplace_back(entry.i, k);
  for (uint32_t k = 0; k < matrix.entries.size(); ++k) rows[matrix.entries[k].i].emplace_back(matrix.entries[k].j, k);
  return rows;
}

// Calls use(i, F_i) for every row i, where F_i is dense.
template <class Use>
void forEachRow(const View3dMatrix& matrix, Use use) {
  const auto rows = rowsOf(matrix);
  std::vector<double> row;
  for (uint32_t i = 0; i < matrix.rowCount(); ++i) {
    row.assign(matrix.rowCount(), 0.0);
    for (const auto& [column, k] : rows[i]) row[column] = matrix.entries[k].exchange_area / matrix.areas[i];
    use(i, row);
  }
}

std::string headerLine(const View3dMatrix& matrix, const View3dHeader& header) {
  const std::string text = fmt::format("View3D 4.0.0 {} {:d} {:d} {}", header.layout, header.is_closed,
                                       header.has_emissivities, matrix.rowCount());
  return text + std::string(kHeaderBytes - std::min(kHeaderBytes, text.size()), ' ');
}

void writeFloats(const std::vector<double>& values, std::ostream& out) {
  const std::vector<float> floats(values.begin(), values.end());
  out.write(reinterpret_cast<const char*>(floats.data()), static_cast<std::streamsize>(floats.size() * sizeof(float)));
}

template <class Format>
void writeLine(const std::vector<double>& values, Format format, std::ostream& out) {
  std::string line;
  for (size_t k = 0; k < values.size(); ++k) {
    if (k) line += ' ';
    fmt::format_to(std::back_inserter(line), format, values[k]);
  }
  out << line << '\n';
}

}  // namespace

View3dMatrix makeView3dMatrix(const FormFactors& form_factors, std::vector<double> emissivities) {
  const Ids& ids = form_factors.ids();
  const std::vector<uint32_t> rows = ids.rows();
  const auto count = static_cast<uint32_t>(emissivities.size());
  View3dMatrix matrix{std::vector<double>(count, 0.0), std::move(emissivities), {}};
  for (uint32_t id = 0; id < ids.count(); ++id)
    if (rows[id] < count) matrix.areas[rows[id]] = ids.areas[id];
  for (const FormFactors::Entry& entry : form_factors.entries())
    if (entry.j < kEnvironment && rows[entry.i] < count && rows[entry.j] < count)
      matrix.entries.push_back({rows[entry.i], rows[entry.j], entry.exchange_area.value});
  return matrix;
}

void dropDistantPairs(View3dMatrix& matrix, const Vs3File& file, const std::vector<uint32_t>& surface_of) {
  std::vector<glm::dvec3> centres(matrix.rowCount(), glm::dvec3(0));
  std::vector<double> counts(matrix.rowCount(), 0);
  for (size_t k = 0; k < file.surfaces.size(); ++k) {
    if (surface_of[k] >= matrix.rowCount()) continue;
    for (const glm::dvec3& corner : file.surfaces[k].corners) centres[surface_of[k]] += corner;
    counts[surface_of[k]] += double(file.surfaces[k].corners.size());
  }
  for (uint32_t row = 0; row < matrix.rowCount(); ++row) centres[row] /= counts[row];
  std::erase_if(matrix.entries, [&](const View3dMatrix::Entry& entry) {
    return glm::distance(centres[entry.i], centres[entry.j]) > file.control.largest_distance;
  });
}

std::vector<double> sumRows(const View3dMatrix& matrix) {
  std::vector<double> sums(matrix.rowCount(), 0);
  for (const View3dMatrix::Entry& entry : matrix.entries) {
    sums[entry.i] += entry.exchange_area / matrix.areas[entry.i];
    if (entry.i != entry.j) sums[entry.j] += entry.exchange_area / matrix.areas[entry.j];
  }
  return sums;
}

bool closeRows(View3dMatrix& matrix, const std::vector<double>& sums) {
  const auto rows = rowsOf(matrix);
  double largest_error = INFINITY;
  for (int sweep = 0; sweep < kMostSweeps && largest_error > kCloseTolerance; ++sweep) {
    largest_error = 0;
    for (uint32_t i = 0; i < matrix.rowCount(); ++i) {
      double sum = 0;
      for (const auto& entry : rows[i]) sum += matrix.entries[entry.second].exchange_area;
      sum /= matrix.areas[i];
      if (!(sum > 0)) continue;
      largest_error = std::max(largest_error, std::abs(sum - sums[i]));
      for (const auto& entry : rows[i]) matrix.entries[entry.second].exchange_area *= sums[i] / sum;
    }
  }
  return largest_error <= kCloseTolerance;
}

// Let row i have area A_i, emissivity eps_i and reflectivity rho_i = 1 - eps_i. With a_i = A_i eps_i / rho_i and
// M = diag(A_i / rho_i) - [A_i F_ij], A_i script-F_ij = a_i (M^-1)_ij a_j, less a_i eps_i where i = j. M is symmetric
// and, as rows of F sum to at most 1, positive definite.
void includeReflections(View3dMatrix& matrix) {
  const uint32_t n = matrix.rowCount();
  if (n > kMostReflectingRows)
    throw Error(ErrorCode::limit,
                fmt::format("emit=1 takes a dense matrix of {} rows; {} are the most, so leave it out", n,
                            kMostReflectingRows));
  Eigen::VectorXd a(n);
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(n, n);
  for (uint32_t i = 0; i < n; ++i) {
    const double reflectivity = 1 - matrix.emissivities[i];
    // A row without area exchanges nothing.
    const double area = matrix.areas[i] > 0 ? matrix.areas[i] : 1.0;
    a[i] = matrix.areas[i] * matrix.emissivities[i] / reflectivity;
    m(i, i) = area / reflectivity;
  }
  for (const auto& entry : matrix.entries) {
    m(entry.i, entry.j) -= entry.exchange_area;
    if (entry.i != entry.j) m(entry.j, entry.i) -= entry.exchange_area;
  }
  const Eigen::MatrixXd inverse = m.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
  matrix.entries.clear();
  for (uint32_t i = 0; i < n; ++i)
    for (uint32_t j = i; j < n; ++j) {
      const double value = a[i] * inverse(i, j) * a[j] - (i == j ? a[i] * matrix.emissivities[i] : 0.0);
      if (value > 0) matrix.entries.push_back({i, j, value});
    }
}

void writeView3dText(const View3dMatrix& matrix, const View3dHeader& header, std::ostream& out) {
  out << headerLine(matrix, header) << '\n';
  writeLine(matrix.areas, FMT_STRING("{:g}"), out);
  forEachRow(matrix, [&](uint32_t, const std::vector<double>& row) { writeLine(row, FMT_STRING("{:.6f}"), out); });
  writeLine(matrix.emissivities, FMT_STRING("{:.3f}"), out);
}

void writeView3dBinary(const View3dMatrix& matrix, const View3dHeader& header, std::ostream& out) {
  out << headerLine(matrix, header) << "\r\n";
  writeFloats(matrix.areas, out);
  forEachRow(matrix, [&](uint32_t, const std::vector<double>& row) { writeFloats(row, out); });
  writeFloats(matrix.emissivities, out);
}

void writeView3dSparse(const View3dMatrix& matrix, std::ostream& out) {
  const auto rows = rowsOf(matrix);
  for (uint32_t i = 0; i < matrix.rowCount(); ++i)
    for (const auto& [column, k] : rows[i])
      if (const double f = matrix.entries[k].exchange_area / matrix.areas[i]; f >= kLeastSparse)
        fmt::print(out, "{} {} {:.6f}\n", i + 1, column + 1, f);
}

}  // namespace viewpeel
