#include "io/hdf5_file.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <optional>
#include <type_traits>
#include <utility>

#include <fmt/format.h>
#include <hdf5.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <viewpeel/error.h>
#include "io/check_sum.h"

namespace viewpeel {
namespace {

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

Handle stringType(size_t width) {
  const hid_t id = H5Tcopy(H5T_C_S1);
  H5Tset_size(id, width);
  H5Tset_strpad(id, H5T_STR_NULLPAD);
  H5Tset_cset(id, H5T_CSET_UTF8);
  return {id, H5Tclose};
}

// Opens an unnamed file in memory, in which only what is written takes memory: columns of writeLater(), whose values
// HDF5 never gets, take none. Returns -1 where there is none, and where the process has a limit on the size of files:
// it would count for this file, too, and HDF5 may crash where it cannot write.
int openMemory() {
  rlimit limit{};
  const bool is_limited = ::getrlimit(RLIMIT_FSIZE, &limit) != 0 || limit.rlim_cur != RLIM_INFINITY;
  return is_limited ? -1 : ::memfd_create("hdf5", MFD_CLOEXEC);
}

// Creates a file that HDF5 writes into the unnamed file, or where there is none into a buffer of its own.
hid_t createFile(int memory) {
  const Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose), access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_obj_track_times(creation, false);
  if (memory < 0) {
    H5Pset_fapl_core(access, kGrowthBytes, false);
    return H5Fcreate("buffer", H5F_ACC_TRUNC, creation, access);
  }
  // HDF5's first driver refuses the name of a descriptor as a link that leads nowhere; the driver of C's streams takes
  // it.
  H5Pset_fapl_stdio(access);
  return H5Fcreate(fmt::format("/proc/self/fd/{}", memory).c_str(), H5F_ACC_TRUNC, creation, access);
}

[[noreturn]] void failToWrite(const std::string& what) {
  throw Error(ErrorCode::limit,
              fmt::format("HDF5 cannot make {}, probably for lack of memory; try --by surface", what));
}

constexpr size_t kCopiedBytes = 1 << 20;

// CheckSummed passes bytes on, and at the end their check sum.
class CheckSummed {
 public:
  explicit CheckSummed(std::function<void(const std::vector<char>& bytes)> use) : use_(std::move(use)) {}

  void add(const std::vector<char>& bytes) {
    use_(bytes);
    // The check sum takes words of 8 bytes. What is left of the last word waits for the next bytes.
    size_t first = 0;
    if (!rest_.empty()) {
      first = std::min(kCheckSumBytes - rest_.size(), bytes.size());
      rest_.insert(rest_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(first));
      if (rest_.size() < kCheckSumBytes) return;
      sum_.add(rest_.data(), rest_.size());
      rest_.clear();
    }
    const size_t whole = (bytes.size() - first) / kCheckSumBytes * kCheckSumBytes;
    sum_.add(bytes.data() + first, whole);
    rest_.assign(bytes.begin() + static_cast<std::ptrdiff_t>(first + whole), bytes.end());
  }
  void end() {
    sum_.add(rest_.data(), rest_.size());
    const auto appended = sum_.bytes();
    use_({appended.begin(), appended.end()});
  }

 private:
  std::function<void(const std::vector<char>& bytes)> use_;
  CheckSum sum_;
  std::vector<char> rest_;
};

// Makes the groups in a column's name, without times of creation, which HDF5 would add by itself.
void makeGroups(hid_t file, const std::string& name) {
  const Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation, false);
  for (size_t slash = name.find('/'); slash != std::string::npos; slash = name.find('/', slash + 1)) {
    const std::string group = name.substr(0, slash);
    if (H5Lexists(file, group.c_str(), H5P_DEFAULT) == 0)
      const Handle made(H5Gcreate2(file, group.c_str(), H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose);
  }
}

bool writeColumn(hid_t file, const std::string& name, hid_t native, hid_t stored, hsize_t count, const void* values) {
  makeGroups(file, name);
  const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation, false);
  const Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose);
  const Handle column(H5Dcreate2(file, name.c_str(), stored, space, H5P_DEFAULT, creation, H5P_DEFAULT), H5Dclose);
  return column.isValid() && H5Dwrite(column, native, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0;
}

// Makes the type of UTF-8 texts of any length.
Handle anyLengthType() {
  const hid_t id = H5Tcopy(H5T_C_S1);
  H5Tset_size(id, H5T_VARIABLE);
  H5Tset_cset(id, H5T_CSET_UTF8);
  return {id, H5Tclose};
}

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

