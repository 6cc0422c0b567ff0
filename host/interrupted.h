#pragma once

namespace viewpeel {

// A callback of an engine (on_batch) or of the estimator throws this to stop a run. The replicate in progress is
// dropped.
struct Interrupted {};

}  // namespace viewpeel
