#include "io/hdf5_input.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <type_traits>

#include <fmt/format.h>

#include <viewpeel/error.h>
#include "io/check_sum.h"
#include "io/hdf5_types.h"

namespace viewpeel {
namespace {

// Returns a scalar text or number as text; nothing where the attribute is something else.
std::optional<std::string> attributeInWords(hid_t object, const char* name) {
  const Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  const Handle stored(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose);
  if (H5Sget_simple_extent_type(space) != H5S_SCALAR) return std::nullopt;
  if (H5Tget_class(stored) == H5T_STRING && H5Tis_variable_str(stored) > 0) {
    const Handle type = anyLengthType();
    char* text = nullptr;
    if (H5Aread(attribute, type, &text) < 0 || !text) return std::nullopt;
    std::string value = text;
    H5Dvlen_reclaim(type, space, H5P_DEFAULT, &text);
    return value;
  }
  int64_t whole = 0;
  if (H5Tget_class(stored) == H5T_INTEGER && H5Aread(attribute, H5T_NATIVE_INT64, &whole) >= 0)
    return fmt::format("{}", whole);
  double number = 0;
  if (H5Tget_class(stored) == H5T_FLOAT && H5Aread(attribute, H5T_NATIVE_DOUBLE, &number) >= 0)
    return fmt::format("{}", number);
  return std::nullopt;
}

}  // namespace

Hdf5Input::Hdf5Input(const std::filesystem::path& file, const char* kind, const char* remedy)
    : file_(file), kind_(kind), remedy_(remedy) {
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  const bool is_open = stream.good();
  std::error_code failure;
  if (!is_open || !std::filesystem::is_regular_file(file, failure))
    throw Error(ErrorCode::bad_input, fmt::format("{}: cannot be read: {}; check the name", file.string(),
                                                  is_open ? "it is not a regular file" : std::strerror(errno)));
  size_bytes_ = std::filesystem::file_size(file);
  if (!endsInCheckSum(stream, size_bytes_)) refuse("it is another file, cut off or damaged");
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_file_locking(access, false, true);  // some file systems cannot lock files
  id_ = H5Fopen(file.c_str(), H5F_ACC_RDONLY, access);
  if (id_ < 0) refuse("it is not HDF5");
}

Hdf5Input::Hdf5Input(const std::vector<char>& bytes, const std::string& name, const char* kind, const char* remedy)
    : file_(name), kind_(kind), remedy_(remedy), size_bytes_(bytes.size()) {
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_core(access, kGrowthBytes, false);
  std::vector<char> image = bytes;  // a copy, for HDF5 takes no constant bytes
  // HDF5 refuses an image with the name of a file on disk; no file can have this name, for /dev/null is no folder.
  if (H5Pset_file_image(access, image.data(), image.size()) >= 0)
    id_ = H5Fopen("/dev/null/image", H5F_ACC_RDONLY, access);
  if (id_ < 0) refuse("HDF5 cannot read it, probably for lack of memory");
}

Hdf5Input::~Hdf5Input() {
  if (id_ >= 0) H5Fclose(id_);
}

template <class T>
std::vector<T> Hdf5Input::read(const std::string& name, std::optional<size_t> wanted) {
  constexpr bool is_text = std::is_same_v<T, std::string>;
  const Handle column(H5Dopen2(id_, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!column.isValid()) refuse(fmt::format("it has no readable '{}'", name));
  const Handle space(H5Dget_space(column), H5Sclose), stored(H5Dget_type(column), H5Tclose);
  hsize_t count = 0;
  const size_t width = H5Tget_size(stored);
  const bool type_fits = is_text ? H5Tget_class(stored) == H5T_STRING && H5Tis_variable_str(stored) == 0 && width > 0
                                 : H5Tequal(stored, typeOf<std::conditional_t<is_text, double, T>>().stored) > 0;
  const bool shape_fits =
      H5Sget_simple_extent_ndims(space) == 1 && H5Sget_simple_extent_dims(space, &count, nullptr) == 1;
  if (!type_fits || !shape_fits || count > size_bytes_ / width)
    refuse(fmt::format("its '{}' is of another kind", name));
  if (wanted && count != *wanted) refuse(fmt::format("its '{}' has {} values for {}", name, count, *wanted));
  std::vector<T> values(count);
  bool is_read;
  if constexpr (is_text) {
    std::vector<char> padded(count * width);
    is_read = H5Dread(column, stringType(width), H5S_ALL, H5S_ALL, H5P_DEFAULT, padded.data()) >= 0;
    for (size_t k = 0; k < count; ++k)
      values[k].assign(padded.data() + k * width, strnlen(padded.data() + k * width, width));
  } else {
    is_read = H5Dread(column, typeOf<T>().native, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0;
  }
  if (!is_read) refuse(fmt::format("its '{}' cannot be read", name));
  return values;
}

std::vector<std::string> Hdf5Input::readTexts(const std::string& name) {
  const Handle column(H5Dopen2(id_, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!column.isValid()) refuse(fmt::format("it has no readable '{}'", name));
  const Handle space(H5Dget_space(column), H5Sclose), stored(H5Dget_type(column), H5Tclose);
  hsize_t count = 0;
  const bool shape_fits =
      H5Sget_simple_extent_ndims(space) == 1 && H5Sget_simple_extent_dims(space, &count, nullptr) == 1;
  if (H5Tget_class(stored) != H5T_STRING || H5Tis_variable_str(stored) <= 0 || !shape_fits || count > size_bytes_)
    refuse(fmt::format("its '{}' is of another kind", name));
  std::vector<char*> pointers(count, nullptr);
  const Handle type = anyLengthType();
  if (count > 0 && H5Dread(column, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data()) < 0)
    refuse(fmt::format("its '{}' cannot be read", name));
  std::vector<std::string> texts;
  for (const char* text : pointers) texts.emplace_back(text ? text : "");
  if (count > 0) H5Dvlen_reclaim(type, space, H5P_DEFAULT, pointers.data());
  return texts;
}

std::vector<std::pair<std::string, std::string>> Hdf5Input::attributes() {
  std::vector<std::pair<std::string, std::string>> found;
  const Handle root(H5Oopen(id_, "/", H5P_DEFAULT), H5Oclose);
  hsize_t place = 0;
  const auto add = [](hid_t object, const char* name, const H5A_info_t*, void* data) -> herr_t {
    auto& texts = *static_cast<std::vector<std::pair<std::string, std::string>>*>(data);
    if (const std::optional<std::string> value = attributeInWords(object, name)) texts.emplace_back(name, *value);
    return 0;
  };
  if (H5Aiterate2(root, H5_INDEX_NAME, H5_ITER_INC, &place, add, &found) < 0) refuse("its attributes cannot be read");
  return found;
}

void Hdf5Input::refuse(const std::string& reason) const {
  throw Error(ErrorCode::bad_input, fmt::format("{}: not a whole {}: {}; {}", file_.string(), kind_, reason, remedy_));
}

bool Hdf5Input::has(const std::string& name) const { return H5Lexists(id_, name.c_str(), H5P_DEFAULT) > 0; }

template std::vector<uint8_t> Hdf5Input::read(const std::string&, std::optional<size_t>);
template std::vector<int32_t> Hdf5Input::read(const std::string&, std::optional<size_t>);
template std::vector<int64_t> Hdf5Input::read(const std::string&, std::optional<size_t>);
template std::vector<uint32_t> Hdf5Input::read(const std::string&, std::optional<size_t>);
template std::vector<uint64_t> Hdf5Input::read(const std::string&, std::optional<size_t>);
template std::vector<double> Hdf5Input::read(const std::string&, std::optional<size_t>);
template std::vector<std::string> Hdf5Input::read(const std::string&, std::optional<size_t>);

}  // namespace viewpeel
