// Ranks are processes that share one computation, such as the processes of an MPI job. Rank 0 plans, decides, and has
// the result; the other ranks count what it hands out. The library knows no MPI: a caller brings the communication.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include <viewpeel/error.h>
#include <viewpeel/request.h>

namespace viewpeel {

// A Ranks is one process's end of the communication. Messages between two ranks arrive in the order in which they were
// sent.
class Ranks {
 public:
  virtual ~Ranks() = default;

  virtual uint32_t size() const = 0;  // number of ranks
  virtual uint32_t rank() const = 0;  // number of this one, from 0
  // Sends bytes to another rank. It may wait until they are received.
  virtual void send(uint32_t to, const std::string& message) = 0;
  // Returns the next message from a rank; nothing where none has arrived. The thread that called send() calls it.
  virtual std::optional<std::string> poll(uint32_t from) = 0;
};

// Counts for rank 0, until rank 0 calls endRanks(). All other ranks call this while rank 0 runs a FormFactorRun with
// Request::ranks. Results are the same bits for every number of ranks.
//   In: ranks: of this process, above rank 0; scene: the scene of rank 0, from the same file; request: device, threads,
//     batch_directions and exact_engine of this rank; rank 0 sends the rest
//   Throws: nothing that rank 0 can report: it gets errors, and ends the run with them.
//   Cost: this rank's share of directions and lines. Every rank holds the scene and finds all pairs itself.
void serveRanks(Ranks& ranks, const Scene& scene, const Request& request);
// Answers everything that rank 0 asks with an error, until rank 0 calls endRanks(). For a rank that has no scene.
void serveRanks(Ranks& ranks, const Error& failure);

// Ends the other ranks' serveRanks(). Rank 0 calls it once, after its last run.
//   Out: false where some rank has not answered within 10 s
bool endRanks(Ranks& ranks);

}  // namespace viewpeel
