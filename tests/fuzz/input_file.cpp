#include "input_file.h"

#include <cstdio>
#include <cstdlib>

#include <sys/mman.h>
#include <unistd.h>

#include <viewpeel/error.h>
#include <viewpeel/ids.h>

namespace viewpeel::fuzz {

std::filesystem::path makeFile(const uint8_t* bytes, size_t count) {
  static const int descriptor = ::memfd_create("fuzz", 0);
  if (::ftruncate(descriptor, 0) != 0 || ::pwrite(descriptor, bytes, count, 0) != static_cast<ssize_t>(count))
    std::abort();
  return "/proc/self/fd/" + std::to_string(descriptor);
}

void loadBytes(InputScene (*read)(const std::filesystem::path&), const uint8_t* bytes, size_t count) {
  try {
    const Scene scene = buildScene(read(makeFile(bytes, count)));
    isClosed(scene);
    fingerprint(scene);
    for (By by : {By::polygon, By::surface}) makeIds(scene, by, false);
  } catch (const Error& error) {
    requireOneLine(error.what());
  }
}

void requireOneLine(const std::string& message) {
  for (char c : message)
    if (static_cast<unsigned char>(c) < 32 || c == 127) {
      std::fprintf(stderr, "not one line of text: %s\n", message.c_str());
      std::abort();
    }
}

}  // namespace viewpeel::fuzz
