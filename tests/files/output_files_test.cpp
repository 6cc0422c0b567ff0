// Debian's SciPy, h5py, xarray and VTK read files of results by the code in docs/formats.md.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <viewpeel/error.h>
#include <viewpeel/solve.h>
#include <viewpeel/write.h>
#include "scenes/named_scenes.h"
#include "tests/support/python.h"
#include "tests/support/random_form_factors.h"
#include "tests/support/test_folder.h"

namespace viewpeel {
namespace {

namespace fs = std::filesystem;
namespace ts = test_scenes;

// Returns a scene in which names need escapes. One face has no area, so rows are not ids. One face has five corners, so
// polygons are not faces.
InputScene unequalScene() {
  InputScene input{"unequal", {}, {}};
  ts::addFace(input, "Tür & <süd> \"1\"", {{0, 0, 0}, {2, 0, 0}, {2, 3, 0}, {0, 3, 0}});
  ts::addFace(input, "gable", {{0, 0, 5}, {0, 1, 5}, {1, 1, 5}});
  ts::addFace(input, "gable", {{0, 0, 6}, {1, 0, 6}, {1, 0, 6}});
  ts::addFace(input, "gable", {{3, 0, 0}, {3, 0, 1}, {3, 1, 2}, {3, 2, 1}, {3, 2, 0}});
  ts::addFace(input, "wall", {{0, 4, 0}, {0.5, 4, 0}, {0.5, 4, 0.7}});
  return input;
}

constexpr uint32_t kRows = 5;

class OutputFiles : public TestFolder {
 protected:
  // Returns Python code that sets `truth` and `errors` (rows x rows), `areas`, `environment` and `leak` for all rows of
  // the file.
  std::string expected() const {
    const auto rows = form_factors_.ids().rows();
    std::vector<std::vector<double>> f(kRows, std::vector<double>(kRows, 0)), e = f;
    std::vector<double> areas(kRows, 0), environment(kRows, 0), leak(kRows, 0);
    for (uint32_t i = 0; i < form_factors_.ids().count(); ++i) {
      for (uint32_t j = 0; j < form_factors_.ids().count(); ++j) {
        f[rows[i]][rows[j]] = form_factors_.formFactor(i, j).value;
        e[rows[i]][rows[j]] = form_factors_.formFactor(i, j).standard_error;
      }
      areas[rows[i]] = form_factors_.ids().areas[i];
      environment[rows[i]] = form_factors_.formFactor(i, kEnvironment).value;
      leak[rows[i]] = form_factors_.formFactor(i, kLeak).value;
    }
    return fmt::format(
        "import numpy\ntruth = numpy.array({})\nerrors = numpy.array({})\nareas, environment, leak = [numpy.array(x) "
        "for x in ({}, {}, {})]\nn = {}\n",
        f, e, areas, environment, leak, kRows);
  }
  // Runs a code block of the documents, and then the checks.
  void check(const std::string& block, const std::string& checks) {
    const std::string lines = pythonBlock(VIEWPEEL_DOCS "/formats.md", block);
    ASSERT_FALSE(lines.empty()) << "docs/formats.md has no block '# " << block << "'";
    const PythonResult result = runPython(folder_, expected() + lines + checks + "print('passed')\n");
    EXPECT_EQ(result.status, 0) << result.output;
    EXPECT_NE(result.output.find("passed"), std::string::npos) << result.output;
  }

