#include "report/shrink_content.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <utility>

#include <fmt/format.h>

#include "report/variable_length.h"

namespace viewpeel {
namespace {

size_t toBase64Bytes(size_t bytes) { return (bytes + 2) / 3 * 4; }

std::vector<int32_t> surfacesOfRows(const ReportContent& content) {
  std::vector<int32_t> surfaces(content.names.size(), -1);  // an empty row has no polygon
  const ReportGeometry& geometry = content.geometry;
  for (size_t k = 0; k < geometry.row_of_polygon.size(); ++k)
    surfaces[geometry.row_of_polygon[k]] = geometry.surface_of_polygon[k];
  return surfaces;
}

std::vector<double> meanOverAreas(const ReportContent& content, const std::vector<double>& values,
                                  const std::vector<int32_t>& surface_of_row, const std::vector<double>& areas) {
  std::vector<double> means(areas.size(), 0.0);
  for (size_t row = 0; row < values.size(); ++row) {
    const int32_t surface = surface_of_row[row];
    if (surface >= 0 && areas[surface] > 0) means[surface] += content.areas[row] * values[row] / areas[surface];
  }
  return means;
}

// A SurfaceRow adds up the rows of one surface.
class SurfaceRow {
 public:
  explicit SurfaceRow(size_t surface_count) : of_surface_(surface_count) {}

  // Adds the entries of a row of the surface.
  //   In: share: the row's part of the surface's area
  void add(const ReportContent& content, int64_t row, double share, const std::vector<int32_t>& surface_of_row) {
    for (int64_t k = content.starts[row]; k < content.starts[row + 1]; ++k) {
      const int32_t surface = surface_of_row[content.to[k]];
      if (surface < 0) continue;
      Sums& sums = of_surface_[surface];
      if (!std::exchange(sums.is_listed, true)) listed_.push_back(surface);
      sums.form_factor += share * content.form_factors[k];
      sums.standard_error += share * content.standard_errors[k];
      if (!content.hasIntervals()) continue;
      sums.lower += share * content.lower[k];
      sums.upper += share * content.upper[k];
    }
  }

  // Appends the row to a content and begins another.
  void appendTo(ReportContent& content, bool has_intervals) {
    std::ranges::sort(listed_);
    for (int32_t surface : listed_) {
      const Sums sums = std::exchange(of_surface_[surface], Sums{});
      content.to.push_back(surface);
      content.form_factors.push_back(sums.form_factor);
      content.standard_errors.push_back(sums.standard_error);
      if (has_intervals) content.lower.push_back(sums.lower), content.upper.push_back(sums.upper);
    }
    listed_.clear();
    content.starts.push_back(static_cast<int64_t>(content.to.size()));
  }

 private:
  struct Sums {
    double form_factor = 0, standard_error = 0, lower = 0, upper = 0;
    bool is_listed = false;
  };

  std::vector<Sums> of_surface_;
  std::vector<int32_t> listed_;
};

}  // namespace

double unlistedBound(const ReportContent& content) {
  for (const auto& [name, value] : content.parameters)
    if (name == "unlisted_bound") {
      double bound = INFINITY;  // a text that is no number gives no bound
      std::from_chars(value.data(), value.data() + value.size(), bound);
      return bound;
    }
  return 0;
}

size_t pageBytesOfEntries(const ReportContent& content, size_t width) {
  size_t bytes = 0;
  for (int64_t row = 0; row < content.rowCount(); ++row) {
    int32_t before = 0;
    for (int64_t k = content.starts[row]; k < content.starts[row + 1]; ++k) {
      bytes += variableLength(static_cast<uint32_t>(content.to[k] - before));
      before = content.to[k];
    }
  }
  return toBase64Bytes(bytes + content.to.size() * width * (content.hasIntervals() ? 4 : 2));
}

ReportContent addUpBySurface(const ReportContent& content) {
  const bool has_intervals = content.hasIntervals() && unlistedBound(content) == 0;
  const std::vector<int32_t> surface_of_row = surfacesOfRows(content);
  const size_t surface_count = content.geometry.surface_names.size();
  ReportContent sums;
  sums.names = content.geometry.surface_names;
  sums.areas.assign(surface_count, 0.0);
  std::vector<std::vector<int64_t>> rows_of_surface(surface_count);
  for (int64_t row = 0; row < content.rowCount(); ++row) {
    const int32_t surface = surface_of_row[row];
    if (surface < 0) continue;
    sums.areas[surface] += content.areas[row];
    rows_of_surface[surface].push_back(row);
  }
  for (const ReportColumn& column : content.columns)
    if (!column.name.starts_with("temperature") && column.unit != "W")
      sums.columns.push_back(
          {column.name, column.unit, meanOverAreas(content, column.values, surface_of_row, sums.areas)});
  sums.starts.push_back(0);
  SurfaceRow surface_row(surface_count);
  for (size_t surface = 0; surface < surface_count; ++surface) {
    for (int64_t row : rows_of_surface[surface])
      surface_row.add(content, row, sums.areas[surface] > 0 ? content.areas[row] / sums.areas[surface] : 0,
                      surface_of_row);
    surface_row.appendTo(sums, has_intervals);
  }
  sums.geometry = content.geometry;
  sums.geometry.row_of_polygon = content.geometry.surface_of_polygon;
  sums.parameters = content.parameters;
  sums.notes = content.notes;
  sums.notes.push_back(fmt::format(
      "{} form factors between {} rows do not fit a page. They are added up here, between {} surfaces. Standard errors "
      "are sums, too, and so at most as large as stated.",
      content.entryCount(), content.rowCount(), surface_count));
  sums.is_bounded = true;
  return sums;
}

void leaveOutSmall(ReportContent& content, size_t width, size_t largest_bytes) {
  const size_t bytes = pageBytesOfEntries(content, width);
  if (bytes <= largest_bytes) return;
  const size_t entry_count = content.to.size();
  // Columns farther apart take up to 5 bytes each, so this bound holds for any choice of entries.
  const size_t kept = std::min(entry_count, largest_bytes / 4 * 3 / (width * (content.hasIntervals() ? 4 : 2) + 5));
  std::vector<double> sorted = content.form_factors;
  double cut = INFINITY;
  if (kept > 0) {
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(kept - 1), sorted.end(),
                     std::greater<>());
    cut = std::nextafter(sorted[kept - 1], INFINITY);
  }
  size_t end = 0;
  double largest_sum = 0;
  int64_t begin = 0;
  for (int64_t row = 0; row < content.rowCount(); ++row) {
    double sum = 0;
    for (int64_t k = begin; k < content.starts[row + 1]; ++k) {
      if (content.form_factors[k] < cut) {
        sum += content.form_factors[k];
        continue;
      }
      content.to[end] = content.to[k];
      content.form_factors[end] = content.form_factors[k];
      content.standard_errors[end] = content.standard_errors[k];
      if (content.hasIntervals()) content.lower[end] = content.lower[k], content.upper[end] = content.upper[k];
      ++end;
    }
    begin = content.starts[row + 1];
    content.starts[row + 1] = static_cast<int64_t>(end);
    largest_sum = std::max(largest_sum, sum);
  }
  content.to.resize(end), content.form_factors.resize(end), content.standard_errors.resize(end);
  if (content.hasIntervals()) content.lower.resize(end), content.upper.resize(end);
  content.notes.push_back(fmt::format(
      "{} of {} form factors do not fit a page and are left out. Each is below {:.2g}; in no row do they add "
      "up to more than {:.2g}.",
      entry_count - end, entry_count, cut, largest_sum));
}

}  // namespace viewpeel