// Writes an attribute.    In: space: shape of its values
bool writeAttribute(hid_t file, const std::string& object, const std::string& name, hid_t stored, hid_t native,
                    hid_t space, const void* values) {
  const Handle opened(H5Oopen(file, object.c_str(), H5P_DEFAULT), H5Oclose);
  const Handle attribute(H5Acreate2(opened, name.c_str(), stored, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return attribute.isValid() && H5Awrite(attribute, native, values) >= 0;
}

// A Reference is a column that uses a dimension scale, with the number of the column's dimension.
struct Reference {
  hobj_ref_t column;
  int32_t dimension;
};

bool writeReferences(hid_t file, const std::string& scale, const std::vector<std::string>& users) {
  std::vector<Reference> references(users.size(), Reference{0, 0});
  for (size_t k = 0; k < users.size(); ++k)
    if (H5Rcreate(&references[k].column, file, users[k].c_str(), H5R_OBJECT, -1) < 0) return false;
  const Handle type(H5Tcreate(H5T_COMPOUND, sizeof(Reference)), H5Tclose);
  H5Tinsert(type, "dataset", HOFFSET(Reference, column), H5T_STD_REF_OBJ);
  H5Tinsert(type, "dimension", HOFFSET(Reference, dimension), H5T_STD_I32LE);
  const hsize_t count = references.size();
  const Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose);
  return writeAttribute(file, scale, "REFERENCE_LIST", type, type, space, references.data());
}

}  // namespace

Hdf5Silence::Hdf5Silence() {
  H5Eget_auto2(H5E_DEFAULT, &print_, &print_data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Hdf5Silence::~Hdf5Silence() { H5Eset_auto2(H5E_DEFAULT, print_, print_data_); }

ByteSink::ByteSink(std::function<void(const std::vector<char>& bytes)> use) : use_(std::move(use)) {
  block_.reserve(kBlockBytes + sizeof(uint64_t));
}

void ByteSink::flush() {
  if (!block_.empty()) use_(block_);
  block_.clear();
}

Hdf5Output::Hdf5Output() : memory_(openMemory()), id_(createFile(memory_)) {
  if (id_ >= 0) return;
  if (memory_ >= 0) ::close(memory_);
  failToWrite("the file");
}

Hdf5Output::~Hdf5Output() {
  if (id_ >= 0) H5Fclose(id_);
  if (memory_ >= 0) ::close(memory_);
}

template <class T>
void Hdf5Output::writeLater(const std::string& name, size_t count, std::function<void(ByteSink&)> make) {
  makeGroups(id_, name);
  const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation, false);
  H5Pset_alloc_time(creation, H5D_ALLOC_TIME_EARLY);
  H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER);
  const hsize_t length = count;
  const Handle space(H5Screate_simple(1, &length, nullptr), H5Sclose);
  const Handle column(H5Dcreate2(id_, name.c_str(), typeOf<T>().stored, space, H5P_DEFAULT, creation, H5P_DEFAULT),
                      H5Dclose);
  if (!column.isValid()) failToWrite(name);
  if (count == 0) return;
  const haddr_t place = H5Dget_offset(column);
  if (place == HADDR_UNDEF) failToWrite(name);
  later_.push_back({name, place, count * sizeof(T), std::move(make)});
}

template <class T>
void Hdf5Output::write(const std::string& name, const std::vector<T>& values) {
  bool written;
  if constexpr (std::is_same_v<T, std::string>) {
    size_t width = 1;
    for (const std::string& text : values) width = std::max(width, text.size());
    std::vector<char> padded(values.size() * width, '\0');
    for (size_t k = 0; k < values.size(); ++k)
      std::copy(values[k].begin(), values[k].end(), padded.begin() + static_cast<std::ptrdiff_t>(k * width));
    const Handle type = stringType(width);
    written = writeColumn(id_, name, type, type, values.size(), padded.data());
  } else {
    written = writeColumn(id_, name, typeOf<T>().native, typeOf<T>().stored, values.size(), values.data());
  }
  if (!written) failToWrite(name);
}

void Hdf5Output::writeTexts(const std::string& name, const std::vector<std::string>& values) {
  std::vector<const char*> pointers;
  for (const std::string& text : values) pointers.push_back(text.c_str());
  const Handle type = anyLengthType();
  if (!writeColumn(id_, name, type, type, values.size(), pointers.data())) failToWrite(name);
}

