// An engine counts its work where LatticeOptions::measure_work is set.
#pragma once
#include <viewpeel/engine.h>

namespace viewpeel {

// Adds the work of one engine, or thread, to the sum. All parts count the same directions, which are added once.
void addWork(const Work& part, Work& sum);

}  // namespace viewpeel
