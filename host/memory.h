// keepFreedMemory() makes the process keep freed memory, and take new memory in huge pages. returnFreedMemory() gives
// it back once.
#pragma once
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>

namespace viewpeel {

// Keeps freed memory in the process and reserves huge pages.
//
// Lists as large as the matrix come and go with every replicate, and the kernel clears each page that a process gets.
// With 9,984 polygons a quarter of the time went into clearing. The peak of memory grows by an eighth. Half of the
// machine's memory is reserved, marked for huge pages and freed again, before any page is touched. Where the
// reservation fails, or under a sanitizer, pages stay small. A program calls this once, before it allocates much.
inline void keepFreedMemory() {
  ::mallopt(M_MMAP_MAX, 0);
  ::mallopt(M_TRIM_THRESHOLD, -1);  // never return memory to the system
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  const size_t bytes = size_t(::sysconf(_SC_PHYS_PAGES)) * size_t(::sysconf(_SC_PAGESIZE)) / 2;
  char* const ahead = static_cast<char*>(std::malloc(bytes));
  if (!ahead) return;
  constexpr uintptr_t kHuge = uintptr_t(1) << 21;
  char* const first = ahead + (kHuge - reinterpret_cast<uintptr_t>(ahead) % kHuge);
  ::madvise(first, (bytes - size_t(first - ahead)) / kHuge * kHuge, MADV_HUGEPAGE);
  std::free(ahead);
#endif
}

// Freeing a list of more entries than this, each of 30 to 60 bytes, is worth a call of returnFreedMemory().
constexpr size_t kLargeList = 5'000'000;

// Returns freed memory to the system. A list as large as the matrix leaves a hole, which smaller lists break up before
// the next one of its size.    Cost: the kernel clears pages that are used again, some 0.3 s a GB.
inline void returnFreedMemory() { ::malloc_trim(0); }

}  // namespace viewpeel
