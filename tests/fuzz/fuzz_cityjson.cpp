#include "input_file.h"
#include "scene/readers.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* bytes, size_t count) {
  using viewpeel::fuzz::loadBytes;
  loadBytes([](const std::filesystem::path& file) { return viewpeel::readCityJson(file); }, bytes, count);
  loadBytes([](const std::filesystem::path& file) { return viewpeel::readCityJsonSequence(file); }, bytes, count);
  return 0;
}
