#include "input_file.h"
#include "scene/readers.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t count) {
  viewpeel::fuzz::loadBytes([](const std::filesystem::path& file) { return viewpeel::readEnergyPlusZones(file); },
                            bytes, count);
  viewpeel::fuzz::loadBytes(viewpeel::readEnergyPlusOutside, bytes, count);
  return 0;
}
