// An Outside is the surroundings of an open scene: one environment, or sky and ground, black, at given temperatures.
#pragma once
#include <functional>
#include <vector>

#include <viewpeel/solve.h>
#include "solve/closed_exchange.h"

namespace viewpeel {

// An Outside says what each row sees in the direction of the environment. Emissive powers are less the solution's
// shift.
struct Outside {
  double up_power = 0, down_power = 0;  // W/m2; equal where there is one environment
  Eigen::VectorXd up_share;             // by row, of its exchange with the environment; 1 where there is one
  Eigen::VectorXd power;                // by row: up_share up_power + (1 - up_share) down_power
  // up_errors has the errors of each row's exchange area with the part above the horizon, a vector over rows for each
  // replicate. Their squares add up to the variance. It is empty where there is one environment.
  std::vector<Eigen::VectorXd> up_errors;
};

// Makes the outside of an enclosure.
//   In: enclosure: temperatures of the environment, or of sky and ground; power_of: emissive power of a temperature,
//     W/m2, less the solution's shift
//   Throws: Error bad_usage where sky and ground have temperatures, but their shares are missing for some rows.
Outside makeOutside(const ClosedExchange& closed, const Enclosure& enclosure,
                    const std::function<double(double temperature)>& power_of);

}  // namespace viewpeel
