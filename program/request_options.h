// Commands `compute` and `plan` share options, and requestOf() makes a request of them.
#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>
#include <string>

#include <viewpeel/request.h>

#include "program/options.h"

namespace viewpeel::program {

struct RequestOptions {
  std::vector<std::string> scene;  // its files
  std::string groups;
  // Options that depend on no other option are set in `request`; the members below determine the rest of it.
  Request request;
  std::optional<double> tolerance, relative, rms, seconds, epsilon;
  EpsilonDelta guarantee;
  std::string part;  // K/N; empty for the whole run
};

std::shared_ptr<RequestOptions> addRequestOptions(CLI::App* command);

// Makes the request after parsing.    Throws: Error bad_usage for options that contradict each other.
Request requestOf(const CLI::App* command, const RequestOptions& options);

// Reads a scene of one file or several, and prints its warnings on stderr.
Scene loadSceneOf(const std::vector<std::string>& files, const SceneOptions& options, const std::string& groups = "");

}  // namespace viewpeel::program
