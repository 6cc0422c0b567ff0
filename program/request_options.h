// Commands `compute` and `plan` share their options, and the request that these come to.
#pragma once
#include <memory>
#include <optional>
#include <string>

#include <viewpeel/request.h>

#include "program/options.h"

namespace viewpeel::program {

struct RequestOptions {
  std::string scene, groups;
  // The request has options that need no other option; the members below make the rest of it.
  Request request;
  std::optional<double> tolerance, relative, seconds, epsilon;
  EpsilonDelta guarantee;
  std::string part;  // K/N; empty for all of a run
};

std::shared_ptr<RequestOptions> addRequestOptions(CLI::App* command);

// Makes the request, once all options are read.    Throws: Error bad_usage for options that contradict each other.
Request requestOf(const CLI::App* command, const RequestOptions& options);

// Reads a scene and prints its warnings on stderr.
Scene loadSceneOf(const std::string& file, const SceneOptions& options, const std::string& groups = "");

}  // namespace viewpeel::program