void Hdf5Output::link(const std::string& name, const std::string& column) {
  makeGroups(id_, name);
  if (H5Lcreate_hard(id_, column.c_str(), id_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT) < 0) failToWrite(name);
}

template <class T>
void Hdf5Output::setAttribute(const std::string& object, const std::string& name, const T& value) {
  const Handle scalar(H5Screate(H5S_SCALAR), H5Sclose);
  bool written;
  if constexpr (std::is_same_v<T, std::string>) {
    const Handle type = anyLengthType();
    const char* text = value.c_str();
    written = writeAttribute(id_, object, name, type, type, scalar, &text);
  } else if constexpr (std::is_same_v<T, std::vector<int64_t>>) {
    const hsize_t count = value.size();
    const Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose);
    written = writeAttribute(id_, object, name, H5T_STD_I64LE, H5T_NATIVE_INT64, space, value.data());
  } else {
    written = writeAttribute(id_, object, name, typeOf<T>().stored, typeOf<T>().native, scalar, &value);
  }
  if (!written) failToWrite(name);
}

void Hdf5Output::makeScale(const std::string& column) {
  const Handle scalar(H5Screate(H5S_SCALAR), H5Sclose);
  const std::string name = column.substr(column.rfind('/') + 1);
  for (const auto& [attribute, text] :
       {std::pair<std::string, std::string>("CLASS", "DIMENSION_SCALE"), {"NAME", name}}) {
    const Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(type, text.size() + 1);
    if (!writeAttribute(id_, column, attribute, type, type, scalar, text.c_str())) failToWrite(column);
  }
}

void Hdf5Output::useScale(const std::string& column, const std::string& scale) {
  hobj_ref_t reference = 0;
  const Handle type(H5Tvlen_create(H5T_STD_REF_OBJ), H5Tclose);
  const hsize_t dimensions = 1;
  const Handle space(H5Screate_simple(1, &dimensions, nullptr), H5Sclose);
  const bool is_found = H5Rcreate(&reference, id_, scale.c_str(), H5R_OBJECT, -1) >= 0;
  const hvl_t list{1, &reference};
  if (!is_found || !writeAttribute(id_, column, "DIMENSION_LIST", type, type, space, &list)) failToWrite(column);
  users_[scale].push_back(column);
}

// Passes all bytes on in their order: those that HDF5 wrote, and between them those of columns that are made now.
//   In: leave: called for columns that others write
void Hdf5Output::finishTo(const std::function<void(const std::vector<char>& bytes)>& use,
                          const std::function<void(const Later& column)>& leave) {
  for (const auto& [scale, users] : users_)
    if (!writeReferences(id_, scale, users)) failToWrite(scale);
  if (H5Fflush(id_, H5F_SCOPE_GLOBAL) < 0) failToWrite("the file");
  std::vector<char> image;  // of the buffer
  if (memory_ >= 0) {
    // An open file says in its head that it is open.
    if (H5Fclose(std::exchange(id_, -1)) < 0) failToWrite("the file");
  } else {
    const ssize_t size = H5Fget_file_image(id_, nullptr, 0);
    image.resize(static_cast<size_t>(std::max<ssize_t>(size, 0)));
    if (size <= 0 || H5Fget_file_image(id_, image.data(), image.size()) < 0) failToWrite("the file");
  }
  const auto size = memory_ < 0 ? static_cast<off_t>(image.size()) : ::lseek(memory_, 0, SEEK_END);
  if (size <= 0) failToWrite("the file");
  uint64_t at = 0;
  const auto copyTo = [&](uint64_t end) {
    std::vector<char> block;
    for (; at < end; at += block.size()) {
      block.resize(std::min<uint64_t>(end - at, kCopiedBytes));
      if (memory_ < 0) std::copy_n(image.begin() + static_cast<std::ptrdiff_t>(at), block.size(), block.begin());
      else if (::pread(memory_, block.data(), block.size(), static_cast<off_t>(at)) !=
               static_cast<ssize_t>(block.size()))
        failToWrite("the file");
      use(block);
    }
  };
  std::ranges::sort(later_, {}, &Later::place);
  for (const Later& column : later_) {
    copyTo(column.place);
    if (!column.make) {
      leave(column);
      at += column.size;
      continue;
    }
    ByteSink sink([&](const std::vector<char>& bytes) {
      use(bytes);
      at += bytes.size();
    });
    column.make(sink);
    sink.flush();
    if (at != column.place + column.size) failToWrite("a column, which has another length");
  }
  copyTo(static_cast<uint64_t>(size));
}

