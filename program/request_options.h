// What `compute` and `plan` share: their options, and the request that these come to.
#pragma once
#include <memory>
#include <optional>
#include <string>

#include <viewpeel/request.h>

#include "program/options.h"

namespace viewpeel::program {

struct RequestOptions {
  std::string scene;
  // What needs no more than its option; the rest of it is made of what follows.
  Request request;
  std::optional<double> tolerance, relative, seconds, epsilon;
  EpsilonDelta guarantee;
};

std::shared_ptr<RequestOptions> addRequestOptions(CLI::App* command);

// What is asked for, once all options are read.    Throws: Error bad_usage for those that contradict each other.
Request requestOf(const CLI::App* command, const RequestOptions& options);

// Reads a scene and prints what is doubtful about it on stderr.
Scene loadSceneOf(const std::string& file, const SceneOptions& options);

}  // namespace viewpeel::program
