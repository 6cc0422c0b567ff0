// Engines count their work where LatticeOptions::measure_work is set; addWork adds up the work of their parts.
#pragma once
#include <viewpeel/engine.h>

namespace viewpeel {

// Adds the work of a part, which is an engine or a thread, to the sum. Of Work::directions it keeps the larger number,
// because engines of several windows count the same directions.
void addWork(const Work& part, Work& sum);

}  // namespace viewpeel