void Hdf5Output::finish(std::ostream& out) {
  CheckSummed summed(
      [&](const std::vector<char>& bytes) { out.write(bytes.data(), static_cast<std::streamsize>(bytes.size())); });
  finishTo([&](const std::vector<char>& bytes) { summed.add(bytes); }, {});
  summed.end();
}

std::vector<char> Hdf5Output::finish() {
  std::vector<char> all;
  CheckSummed summed([&](const std::vector<char>& bytes) { all.insert(all.end(), bytes.begin(), bytes.end()); });
  finishTo([&](const std::vector<char>& bytes) { summed.add(bytes); }, {});
  summed.end();
  return all;
}

std::map<std::string, uint64_t> Hdf5Output::finishFrame(std::ostream& out) {
  std::map<std::string, uint64_t> places;
  finishTo([&](const std::vector<char>& bytes) { out.write(bytes.data(), static_cast<std::streamsize>(bytes.size())); },
           [&](const Later& column) {
             places[column.name] = column.place;
             out.seekp(static_cast<std::streamoff>(column.size), std::ios::cur);
           });
  return places;
}

void endFrame(const std::string& file) {
  const auto fail = [&] {
    throw Error(ErrorCode::output,
                fmt::format("{}: cannot write: {}; choose another place", file, std::strerror(errno ? errno : EIO)));
  };
  errno = 0;
  std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
  CheckSum sum;
  std::vector<char> block(kCopiedBytes);
  while (stream.read(block.data(), static_cast<std::streamsize>(block.size())) || stream.gcount() > 0)
    sum.add(block.data(), static_cast<size_t>(stream.gcount()));
  if (!stream.eof()) fail();
  stream.clear();
  const auto appended = sum.bytes();
  stream.seekp(0, std::ios::end);
  stream.write(appended.data(), appended.size());
  stream.close();
  if (!stream) fail();
}

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

template void Hdf5Output::write(const std::string&, const std::vector<uint8_t>&);
template void Hdf5Output::write(const std::string&, const std::vector<int32_t>&);
template void Hdf5Output::write(const std::string&, const std::vector<int64_t>&);
template void Hdf5Output::write(const std::string&, const std::vector<uint32_t>&);
template void Hdf5Output::write(const std::string&, const std::vector<uint64_t>&);
template void Hdf5Output::write(const std::string&, const std::vector<double>&);
template void Hdf5Output::write(const std::string&, const std::vector<std::string>&);
template void Hdf5Output::writeLater<uint8_t>(const std::string&, size_t, std::function<void(ByteSink&)>);
template void Hdf5Output::writeLater<int32_t>(const std::string&, size_t, std::function<void(ByteSink&)>);
template void Hdf5Output::writeLater<uint32_t>(const std::string&, size_t, std::function<void(ByteSink&)>);
template void Hdf5Output::writeLater<uint64_t>(const std::string&, size_t, std::function<void(ByteSink&)>);
template void Hdf5Output::writeLater<int64_t>(const std::string&, size_t, std::function<void(ByteSink&)>);
template void Hdf5Output::writeLater<double>(const std::string&, size_t, std::function<void(ByteSink&)>);
template void Hdf5Output::setAttribute(const std::string&, const std::string&, const std::string&);
template void Hdf5Output::setAttribute(const std::string&, const std::string&, const int64_t&);
template void Hdf5Output::setAttribute(const std::string&, const std::string&, const double&);
template void Hdf5Output::setAttribute(const std::string&, const std::string&, const std::vector<int64_t>&);
bool Hdf5Input::has(const std::string& name) const { return H5Lexists(id_, name.c_str(), H5P_DEFAULT) > 0; }

template std::vector<uint8_t> Hdf5Input::read(const std::string&, std::optional<size_t>);
template std::vector<int32_t> Hdf5Input::read(const std::string&, std::optional<size_t>);
template std::vector<int64_t> Hdf5Input::read(const std::string&, std::optional<size_t>);
template std::vector<uint32_t> Hdf5Input::read(const std::string&, std::optional<size_t>);
template std::vector<uint64_t> Hdf5Input::read(const std::string&, std::optional<size_t>);
template std::vector<double> Hdf5Input::read(const std::string&, std::optional<size_t>);
template std::vector<std::string> Hdf5Input::read(const std::string&, std::optional<size_t>);

}  // namespace viewpeel
