// Work that an engine did, counted, where LatticeOptions::measure_work asks for it.
#pragma once
#include <viewpeel/engine.h>

namespace viewpeel {

// Of engines, or threads, that take the same directions.
void addWork(const Work& part, Work& sum);

}  // namespace viewpeel
