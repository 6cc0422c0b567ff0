#include "program/summary.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "run/summaries.h"
#include "scene/leaks.h"
#include "threads.h"

namespace viewpeel::program {
namespace {

std::string columnName(const Ids& ids, uint32_t j) {
  return j == kEnvironment ? "environment" : j == kLeak ? "leak" : ids.names[j];
}

}  // namespace

std::string describeDevice(const DeviceDescription& device) {
  return fmt::format("device     {} ({}; {})\n", device.name, device.kind, device.driver);
}

std::string describeProcessor() { return fmt::format("device     processor, {}\n", counted(threadCount(), "thread")); }

void checkValidation(const Device& device) {
  if (!device.validationErrors().empty())
    throw Error(ErrorCode::device, "Vulkan validation: " + device.validationErrors().front());
}

std::string counted(uint64_t count, const char* noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

std::string describeScene(const Scene& scene) {
  const Ids ids = makeIds(scene, By::polygon, false);
  const auto [least, most] = std::minmax_element(ids.areas.begin(), ids.areas.end());
  std::string split;
  if (scene.polygons.size() != scene.faces.size())
    split = fmt::format(" (as {} triangles and quadrilaterals)", scene.polygons.size());
  return fmt::format(
      "scene      {}: {}{}, {}, {}\n"
      "areas      {:.6g} in all, polygons {:.3g} to {:.3g}; radius {:.4g}\n{}",
      scene.file, counted(scene.faces.size(), "polygon"), split, counted(scene.surfaces.size(), "surface"),
      describeClosedness(scene), std::accumulate(ids.areas.begin(), ids.areas.end(), 0.0), *least, *most, scene.scale,
      describeCoincidences(scene));
}

std::string describeCoincidences(const Scene& scene) {
  const Coincidences& found = scene.coincidences;
  if (found.sheets + found.contacts == 0) return "";
  return fmt::format("coincide   {} back to back, as sides of a sheet, {} face to face, as touching solids{}\n",
                     counted(found.sheets, "pair"), counted(found.contacts, "pair"),
                     found.in_doubt ? fmt::format("; {} in doubt, see --sheets and --solids", found.in_doubt) : "");
}

std::string tabulateLargest(const FormFactors& between_surfaces, size_t rows) {
  struct Row {
    uint32_t from, to;
    Measured f;
  };
  std::vector<Row> table;
  const auto& names = between_surfaces.ids().names;
  for (const auto& entry : between_surfaces.entries()) {
    if (between_surfaces.ids().isRequested(entry.i))
      table.push_back({entry.i, entry.j, between_surfaces.formFactor(entry.i, entry.j)});
    if (entry.j < kEnvironment && entry.j != entry.i && between_surfaces.ids().isRequested(entry.j))
      table.push_back({entry.j, entry.i, between_surfaces.formFactor(entry.j, entry.i)});
  }
  std::sort(table.begin(), table.end(), [](const Row& a, const Row& b) { return a.f.value > b.f.value; });
  table.resize(std::min(table.size(), rows));
  const auto nameOf = [&](uint32_t id) { return columnName(between_surfaces.ids(), id); };
  size_t from_width = 4, to_width = 2;
  for (const Row& row : table) {
    from_width = std::max(from_width, names[row.from].size());
    to_width = std::max(to_width, nameOf(row.to).size());
  }
  std::string text = fmt::format("  {:<{}}  {:<{}}  form factor  standard error\n", "from", from_width, "to", to_width);
  for (const Row& row : table)
    text += fmt::format("  {:<{}}  {:<{}}  {:11.6f}  {:14.1e}\n", names[row.from], from_width, nameOf(row.to), to_width,
                        row.f.value, row.f.standard_error);
  return text;
}

namespace {

std::string describeGuarantee(const Guarantee& g) {
  const char* by = g.by == GuaranteedBy::hoeffding   ? "Hoeffding's bound"
                   : g.by == GuaranteedBy::bernstein ? "the empirical Bernstein bound"
                   : g.by == GuaranteedBy::chernoff  ? "Chernoff's bound on independent lines"
                                                     : "the median of runs";
  const std::string chance =
      g.delta > 0 ? fmt::format("with probability {}, by {}", 1 - g.delta, by) : "for certain, by geometry alone";
  std::string text = fmt::format("guarantee  every form factor{} within {:.2e} {}\n",
                                 g.by == GuaranteedBy::chernoff ? " between rows" : "", g.bound, chance);
  if (g.row_bound > 0)
    text +=
        fmt::format("           what leaves the scene from each row within {:.2e}; all hold at once\n", g.row_bound);
  return text;
}

}  // namespace

std::string describeErrors(const Estimate& estimate) {
  const FormFactors& f = estimate.form_factors;
  const StandardErrors errors = measureStandardErrors(f, 3);
  std::string text =
      fmt::format("errors     standard errors of {}: largest {:.1e}, rms {:.1e}{}\n",
                  counted(errors.count, "nonzero form factor"), estimate.largest_standard_error, errors.rms,
                  estimate.largest_relative_error > 0
                      ? fmt::format("; {:.1e} of its form factor over the larger ones", estimate.largest_relative_error)
                      : "");
  for (size_t k = 0; k < errors.worst.size(); ++k) {
    const auto& [i, j] = errors.worst[k];
    const Measured value = f.formFactor(i, j);
    text += fmt::format("{}{} to {} ({:.4f} +- {:.1e})", k ? ", " : "           worst: ", f.ids().names[i],
                        columnName(f.ids(), j), value.value, value.standard_error);
  }
  if (!errors.worst.empty()) text += "\n";
  if (estimate.unmet_pairs)
    text += fmt::format(
        "unmet      {} pairs that no line met: unoccluded form factors times the visibility of their neighbours, +- "
        "{:.1e} at "
        "most\n",
        estimate.unmet_pairs, estimate.largest_unmet_error);
  if (estimate.unseen_pairs)
    text += fmt::format(
        "unseen     {} pairs that only other polygons can hide from each other: no line saw one, 0 +- {:.1e} at most\n",
        estimate.unseen_pairs, estimate.largest_unseen_error);
  const auto all = double(pairCount(f.ids().count()));
  const auto entry_count = std::count_if(f.entries().begin(), f.entries().end(), [](const FormFactors::Entry& entry) {
    return entry.i != entry.j && entry.j < kEnvironment;
  });
  if (const double left_out = all - double(entry_count) - double(estimate.unseen_pairs);
      left_out > 0 && estimate.unmet_bound < 1)
    text += fmt::format(
        "left out   {:.0f} of {:.0f} pairs, which no line met: form factors below {:.1e} each, from the smaller of the "
        "two{};\n"
        "           rows add up without them\n",
        left_out, all, estimate.unmet_bound, estimate.line_pairs ? "" : ", at 95 % confidence");
  if (estimate.guarantee) text = describeGuarantee(*estimate.guarantee) + text;
  if (!f.ids().rows_sum_to_one) return text;
  size_t unmet = 0;
  std::string first;
  for (uint32_t k = 0; k < f.ids().count(); ++k)
    if (f.ids().isRequested(k) && !(f.rowSums()[k].value > 0) && ++unmet == 1) first = f.ids().names[k];
  if (unmet)
    text += fmt::format(
        "unmet      {} of {} rows ({}{}): too small for this lattice and so few directions; their form factors are "
        "unknown, not 0\n",
        unmet, f.ids().count(), first, unmet > 1 ? ", ..." : "");
  const Closure closure = measureClosure(f);
  return text + fmt::format(
                    "closure    row sums differ from 1 by at most {:.1e} ({}, +- {:.1e}), rms {:.1e}\n"
                    "outside    {:.3g} % of all emitted radiation leaves the scene, {:.3g} % ends on backs (leak)\n",
                    closure.largest_error, closure.row, closure.standard_error, closure.rms_error,
                    100 * shareOf(f, kEnvironment), 100 * shareOf(f, kLeak));
}

std::string describeDirected(const Estimate& estimate) {
  if (estimate.lines)
    return fmt::format(", {} of {}", counted(estimate.lines, "line"), counted(estimate.line_pairs, "pair"));
  return estimate.directed_pairs ? fmt::format(" and {} of {} alone", estimate.directed_directions,
                                               counted(estimate.directed_pairs, "pair"))
                                 : "";
}

std::string describeDirections(const Estimate& estimate, bool has_rays) {
  if (!has_rays) return counted(estimate.directions, "direction");
  const uint64_t of_replicate = estimate.directions / std::max<uint64_t>(estimate.replicates, 1);
  return fmt::format("each with up to {} of a polygon", counted(of_replicate, "ray"));
}

std::string describeResult(const Estimate& estimate) {
  const FormFactors& f = estimate.form_factors;
  if (f.entries().empty())
    return "\nNo row that was asked for sees another row: every form factor is 0.\n\n" + describeErrors(estimate);
  const bool splits_surfaces = f.ids().splits_surfaces;
  return fmt::format("\nlargest form factors{}\n{}\n{}", splits_surfaces ? "" : " between surfaces",
                     tabulateLargest(splits_surfaces ? f : estimate.between_surfaces, 20), describeErrors(estimate));
}

std::string describeBalance(const BalancedFormFactors& balanced) {
  const std::vector<std::string>& names = balanced.form_factors.ids().names;
  return fmt::format(
      "balanced   row sums differ from 1 by at most {:.1e} after {}; moved by {:.2g} standard errors rms, {:.2g} at "
      "most\n"
      "           largest change of a form factor {:.1e} ({} to {})\n",
      measureClosure(balanced.form_factors).largest_error, counted(balanced.steps, "step"), balanced.rms_change,
      balanced.largest_change, balanced.largest_form_factor_change, names[balanced.from], names[balanced.to]);
}

}  // namespace viewpeel::program
