// This target reads the bytes as a file of materials, for a scene of three rows.
#include "input_file.h"
#include <viewpeel/error.h>
#include <viewpeel/solve.h>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t count) {
  using namespace viewpeel;
  static const Ids ids = [] {
    Ids three;
    three.names = {"floor", "wall[1]", "wall[2]"};
    three.surface = {0, 1, 1};
    three.areas = {1, 1, 1};
    return three;
  }();
  try {
    assignMaterials(readMaterials(fuzz::makeFile(bytes, count)), ids, {"floor", "wall"});
  } catch (const Error& error) {
    fuzz::requireOneLine(error.what());
  }
  return 0;
}
