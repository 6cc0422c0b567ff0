// A wrong rival would make the bench dishonest. So each rival is compared with closed forms first.
#pragma once
#include "vulkan/device.h"

namespace viewpeel::bench {

// Verifies every rival on two plates, alone and past a blocker that hides them in part. The mean over seeds is within
// its standard error of the closed form, and the error falls as the work grows. Prints one comment line each.
//   Throws: Error check, naming the rival and the figures.
void verifyRivals(const Device& device);

}  // namespace viewpeel::bench
