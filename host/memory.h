#pragma once
#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>

namespace viewpeel {

// What is freed stays with the process: lists as large as the matrix come and go with every replicate, and memory that
// the kernel gives anew is cleared first. A quarter of the time of 9,984 polygons went there; the peak grows by an
// eighth. And what is yet to be had comes in huge pages: half of the machine's memory is asked for, said to be of
// these, and given back before any of it is written to. Where there is less to be had, or a sanitizer marks what is
// allocated, pages stay small. For programs, before they allocate much.
inline void keepFreedMemory() {
  ::mallopt(M_MMAP_MAX, 0);
  ::mallopt(M_TRIM_THRESHOLD, -1);  // never
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

}  // namespace viewpeel
