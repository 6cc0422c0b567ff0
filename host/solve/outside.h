// The surroundings of an open scene: one environment, or sky and ground apart, each black and at one temperature.
#pragma once
#include <functional>
#include <vector>

#include <viewpeel/solve.h>
#include "solve/closed_exchange.h"

namespace viewpeel {

// An Outside has what each row sees where it sees the environment. Emissive powers are less the shift of the solution.
struct Outside {
  double up_power = 0, down_power = 0;  // W/m2; alike where there is one environment
  Eigen::VectorXd up_share;             // of each row's exchange with the environment; 1 where there is one
  Eigen::VectorXd power;                // of rows: up_share up_power + (1 - up_share) down_power
  // Errors of the exchange with the part above: one vector over rows for each replicate, whose squares add up to the
  // variance. Empty where there is one environment.
  std::vector<Eigen::VectorXd> up_errors;
};

// Makes it.
//   In: closed: exchange areas; enclosure: temperatures of the environment, and its parts where it has two;
//     power_of: emissive power of a temperature, W/m2, less the shift of the solution
//   Throws: Error bad_usage where sky and ground have temperatures, and their shares are not those of all rows.
Outside makeOutside(const ClosedExchange& closed, const Enclosure& enclosure,
                    const std::function<double(double temperature)>& power_of);

}  // namespace viewpeel
