// This file sets how the process takes memory from the system, and gives it back.
#pragma once
#include <cstddef>
#include <cstdint>
#include <istream>

namespace viewpeel {

// Keeps freed memory in the process and reserves huge pages.
//
// Lists as large as the matrix come and go with every replicate, and the kernel clears each page that a process gets.
// With 9,984 polygons a quarter of the time went into clearing. The peak of memory grows by an eighth. Half of the
// free memory is reserved, marked for huge pages and freed again, before any page is touched. Where the reservation
// fails, or under a sanitizer, pages stay small. A program calls this once, before it allocates much.
void keepFreedMemory();

// Makes allocations throw std::bad_alloc once they exceed the memory that is free now. Without this call the system
// grants any memory, and kills the process when there is none left. A program calls this once, at its start. It does
// nothing under a sanitizer.
//   Out: bytes of free memory of the machine, or of what control groups and limits of the process allow if that is
//     less; 0 where the machine does not say
uint64_t limitMemory();

// Returns the bytes that the system can give to processes: free, held by caches alone, or in free swap space.
//   In: meminfo: the text of /proc/meminfo    Out: 0 where it does not say
uint64_t freeMemory(std::istream& meminfo);

// Freeing a list of more entries than this, each of 30 to 60 bytes, is worth a call of returnFreedMemory().
constexpr size_t kLargeList = 5'000'000;

// Returns freed memory to the system. A list as large as the matrix leaves a hole, which smaller lists break up before
// the next one of its size.    Cost: the kernel clears pages that are used again, some 0.3 s a GB.
void returnFreedMemory();

}  // namespace viewpeel
