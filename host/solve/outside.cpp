#include "solve/outside.h"

#include <viewpeel/error.h>

namespace viewpeel {

using Eigen::VectorXd;

Outside makeOutside(const ClosedExchange& closed, const Enclosure& enclosure,
                    const std::function<double(double temperature)>& power_of) {
  const Eigen::Index n = closed.areas.size();
  Outside outside{.up_share = VectorXd::Ones(n), .power = VectorXd::Zero(n)};
  if (!closed.is_open) return outside;
  if (!enclosure.sky_and_ground) {
    outside.up_power = outside.down_power = power_of(*enclosure.environment_temperature);
    outside.power.setConstant(outside.up_power);
    return outside;
  }
  const std::optional<EnvironmentParts>& parts = enclosure.environment_parts;
  if (!parts || parts->up_share.size() != static_cast<size_t>(n))
    throw Error(ErrorCode::bad_usage,
                "sky and ground have two temperatures, so the environment of each row is needed in two parts; "
                "give Enclosure::environment_parts by measureEnvironment");
  outside.up_power = power_of(enclosure.sky_and_ground->up);
  outside.down_power = power_of(enclosure.sky_and_ground->down);
  for (Eigen::Index i = 0; i < n; ++i) outside.up_share[i] = parts->up_share[static_cast<size_t>(i)].value;
  outside.power = outside.up_power * outside.up_share + outside.down_power * (VectorXd::Ones(n) - outside.up_share);
  for (const std::vector<double>& errors : parts->up_share_errors)
    outside.up_errors.push_back(closed.environment.cwiseProduct(Eigen::Map<const VectorXd>(errors.data(), n)));
  return outside;
}

}  // namespace viewpeel
