#pragma once
#include <cstdint>

namespace viewpeel {

// Hdf5Silence switches HDF5's printing of errors off while it lives.
class Hdf5Silence {
 public:
  Hdf5Silence();
  ~Hdf5Silence();
  Hdf5Silence(const Hdf5Silence&) = delete;

 private:
  int (*print_)(int64_t, void*) = nullptr;
  void* print_data_ = nullptr;
};

}  // namespace viewpeel