  Scene scene_ = buildScene(unequalScene());
  Ids ids_ = makeIds(scene_, By::polygon, false);
  FormFactors form_factors_ = randomFormFactors(ids_, 7, 0.7);
};

// The file has the same doubles. Negative controls: a matrix with two rows swapped, or transposed, differs.
constexpr const char* kSameMatrix =
    "dense = F.toarray()\n"
    "assert (dense == truth).all(), dense - truth\n"
    "swapped = dense[[1, 0] + list(range(2, n))]\n"
    "assert abs(swapped - truth).max() > 1e-3 and abs(dense.T - truth).max() > 1e-3\n";

TEST_F(OutputFiles, SciPyLoadsTheMatrix) {
  writeFormFactors(form_factors_, folder_ / "office.npz", &form_factors_);
  EXPECT_TRUE(fs::exists(folder_ / "office.balanced.npz"));
  check("SciPy", kSameMatrix);
}

TEST_F(OutputFiles, Hdf5HoldsMatrixErrorsAndNames) {
  OutputContent content{
      form_factors_, &form_factors_, &scene_, {{"seed", "7"}, {"version", "0.2.0"}, {"rate", "1e-3"}}};
  writeFormFactors(content, folder_ / "office.h5");
  check(
      "h5py and SciPy",
      std::string(kSameMatrix) +
          "assert (errors == standard_errors.toarray()).all()\n"
          "assert names == ['Tür & <süd> \"1\"', 'gable[1]', 'gable[2]', 'gable[3]', 'wall'], names\n"
          "assert (area == areas).all() and (to_environment == environment).all()\n"
          "with h5py.File('office.h5') as file:\n"
          "    assert (file['leak'][:] == leak).all() and file.attrs['seed'] == 7 and file.attrs['rate'] == 1e-3\n"
          "    assert file.attrs['version'] == '0.2.0' and file.attrs['closure_largest'] > 0\n"
          "    assert (file['balanced_form_factors/data'][:] == F.data).all()\n"
          "    group = file['geometry']\n"
          "    assert sum(group['polygon_area'][:]) - areas.sum() < 1e-12 and len(group['x']) == len(group['corner'])\n"
          "    assert list(group['row_of_polygon'][:]) == [0, 1, 3, 3, 4]\n"
          "    first, count = group['first_corner'][2], group['corner_count'][2]\n"
          "    assert abs(group['x'][first:first + count] - 3).max() < 1e-14\n");
}

TEST_F(OutputFiles, Hdf5HoldsTheIntervalsOfAGuarantee) {
  std::vector<Interval> intervals;
  for (const FormFactors::Entry& entry : form_factors_.entries())
    intervals.push_back({0.5 * entry.exchange_area.value, 2 * entry.exchange_area.value});
  form_factors_ = {form_factors_.ids(), form_factors_.entries(), form_factors_.rowSums(), intervals};
  writeFormFactors(OutputContent{form_factors_}, folder_ / "office.h5");
  check("h5py and SciPy", std::string(kSameMatrix) +
                              "with h5py.File('office.h5') as file:\n"
                              "    assert (file['lower_bounds/data'][:] == F.data / 2).all()\n"
                              "    assert (file['upper'][:] == 2 * F.data).all() and F.nnz > 5\n"
                              "    assert (file['environment_lower'][:] == environment / 2).all()\n"
                              "    assert (file['leak_upper'][:] == 2 * leak).all()\n");
}

TEST_F(OutputFiles, XarrayOpensTheSameFile) {
  writeFormFactors(OutputContent{form_factors_, nullptr, &scene_}, folder_ / "office.h5");
  check("xarray",
        std::string("from scipy import sparse\n"
                    "F = sparse.csr_matrix((result.form_factor.values, (result['from'].values, result.to.values)), "
                    "shape=(n, n))\n") +
            kSameMatrix +
            "assert abs(float(worst.standard_error) - errors.max()) == 0\n"
            "assert truth[int(worst['from']), int(worst.to)] == float(worst.form_factor)\n"
            "assert result.sizes['row'] == n and (result.area.values == areas).all()\n"
            "assert list(result.name.values)[4] == 'wall' and result.form_factor.attrs['units'] == '1'\n"
            "geometry = xarray.open_dataset('office.h5', engine='h5netcdf', group='geometry')\n"
            "assert geometry.sizes['polygon'] == 5\n"
            "by_netcdf = xarray.open_dataset('office.h5', engine='netcdf4')\n"
            "assert (by_netcdf.form_factor.values == result.form_factor.values).all()\n"
            "assert list(by_netcdf.name.values) == list(result.name.values) and by_netcdf.attrs == result.attrs\n");
}

TEST_F(OutputFiles, VtkReadsPolygonsAndTheirValues) {
  writeFormFactors(OutputContent{form_factors_, nullptr, &scene_, {}, {"gable", "wall"}}, folder_ / "office.vtp");
  check("VTK",
        "cells = mesh.GetCellData()\n"
        "def values(name):\n"
        "    return vtk_to_numpy(cells.GetArray(name))\n"
        "rows = values('row')\n"
        "assert list(rows) == [0, 1, 3, 3, 4]\n"
        "texts = cells.GetAbstractArray('surface')\n"
        "surface = [texts.GetValue(k) for k in range(texts.GetNumberOfValues())]\n"
        "assert surface == ['Tür & <süd> \"1\"', 'gable', 'gable', 'gable', 'wall'], surface\n"
        "assert abs(numpy.bincount(rows, values('area'), n) - areas).max() < 1e-13\n"
        "assert (values('environment') == environment[rows]).all() and (values('leak') == leak[rows]).all()\n"
        "all_errors = errors.max(axis=1)\n"
        "assert (values('standard_error') >= all_errors[rows]).all()\n"
        "assert abs(values('row_sum') - (truth.sum(axis=1) + environment + leak)[rows]).max() < 1e-14\n"
        "assert abs(from_wall - truth[4][rows]).max() < 1e-16\n"
        "both = (areas[1] * truth[1] + areas[3] * truth[3]) / (areas[1] + areas[3])\n"
        "assert abs(values('from gable') - both[rows]).max() < 1e-16\n"
        "assert abs(from_wall - truth[3][rows]).max() > 1e-3\n"
        "corners = [mesh.GetCell(k).GetNumberOfPoints() for k in range(mesh.GetNumberOfCells())]\n"
        "assert corners[:2] == [4, 3] and sorted(corners[2:4]) == [3, 4] and corners[4] == 3, corners\n"
        "point = mesh.GetPoint(mesh.GetCell(0).GetPointId(2))\n"
        "assert abs(numpy.array(point) - [2, 3, 0]).max() < 1e-14\n");
}

// Each polygon in the .vtp has the heat flux and temperature of its row.
TEST_F(OutputFiles, VtpHasTheAnswersOfSolve) {
  HeatSolution heat;
  for (uint32_t id = 0; id < form_factors_.ids().count(); ++id) {
    HeatRow row;
    row.temperature.value = 300 + id;
    row.radiosity.value = 400.5 + id;
    row.irradiation.value = 10 * id;
    row.heat_flux.value = -7.0 * id;
    heat.rows.push_back(row);
  }
  OutputContent content{form_factors_, nullptr, &scene_};
  content.shown = {"wall"};
  content.heat = &heat;
  writeFormFactors(content, folder_ / "office.vtp");
  // Row 2 of the file has no area, so that rows 3 and 4 are the third and fourth of the answers.
  check("VTK",
        "cells = mesh.GetCellData()\n"
        "def values(name):\n"
        "    return list(vtk_to_numpy(cells.GetArray(name)))\n"
        "assert values('temperature') == [300, 301, 302, 302, 303], values('temperature')\n"
        "assert values('radiosity') == [400.5, 401.5, 402.5, 402.5, 403.5]\n"
        "assert values('irradiation') == [0, 10, 20, 20, 30] and values('heat_flux') == [0, -7, -14, -14, -21]\n");
}

TEST_F(OutputFiles, VtpNeedsTheSceneOfItsFormFactors) {
  const auto refusal = [&](const OutputContent& content, const char* name) -> std::string {
    try {
      writeFormFactors(content, folder_ / name);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::bad_usage);
      return error.what();
    }
    return "none";
  };
  EXPECT_NE(refusal({form_factors_}, "a.vtp").find("give the scene"), std::string::npos);
  const Scene other = buildScene(ts::parallelSquares());
  EXPECT_NE(refusal({form_factors_, nullptr, &other}, "a.vtp").find("not the scene of these"), std::string::npos);
  EXPECT_NE(refusal({form_factors_, nullptr, &scene_, {}, {"door"}}, "a.vtp").find("'door'"), std::string::npos);
  EXPECT_THROW(checkOutput(folder_ / "a.vtp", false, false), Error);
  EXPECT_THROW(checkOutput(folder_ / "a.balanced.npz", true), Error);
  const Ids by_surface = makeIds(scene_, By::surface, false);
  EXPECT_THROW(checkShown(scene_, by_surface, {"gable[1]"}), Error);
  EXPECT_NO_THROW(checkShown(scene_, by_surface, {"gable", "wall"}));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()), 0);
}

