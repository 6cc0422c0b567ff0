// This file is the C interface. Each function catches the library's exceptions and keeps the message for
// viewpeel_last_error().
#include <viewpeel/c.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <string>
#include <unordered_map>

#include <viewpeel/compute.h>
#include <viewpeel/error.h>
#include <viewpeel/read.h>
#include <viewpeel/sparse_rows.h>
#include <viewpeel/write.h>

using viewpeel::ErrorCode;

struct viewpeel_scene {
  std::shared_ptr<const viewpeel::Scene> scene;
};

struct viewpeel_result {
  viewpeel::StoredResult stored;
  std::shared_ptr<const viewpeel::Scene> scene;  // null for a result that was read from a file
  viewpeel::SparseRows rows;
  std::vector<std::string> names;
  std::vector<uint32_t> id_of_row;  // kNone for empty rows
};

namespace {

constexpr uint32_t kNone = UINT32_MAX;
thread_local std::string last_error;

viewpeel_status statusOf(ErrorCode code) {
  switch (code) {
    case ErrorCode::bad_input:
      return VIEWPEEL_BAD_INPUT;
    case ErrorCode::bad_usage:
      return VIEWPEEL_BAD_USAGE;
    case ErrorCode::device:
      return VIEWPEEL_DEVICE;
    case ErrorCode::memory:
      return VIEWPEEL_MEMORY;
    case ErrorCode::output:
      return VIEWPEEL_OUTPUT;
    case ErrorCode::limit:
      return VIEWPEEL_LIMIT;
    case ErrorCode::check:
      return VIEWPEEL_CHECK;
  }
  return VIEWPEEL_CHECK;
}

viewpeel_status fail(viewpeel_status status, const char* line) noexcept {
  try {
    last_error = line;
  } catch (...) {
    last_error.clear();  // there is no memory for the message; the status remains
  }
  return status;
}

// Runs the work and turns its exceptions into statuses.
template <class Work>
viewpeel_status attempt(const Work& work) noexcept {
  try {
    return work();
  } catch (const viewpeel::Error& error) {
    return fail(statusOf(error.code()), error.what());
  } catch (const std::bad_alloc&) {
    return fail(VIEWPEEL_MEMORY, "out of memory; ask for rows by surface, or take a smaller scene");
  } catch (const std::exception& error) {
    return fail(VIEWPEEL_CHECK, error.what());
  }
}

[[noreturn]] void refuse(const std::string& line) { throw viewpeel::Error(ErrorCode::bad_usage, line); }

void requireGiven(const void* argument, const char* name) {
  if (!argument) refuse(std::string(name) + ": is NULL");
}

viewpeel::InputScene inputOf(const double* points, size_t point_count, const uint32_t* corners, const size_t* starts,
                             size_t polygon_count, const char* const* surface_names) {
  viewpeel::InputScene input{"polygons", {}, {}};
  std::unordered_map<std::string, uint32_t> surfaces;
  for (size_t k = 0; k < polygon_count; ++k) {
    const std::string name = surface_names ? surface_names[k] ? surface_names[k] : "" : "polygons";
    const auto [surface, is_new] = surfaces.try_emplace(name, static_cast<uint32_t>(surfaces.size()));
    if (is_new) input.surface_names.push_back(name);
    viewpeel::InputFace face{{}, surface->second};
    if (starts[k + 1] < starts[k]) refuse("polygon " + std::to_string(k) + ": ends before it starts");
    for (size_t at = starts[k]; at < starts[k + 1]; ++at) {
      const size_t corner = corners[at];
      if (corner >= point_count)
        throw viewpeel::Error(ErrorCode::bad_input, "polygon " + std::to_string(k) + ": corner " +
                                                        std::to_string(corner) + " is not one of the " +
                                                        std::to_string(point_count) + " points; indices count from 0");
      face.corners.emplace_back(points[3 * corner], points[3 * corner + 1], points[3 * corner + 2]);
    }
    input.faces.push_back(std::move(face));
  }
  return input;
}

viewpeel::Request requestOf(const viewpeel_options& options) {
  using namespace viewpeel;
  Request request;
  if (options.by_surface) request.by = By::surface;
  request.two_sided = options.two_sided != 0;
  request.threads = options.threads;
  if (options.seed) request.seed = options.seed;
  if (options.promise) request.promise = options.promise > 0;
  if (options.seconds != 0) request.time_limit_s = options.seconds;
  const bool is_guarantee = options.epsilon != 0, is_estimate = options.tolerance != 0 || options.relative != 0;
  if (is_guarantee && is_estimate) refuse("epsilon beside tolerance or relative: a guarantee is a goal of its own");
  if (options.rms != 0 && (is_guarantee || is_estimate)) refuse("rms beside another goal: it is a goal of its own");
  if (!is_guarantee && options.delta != 0) refuse("delta belongs to a guarantee; give epsilon, too");
  if (is_guarantee) {
    EpsilonDelta guarantee{.epsilon = options.epsilon};
    if (options.delta != 0) guarantee.delta = options.delta;
    request.goal = guarantee;
  } else if (options.rms != 0) {
    request.goal = RootMeanSquare{options.rms};
  } else if (options.tolerance != 0) {
    request.goal = Tolerance{options.tolerance, options.relative != 0 ? std::optional(options.relative) : std::nullopt};
  } else if (options.relative != 0) {
    request.goal = Relative{options.relative};
  } else if (options.seconds != 0) {
    request.goal = Seconds{options.seconds};
  }
  return request;
}

std::unique_ptr<viewpeel_result> hold(viewpeel::StoredResult stored, std::shared_ptr<const viewpeel::Scene> scene) {
  const viewpeel::Ids& ids = stored.form_factors.ids();
  std::vector<uint32_t> id_of_row(ids.rowCount(), kNone);
  const std::vector<uint32_t> rows = ids.rows();
  for (uint32_t id = 0; id < ids.count(); ++id) id_of_row[rows[id]] = id;
  viewpeel::SparseRows sparse = viewpeel::compressRows(stored.form_factors);
  std::vector<std::string> names = viewpeel::rowNames(ids);
  return std::make_unique<viewpeel_result>(
      viewpeel_result{std::move(stored), std::move(scene), std::move(sparse), std::move(names), std::move(id_of_row)});
}

}  // namespace

