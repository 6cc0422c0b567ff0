#include "report/survey_content.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace viewpeel {
namespace {

constexpr uint32_t kBitsOfAxis = 10;  // bits of each coordinate on the Z curve

// Returns the bits of three numbers in turn: x, y, z, x, y, z, ...
uint32_t interleave(const std::array<uint32_t, 3>& place) {
  uint32_t code = 0;
  for (uint32_t bit = 0; bit < kBitsOfAxis; ++bit)
    for (uint32_t axis = 0; axis < 3; ++axis) code |= (place[axis] >> bit & 1u) << (3 * bit + axis);
  return code;
}

struct Middles {
  std::array<std::vector<double>, 3> of_axis;  // by axis and row
  std::vector<int32_t> corner_count;
};

Middles middlesOfRows(const ReportContent& content) {
  const ReportGeometry& geometry = content.geometry;
  Middles middles;
  middles.corner_count.assign(content.names.size(), 0);
  for (auto& axis : middles.of_axis) axis.assign(content.names.size(), 0.0);
  for (size_t k = 0; k < geometry.first_corner.size(); ++k) {
    const int32_t row = geometry.row_of_polygon[k];
    for (int32_t c = geometry.first_corner[k]; c < geometry.first_corner[k] + geometry.corner_count[k]; ++c) {
      middles.of_axis[0][row] += geometry.x[c];
      middles.of_axis[1][row] += geometry.y[c];
      middles.of_axis[2][row] += geometry.z[c];
      ++middles.corner_count[row];
    }
  }
  for (size_t row = 0; row < content.names.size(); ++row)
    for (auto& axis : middles.of_axis) axis[row] /= std::max(1, middles.corner_count[row]);
  return middles;
}

}  // namespace

std::vector<double> statedErrors(const ReportContent& content) {
  if (!content.hasIntervals()) return content.standard_errors;
  std::vector<double> bounds(content.form_factors.size());
  for (size_t k = 0; k < bounds.size(); ++k)
    bounds[k] = std::max(content.form_factors[k] - content.lower[k], content.upper[k] - content.form_factors[k]);
  return bounds;
}

ReportSurvey surveyErrors(const std::vector<double>& errors) {
  ReportSurvey survey;
  double squares = 0, least = INFINITY;
  for (double error : errors) {
    squares += error * error;
    survey.largest_error = std::max(survey.largest_error, error);
    if (error > 0) least = std::min(least, error);
    else ++survey.without_error;
  }
  if (!errors.empty()) survey.rms_error = std::sqrt(squares / static_cast<double>(errors.size()));
  if (!std::isfinite(least) || !std::isfinite(survey.largest_error)) return survey;
  const auto binOf = [&](double error) { return std::floor(std::log10(error) / survey.step); };
  const double first = binOf(least);
  survey.first = first * survey.step;
  survey.error_bins.assign(static_cast<size_t>(binOf(survey.largest_error) - first) + 1, 0.0);
  for (double error : errors)
    if (error > 0) ++survey.error_bins[static_cast<size_t>(binOf(error) - first)];
  return survey;
}

std::vector<int64_t> largestEntries(const std::vector<double>& values, size_t count) {
  std::vector<int64_t> entries(values.size());
  std::iota(entries.begin(), entries.end(), int64_t{0});
  const auto end = entries.begin() + static_cast<std::ptrdiff_t>(std::min(count, entries.size()));
  std::partial_sort(entries.begin(), end, entries.end(),
                    [&](int64_t a, int64_t b) { return values[a] != values[b] ? values[a] > values[b] : a < b; });
  entries.erase(end, entries.end());
  return entries;
}

std::vector<int32_t> rowsOfEntries(const ReportContent& content, const std::vector<int64_t>& entries) {
  std::vector<int32_t> rows;
  for (int64_t entry : entries)
    rows.push_back(static_cast<int32_t>(std::ranges::upper_bound(content.starts, entry) - content.starts.begin() - 1));
  return rows;
}

std::vector<int32_t> ranksByPlace(const ReportContent& content) {
  const Middles middles = middlesOfRows(content);
  std::array<double, 3> least, size;
  for (size_t axis = 0; axis < 3; ++axis) {
    double from = INFINITY, to = -INFINITY;
    for (size_t row = 0; row < content.names.size(); ++row) {
      if (middles.corner_count[row] == 0) continue;
      from = std::min(from, middles.of_axis[axis][row]);
      to = std::max(to, middles.of_axis[axis][row]);
    }
    least[axis] = from, size[axis] = to - from;
  }
  const double longest = *std::ranges::max_element(size);
  std::vector<uint32_t> codes(content.names.size(), ~0u);
  for (size_t row = 0; row < codes.size(); ++row) {
    if (middles.corner_count[row] == 0 || !(longest > 0)) continue;
    std::array<uint32_t, 3> place;
    for (size_t axis = 0; axis < 3; ++axis)
      place[axis] =
          static_cast<uint32_t>((middles.of_axis[axis][row] - least[axis]) / longest * ((1u << kBitsOfAxis) - 1));
    codes[row] = interleave(place);
  }
  std::vector<int32_t> order(codes.size()), ranks(codes.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, [&](int32_t a, int32_t b) { return codes[a] < codes[b]; });
  for (size_t rank = 0; rank < order.size(); ++rank) ranks[order[rank]] = static_cast<int32_t>(rank);
  return ranks;
}

std::vector<float> pictureOf(const ReportContent& content, const std::vector<int32_t>& ranks, size_t size) {
  std::vector<float> picture(size * size, 0.f);
  const size_t rows = content.names.size();
  for (size_t row = 0; row < rows; ++row)
    for (int64_t k = content.starts[row]; k < content.starts[row + 1]; ++k) {
      const size_t down = static_cast<size_t>(ranks[row]) * size / rows;
      const size_t across = static_cast<size_t>(ranks[content.to[k]]) * size / rows;
      float& cell = picture[down * size + across];
      cell = std::max(cell, static_cast<float>(content.form_factors[k]));
    }
  return picture;
}

}  // namespace viewpeel
