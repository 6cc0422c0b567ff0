#include "io/hdf5_types.h"

namespace viewpeel {

Handle stringType(size_t width) {
  const hid_t id = H5Tcopy(H5T_C_S1);
  H5Tset_size(id, width);
  H5Tset_strpad(id, H5T_STR_NULLPAD);
  H5Tset_cset(id, H5T_CSET_UTF8);
  return {id, H5Tclose};
}

Handle anyLengthType() {
  const hid_t id = H5Tcopy(H5T_C_S1);
  H5Tset_size(id, H5T_VARIABLE);
  H5Tset_cset(id, H5T_CSET_UTF8);
  return {id, H5Tclose};
}

}  // namespace viewpeel
