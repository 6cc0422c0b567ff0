// What readers and writers of HDF5 files share. Only files of this folder whose names begin with hdf5 include it.
#pragma once
#include <cstdint>
#include <string>
#include <type_traits>

#include <hdf5.h>

namespace viewpeel {

static_assert(std::is_same_v<hid_t, int64_t> && std::is_same_v<H5E_auto2_t, int (*)(int64_t, void*)>);

constexpr size_t kGrowthBytes = 1 << 20;  // bytes by which a file in memory grows

// A Handle is an HDF5 identifier that closes itself. It is below 0 where HDF5 failed.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  operator hid_t() const { return id_; }
  bool isValid() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

// A Type is an HDF5 type in memory and in files, where it is little-endian on all machines.
struct Type {
  hid_t native, stored;
};
template <class T>
Type typeOf() {
  if constexpr (std::is_same_v<T, uint8_t>) return {H5T_NATIVE_UINT8, H5T_STD_U8LE};
  else if constexpr (std::is_same_v<T, int32_t>) return {H5T_NATIVE_INT32, H5T_STD_I32LE};
  else if constexpr (std::is_same_v<T, int64_t>) return {H5T_NATIVE_INT64, H5T_STD_I64LE};
  else if constexpr (std::is_same_v<T, uint32_t>) return {H5T_NATIVE_UINT32, H5T_STD_U32LE};
  else if constexpr (std::is_same_v<T, uint64_t>) return {H5T_NATIVE_UINT64, H5T_STD_U64LE};
  else return {H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE};
}

// Returns the type of texts of one width, and of UTF-8 texts of any length.
Handle stringType(size_t width);
Handle anyLengthType();

}  // namespace viewpeel
