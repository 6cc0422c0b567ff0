// This target reads an OpenFOAM case. The input holds the four files boundary, points, faces and finalAgglom, with
// lines of %%%% between them.
#include <cstdlib>
#include <fstream>
#include <string_view>

#include <unistd.h>

#include "input_file.h"
#include "scene/readers.h"
#include <viewpeel/error.h>
#include <viewpeel/ids.h>

namespace {

namespace fs = std::filesystem;

const fs::path& caseFolder() {
  static const fs::path folder = [] {
    const fs::path made = fs::temp_directory_path() / ("fuzz_foam_" + std::to_string(::getpid()));
    fs::create_directories(made / "constant" / "polyMesh");
    std::atexit([] { fs::remove_all(caseFolder()); });
    return made;
  }();
  return folder;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t count) {
  std::string_view rest(reinterpret_cast<const char*>(bytes), count);
  for (const char* name : {"polyMesh/boundary", "polyMesh/points", "polyMesh/faces", "finalAgglom"}) {
    constexpr std::string_view kBetween = "\n%%%%\n";
    const size_t end = std::min(rest.find(kBetween), rest.size());
    std::ofstream(caseFolder() / "constant" / name, std::ios::binary) << rest.substr(0, end);
    rest.remove_prefix(std::min(end + kBetween.size(), rest.size()));
  }
  try {
    const viewpeel::Scene scene = viewpeel::buildScene(viewpeel::readFoam(caseFolder()));
    viewpeel::makeIds(scene, viewpeel::By::surface, false);
  } catch (const viewpeel::Error& error) {
    viewpeel::fuzz::requireOneLine(error.what());
  }
  return 0;
}