// Rows that were not requested have no entries, but keep their numbers.
TEST_F(OutputFiles, RowsThatWereNotRequestedStayEmpty) {
  Ids ids = ids_;
  restrictToQuestion({.from = {"wall"}, .pair = {}, .blockers = {}}, scene_, ids);
  const FormFactors partial(ids, form_factors_.entries(), form_factors_.rowSums());
  writeFormFactors(OutputContent{partial, nullptr, &scene_}, folder_ / "office.h5");
  check("h5py and SciPy",
        "truth[:4] = 0\n"
        "assert (F.toarray() == truth).all()\n"
        "with h5py.File('office.h5') as file:\n"
        "    assert list(file['is_requested'][:]) == [0, 0, 0, 0, 1]\n");
}

TEST_F(OutputFiles, TheSameContentMakesTheSameBytes) {
  const auto bytesOf = [&](const char* name) {
    writeFormFactors(OutputContent{form_factors_, nullptr, &scene_}, folder_ / name);
    std::ifstream in(folder_ / name, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  };
  for (const std::string extension : {".npz", ".h5", ".vtp"})
    EXPECT_EQ(bytesOf(("a" + extension).c_str()), bytesOf(("b" + extension).c_str())) << extension;
}

}  // namespace
}  // namespace viewpeel
