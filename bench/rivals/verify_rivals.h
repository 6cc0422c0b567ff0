// A wrong rival would make the bench worthless, so each rival is first compared with closed forms.
#pragma once
#include "vulkan/device.h"

namespace viewpeel::bench {

// Verifies every rival on two plates, alone and past a blocker that hides them in part. The mean over seeds has to be
// the closed form within 6 standard errors, and the error has to fall as the work grows. Prints a comment line for
// each.
//   Throws: Error check, naming the rival and the figures.
void verifyRivals(const Device& device);

}  // namespace viewpeel::bench
