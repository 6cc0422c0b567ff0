#include "input_file.h"
#include "scene/readers.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t count) {
  viewpeel::fuzz::loadBytes(viewpeel::readEnergyPlusZones, bytes, count);
  return 0;
}
