#include "report/write_page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <viewpeel/error.h>
#include "report/page_blocks.h"
#include "report/page_text.h"
#include "report/shrink_content.h"
#include "report/survey_content.h"
#include "report/variable_length.h"

namespace viewpeel {
namespace {

constexpr size_t kPageBytes = 60'000'000;
constexpr size_t kExactBytes = 20'000'000;     // form factors are doubles where they take no more than this
constexpr size_t kGeometryBytes = 30'000'000;  // most bytes of polygons
constexpr size_t kSpareBytes = 1'000'000;      // reserve for tables and the survey
constexpr int64_t kBlockEntries = 1 << 15;     // entries that the page decodes together
constexpr size_t kListed = 2000;               // number of form factors in the table of the largest ones
constexpr size_t kWorst = 200;                 // number of errors in the table of the largest ones
constexpr size_t kPictureSize = 256;

// JSON has no infinity, so an infinite value is null.
std::string asJson(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "null"; }

template <class To, class From>
std::vector<To> convert(const std::vector<From>& values) {
  return std::vector<To>(values.begin(), values.end());
}

std::vector<float> toFloats(const std::vector<double>& values, double direction) {
  std::vector<float> floats(values.size());
  for (size_t k = 0; k < values.size(); ++k) {
    floats[k] = static_cast<float>(values[k]);
    const bool is_within = direction < 0 ? floats[k] > values[k] : direction > 0 && floats[k] < values[k];
    if (is_within) floats[k] = std::nextafter(floats[k], static_cast<float>(direction) * INFINITY);
  }
  return floats;
}

// Returns the middle of the scene. The page's corners are relative to it, in single precision.
std::array<double, 3> middleOf(const ReportGeometry& geometry) {
  std::array<double, 3> middle{};
  size_t axis = 0;
  for (const auto* values : {&geometry.x, &geometry.y, &geometry.z}) {
    if (!values->empty()) {
      const auto [least, greatest] = std::ranges::minmax(*values);
      middle[axis] = (least + greatest) / 2;
    }
    ++axis;
  }
  return middle;
}

// Adds the corners, polygon after polygon, relative to the scene's middle.
void addCorners(const ReportGeometry& geometry, PageBlocks& blocks) {
  const std::array<double, 3> middle = middleOf(geometry);
  size_t axis = 0;
  for (const auto* values : {&geometry.x, &geometry.y, &geometry.z}) {
    std::vector<float> of_polygons;
    for (size_t k = 0; k < geometry.first_corner.size(); ++k)
      for (int32_t c = 0; c < geometry.corner_count[k]; ++c)
        of_polygons.push_back(static_cast<float>((*values)[geometry.first_corner[k] + c] - middle[axis]));
    blocks.add(std::string(1, static_cast<char>('x' + axis)), of_polygons);
    ++axis;
  }
  blocks.add("corner_count", convert<uint8_t>(geometry.corner_count));
  blocks.add("polygon_area", convert<float>(geometry.polygon_area));
  blocks.add("surface_of_polygon", geometry.surface_of_polygon);
  blocks.addTexts("surface_name", geometry.surface_names);
}

// Makes the content small enough. Returns the bytes of one value.
size_t fit(ReportContent& content, size_t largest_bytes) {
  const auto widthOf = [&] {
    if (pageBytesOfEntries(content, 8) <= kExactBytes) return size_t{8};
    return pageBytesOfEntries(content, 4) <= largest_bytes ? size_t{4} : size_t{0};
  };
  size_t width = widthOf();
  if (width == 0 && !content.geometry.isEmpty() && content.geometry.surface_names.size() < content.names.size()) {
    content = addUpBySurface(content);
    width = widthOf();
  }
  if (width == 0) {
    width = 4;
    leaveOutSmall(content, width, largest_bytes);
  }
  if (width == 4) content.notes.push_back("Form factors and standard errors are rounded to 7 digits on this page.");
  return width;
}

// Adds the rows in blocks, which the page decodes one by one.
void addRows(const ReportContent& content, size_t width, PageBlocks& blocks) {
  std::vector<int32_t> first_rows = {0};
  const auto addBlock = [&](int64_t first, int64_t end) {
    const auto part = [&](const std::vector<double>& values, double direction, const char* name) {
      const std::vector<double> some(values.begin() + content.starts[first], values.begin() + content.starts[end]);
      const std::string numbered = fmt::format("{}.{}", name, first_rows.size() - 1);
      if (width == 8) blocks.add(numbered, some);
      else blocks.add(numbered, toFloats(some, direction));
    };
    std::vector<uint8_t> steps;
    for (int64_t row = first; row < end; ++row) {
      int32_t before = 0;
      for (int64_t k = content.starts[row]; k < content.starts[row + 1]; ++k) {
        addVariableLength(static_cast<uint32_t>(content.to[k] - before), steps);
        before = content.to[k];
      }
    }
    blocks.add(fmt::format("to.{}", first_rows.size() - 1), steps);
    part(content.form_factors, 0, "form_factor");
    part(content.standard_errors, 0, "standard_error");
    if (content.hasIntervals()) part(content.lower, -1, "lower"), part(content.upper, 1, "upper");
    first_rows.push_back(static_cast<int32_t>(end));
  };
  for (int64_t first = 0; first < content.rowCount();) {
    int64_t end = first + 1;
    while (end < content.rowCount() && content.starts[end + 1] - content.starts[first] <= kBlockEntries) ++end;
    addBlock(first, end);
    first = end;
  }
  blocks.add("first_row", first_rows);
  blocks.add("start", convert<int32_t>(content.starts));
}

void addList(const ReportContent& content, const std::string& name, const std::vector<int64_t>& entries,
             PageBlocks& blocks) {
  const auto pick = [&](const auto& values) {
    std::remove_cvref_t<decltype(values)> picked;
    for (int64_t entry : entries) picked.push_back(values[entry]);
    return picked;
  };
  blocks.add(name + ".from", rowsOfEntries(content, entries));
  blocks.add(name + ".to", pick(content.to));
  blocks.add(name + ".form_factor", pick(content.form_factors));
  blocks.add(name + ".standard_error", pick(content.standard_errors));
  if (!content.hasIntervals()) return;
  blocks.add(name + ".lower", pick(content.lower));
  blocks.add(name + ".upper", pick(content.upper));
}

void addPicture(const ReportContent& content, PageBlocks& blocks, size_t& size) {
  size = std::min(content.names.size(), kPictureSize);
  std::vector<int32_t> ranks = ranksByPlace(content);
  blocks.add("picture", pictureOf(content, ranks, size));
  blocks.add("rank", ranks);
}

void addColumns(const ReportContent& content, PageBlocks& blocks) {
  blocks.addTexts("name", content.names);
  blocks.add("area", content.areas);
  for (const ReportColumn& column : content.columns) blocks.add("column." + column.name, column.values);
  std::vector<std::string> words;
  for (const auto& [name, value] : content.parameters) words.insert(words.end(), {name, value});
  blocks.addTexts("parameters", words);
}

}  // namespace

bool hasPage() { return !kPageText.empty(); }

void requirePage(const std::string& file) {
  if (!hasPage())
    throw Error(ErrorCode::bad_usage,
                fmt::format("{}: this viewpeel was built without the page; build it with -DVIEWPEEL_BUILD_REPORT=ON, "
                            "or write .h5",
                            file));
}

void writePage(ReportContent content, std::ostream& out) {
  const ReportSurvey survey = surveyErrors(statedErrors(content));
  const int64_t entries_of_file = content.entryCount(), rows_of_file = content.rowCount();
  const std::array<double, 3> middle = middleOf(content.geometry);
  PageBlocks blocks;
  const bool has_geometry = !content.geometry.isEmpty();
  if (has_geometry) addCorners(content.geometry, blocks);
  const bool has_scene = has_geometry && blocks.sizeBytes() <= kGeometryBytes;
  if (!has_scene) blocks = PageBlocks();
  addColumns(content, blocks);
  const size_t used = kPageText.size() + blocks.sizeBytes() + content.names.size() * 12 + kSpareBytes;
  const size_t width = fit(content, used < kPageBytes ? kPageBytes - used : 0);
  blocks = PageBlocks();
  if (has_scene) {
    addCorners(content.geometry, blocks);
    blocks.add("row_of_polygon", content.geometry.row_of_polygon);
  } else if (has_geometry) {
    content.notes.push_back(fmt::format("The scene's {} polygons do not fit a page and are left out.",
                                        content.geometry.first_corner.size()));
  }
  addColumns(content, blocks);
  addList(content, "largest", largestEntries(content.form_factors, kListed), blocks);
  addList(content, "worst", largestEntries(statedErrors(content), kWorst), blocks);
  size_t picture_size = 0;
  addPicture(content, blocks, picture_size);
  addRows(content, width, blocks);
  blocks.addTexts("notes", content.notes);

  std::vector<std::string> columns, bins;
  for (const ReportColumn& column : content.columns)
    columns.push_back(fmt::format(R"({{"name":"{}","unit":"{}"}})", column.name, column.unit));
  for (double count : survey.error_bins) bins.push_back(asJson(count));
  const size_t gap = kPageText.find(kPageGap);
  const std::string elements = blocks.elements();
  const std::string contents = fmt::format(
      R"(<script type="application/json" id="contents">{{"format":1,"rows":{},"entries":{},"rows_of_file":{},)"
      R"("entries_of_file":{},"has_scene":{},"has_intervals":{},"unlisted_bound":{},"is_bounded":{},"is_rounded":{},)"
      R"("middle":[{}],"picture_size":{},"errors":{{"first":{},"step":{},"without":{},"largest":{},"rms":{},)"
      R"("bins":[{}]}},"columns":[{}],"arrays":{}}}</script>)"
      "\n",
      content.rowCount(), content.entryCount(), rows_of_file, entries_of_file, has_scene, content.hasIntervals(),
      asJson(unlistedBound(content)), content.is_bounded, width == 4, fmt::join(middle, ","), picture_size,
      survey.first, survey.step, survey.without_error, asJson(survey.largest_error), asJson(survey.rms_error),
      fmt::join(bins, ","), fmt::join(columns, ","), blocks.list());
  if (gap == std::string_view::npos) throw Error(ErrorCode::bad_usage, "this viewpeel was built without the page");
  if (kPageText.size() + contents.size() + elements.size() > kPageBytes)
    throw Error(ErrorCode::limit, "a page has 60 MB at most, and names and polygons take more; try --by surface");
  out << kPageText.substr(0, gap) << contents << elements << kPageText.substr(gap + kPageGap.size());
}

}  // namespace viewpeel
