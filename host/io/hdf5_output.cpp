#include "io/hdf5_output.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <viewpeel/error.h>
#include "io/check_sum.h"
#include "io/hdf5_types.h"

namespace viewpeel {
namespace {

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

}  // namespace viewpeel