const char* viewpeel_last_error(void) { return last_error.c_str(); }
const char* viewpeel_version(void) { return VIEWPEEL_VERSION; }

viewpeel_status viewpeel_load_scene(const char* file, viewpeel_scene** scene) {
  return attempt([&] {
    requireGiven(file, "file"), requireGiven(scene, "scene");
    *scene = new viewpeel_scene{std::make_shared<const viewpeel::Scene>(viewpeel::loadScene(file))};
    return VIEWPEEL_OK;
  });
}

viewpeel_status viewpeel_load_scene_files(const char* const* files, size_t file_count, viewpeel_scene** scene) {
  return attempt([&] {
    requireGiven(files, "files"), requireGiven(scene, "scene");
    std::vector<std::filesystem::path> paths;
    for (size_t k = 0; k < file_count; ++k) {
      requireGiven(files[k], "a file");
      paths.emplace_back(files[k]);
    }
    *scene = new viewpeel_scene{std::make_shared<const viewpeel::Scene>(viewpeel::loadScene(paths))};
    return VIEWPEEL_OK;
  });
}

viewpeel_status viewpeel_build_scene(const double* points, size_t point_count, const uint32_t* corners,
                                     const size_t* starts, size_t polygon_count, const char* const* surface_names,
                                     viewpeel_scene** scene) {
  return attempt([&] {
    requireGiven(points, "points"), requireGiven(corners, "corners"), requireGiven(starts, "starts");
    requireGiven(scene, "scene");
    const viewpeel::InputScene input = inputOf(points, point_count, corners, starts, polygon_count, surface_names);
    *scene = new viewpeel_scene{std::make_shared<const viewpeel::Scene>(viewpeel::buildScene(input))};
    return VIEWPEEL_OK;
  });
}

void viewpeel_free_scene(viewpeel_scene* scene) { delete scene; }

