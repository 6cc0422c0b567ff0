// A LineServer draws pair lines on ranks other than 0, as rank 0 asks. Every rank finds all pairs itself, so that
// messages name pairs by their numbers.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "pair_lines/pair_lines.h"
#include "ranks/message.h"

namespace viewpeel {

class LineServer {
 public:
  //   In: scene: referred to; threads: 0: one a core; stop: may throw; device: opens the device of this rank, called
  //   where rank 0 draws lines on its own
  LineServer(const Scene& scene, size_t threads, std::function<void()> stop, std::function<const Device*()> device);

  // Does what a message of rank 0 asks for, and returns the answer.
  //   In: work: the first byte of the message; in: what follows it    Throws: what PairLines throws.
  std::string answer(RankWork work, MessageReader& in);

 private:
  std::string find(MessageReader& in);
  std::string plan(MessageReader& in);
  std::string takePairs(MessageReader& in);
  std::string count(MessageReader& in);
  std::string drawUniform(MessageReader& in);
  std::string drawStrata(MessageReader& in);

  const Scene& scene_;
  size_t threads_;
  std::function<void()> stop_;
  std::function<const Device*()> device_;
  std::unique_ptr<const Ids> face_ids_;
  std::optional<PairLines> lines_;
  std::vector<LinePair> pairs_;
};

}  // namespace viewpeel
