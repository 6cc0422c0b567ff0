// This file alone calls MPI.
#include <mpi.h>

#include <algorithm>
#include <cstdlib>

#include "program/ranks/job.h"
#include "program/ranks/launcher.h"

namespace viewpeel::program {
namespace {

constexpr int kLengthTag = 1, kBytesTag = 2;
constexpr size_t kMostBytes = size_t(1) << 30;  // of one MPI message, whose length is an int

class MpiRanks final : public Ranks {
 public:
  MpiRanks() {
    ::MPI_Init(nullptr, nullptr);
    int number = 0;
    ::MPI_Comm_size(MPI_COMM_WORLD, &number);
    size_ = static_cast<uint32_t>(number);
    ::MPI_Comm_rank(MPI_COMM_WORLD, &number);
    rank_ = static_cast<uint32_t>(number);
  }
  ~MpiRanks() override {
    // A rank that does not answer any more would keep the others waiting in MPI_Finalize.
    if (rank_ == 0 && !endRanks(*this)) ::MPI_Abort(MPI_COMM_WORLD, EXIT_FAILURE);
    ::MPI_Finalize();
  }
  MpiRanks(const MpiRanks&) = delete;
  MpiRanks& operator=(const MpiRanks&) = delete;

  uint32_t size() const override { return size_; }
  uint32_t rank() const override { return rank_; }

  void send(uint32_t to, const std::string& message) override {
    uint64_t length = message.size();
    ::MPI_Send(&length, 1, MPI_UINT64_T, static_cast<int>(to), kLengthTag, MPI_COMM_WORLD);
    for (size_t first = 0; first < length; first += kMostBytes)
      ::MPI_Send(message.data() + first, static_cast<int>(std::min(kMostBytes, length - first)), MPI_BYTE,
                 static_cast<int>(to), kBytesTag, MPI_COMM_WORLD);
  }

  std::optional<std::string> poll(uint32_t from) override {
    const int rank = static_cast<int>(from);
    int is_there = 0;
    ::MPI_Iprobe(rank, kLengthTag, MPI_COMM_WORLD, &is_there, MPI_STATUS_IGNORE);
    if (!is_there) return std::nullopt;
    uint64_t length = 0;
    ::MPI_Recv(&length, 1, MPI_UINT64_T, rank, kLengthTag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    std::string message(length, 0);
    for (size_t first = 0; first < length; first += kMostBytes)
      ::MPI_Recv(message.data() + first, static_cast<int>(std::min(kMostBytes, length - first)), MPI_BYTE, rank,
                 kBytesTag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    return message;
  }

 private:
  uint32_t size_ = 1, rank_ = 0;
};

}  // namespace

std::unique_ptr<Ranks> joinJob() {
  if (launchedRanks() < 2) return nullptr;
  return std::make_unique<MpiRanks>();
}

}  // namespace viewpeel::program