viewpeel_status viewpeel_compute(const viewpeel_scene* scene, const viewpeel_options* options,
                                 viewpeel_result** result) {
  return attempt([&] {
    requireGiven(scene, "scene"), requireGiven(result, "result");
    const viewpeel_options given = options ? *options : viewpeel_options{};
    viewpeel::Observer observer;
    if (given.should_stop) observer.should_stop = [&] { return given.should_stop(given.context) != 0; };
    viewpeel::FormFactorRun run(*scene->scene, requestOf(given), observer);
    run.makePlan();
    while (!run.isDone()) run.step();
    if (run.isInterrupted() && (run.replicateCount() < 2))
      return fail(VIEWPEEL_STOPPED, "the run was stopped before there were two replicates");
    viewpeel::Result found = run.result();
    auto parameters = viewpeel::parametersOf(run, found);
    std::vector<std::string> surfaces;
    for (const viewpeel::Surface& surface : scene->scene->surfaces) surfaces.push_back(surface.name);
    *result =
        hold({std::move(found.form_factors), {}, std::move(surfaces), std::move(parameters)}, scene->scene).release();
    return VIEWPEEL_OK;
  });
}

viewpeel_status viewpeel_read_result(const char* file, viewpeel_result** result) {
  return attempt([&] {
    requireGiven(file, "file"), requireGiven(result, "result");
    *result = hold(viewpeel::readResult(file), nullptr).release();
    return VIEWPEEL_OK;
  });
}

viewpeel_status viewpeel_write_result(const viewpeel_result* result, const char* file) {
  return attempt([&] {
    requireGiven(result, "result"), requireGiven(file, "file");
    viewpeel::OutputContent content{result->stored.form_factors};
    content.scene = result->scene.get();
    content.parameters = result->stored.parameters;
    viewpeel::checkOutput(file, false, content.scene != nullptr);
    viewpeel::writeFormFactors(content, file);
    return VIEWPEEL_OK;
  });
}

void viewpeel_free_result(viewpeel_result* result) { delete result; }

viewpeel_rows viewpeel_get_rows(const viewpeel_result* result) {
  if (!result) return {};
  const viewpeel::SparseRows& rows = result->rows;
  const bool has_intervals = !rows.lower.empty();
  return {static_cast<size_t>(rows.rowCount()),
          rows.columns.size(),
          rows.starts.data(),
          rows.columns.data(),
          rows.form_factors.data(),
          rows.standard_errors.data(),
          has_intervals ? rows.lower.data() : nullptr,
          has_intervals ? rows.upper.data() : nullptr};
}

const char* viewpeel_row_name(const viewpeel_result* result, size_t row) {
  return result && row < result->names.size() ? result->names[row].c_str() : nullptr;
}

double viewpeel_row_area(const viewpeel_result* result, size_t row) {
  if (!result || row >= result->id_of_row.size() || result->id_of_row[row] == kNone) return 0;
  return result->stored.form_factors.ids().areas[result->id_of_row[row]];
}

viewpeel_status viewpeel_form_factor(const viewpeel_result* result, size_t i, size_t j, double* form_factor,
                                     double* standard_error) {
  return attempt([&] {
    requireGiven(result, "result"), requireGiven(form_factor, "form_factor");
    const size_t count = result->id_of_row.size();
    const bool is_outside = j == VIEWPEEL_ENVIRONMENT || j == VIEWPEEL_LEAK;
    if (i >= count || (j >= count && !is_outside))
      refuse("row " + std::to_string(i >= count ? i : j) + ": is not one of the " + std::to_string(count) + " rows");
    const uint32_t from = result->id_of_row[i], to = is_outside ? static_cast<uint32_t>(j) : result->id_of_row[j];
    const bool is_empty = from == kNone || (to == kNone && !is_outside);
    if (!is_empty && !result->stored.form_factors.ids().isRequested(from))
      refuse("row " + std::to_string(i) + ": was not asked for");
    const viewpeel::Measured f = is_empty ? viewpeel::Measured{} : result->stored.form_factors.formFactor(from, to);
    *form_factor = f.value;
    if (standard_error) *standard_error = f.standard_error;
    return VIEWPEEL_OK;
  });
}
