#include "io/npz_file.h"

#include <bit>
#include <type_traits>

#include <fmt/format.h>
#include <zlib.h>

namespace viewpeel {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are little-endian and copied as they are");

constexpr uint32_t kAllOnes = 0xFFFFFFFFu;  // marks a size or offset that the extra field holds in 64 bits
constexpr uint16_t kZip64Version = 45, kExtraZip64 = 1;
constexpr uint16_t kFirstOfJanuary1980 = 0x21;  // the first day that zip can express, for files without a time

// A ZipRecord collects the bytes of a record of a zip, little-endian.
class ZipRecord {
 public:
  template <class T>
  ZipRecord& add(T value) {
    for (size_t k = 0; k < sizeof value; ++k) bytes_ += static_cast<char>(value >> (8 * k));
    return *this;
  }
  ZipRecord& add(const std::string& text) {
    bytes_ += text;
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

template <class T>
const char* npyTypeOf() {
  return std::is_same_v<T, int32_t> ? "<i4" : std::is_same_v<T, int64_t> ? "<i8" : "<f8";
}

// Returns the header of a .npy file: magic, version, length, and a dictionary padded to a multiple of 64 bytes.
std::string npyHead(const std::string& type, const std::string& shape) {
  std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", type, shape);
  text.append((64 - (10 + text.size() + 1) % 64) % 64, ' ');
  text += '\n';
  return std::string("\x93NUMPY\x01\x00", 8) + ZipRecord().add(static_cast<uint16_t>(text.size())).bytes() + text;
}

}  // namespace

template <class T>
void NpzOutput::write(const std::string& name, std::span<const T> values) {
  add(name, npyHead(npyTypeOf<T>(), fmt::format("({},)", values.size())), values.size_bytes(), [&](const auto& use) {
    use({reinterpret_cast<const char*>(values.data()), values.size_bytes()});
  });
}

template <class T>
void NpzOutput::write(const std::string& name, size_t count, const std::function<void(const UseBytes&)>& forEachPart) {
  add(name, npyHead(npyTypeOf<T>(), fmt::format("({},)", count)), count * sizeof(T), forEachPart);
}

void NpzOutput::writeText(const std::string& name, const std::string& text) {
  add(name, npyHead(fmt::format("|S{}", text.size()), "()"), text.size(), [&](const auto& use) {
    use({text.data(), text.size()});
  });
}

void NpzOutput::add(const std::string& name, const std::string& head, size_t size,
                    const std::function<void(const UseBytes&)>& forEachPart) {
  uLong sum = 0;
  const auto addToSum = [&](std::span<const char> part) {
    sum = crc32_z(sum, reinterpret_cast<const Bytef*>(part.data()), part.size());
  };
  addToSum(head);
  forEachPart(addToSum);
  const Member member{name + ".npy", static_cast<uint32_t>(sum), head.size() + size, place_};
  ZipRecord record;
  record.add(uint32_t(0x04034b50)).add(kZip64Version).add(uint16_t(0)).add(uint16_t(0)).add(uint16_t(0));
  record.add(kFirstOfJanuary1980).add(member.check_sum).add(kAllOnes).add(kAllOnes);
  record.add(static_cast<uint16_t>(member.name.size())).add(uint16_t(20)).add(member.name);
  record.add(kExtraZip64).add(uint16_t(16)).add(member.size).add(member.size);
  out_ << record.bytes() << head;
  forEachPart([&](std::span<const char> part) { out_.write(part.data(), static_cast<std::streamsize>(part.size())); });
  place_ += record.bytes().size() + member.size;
  members_.push_back(member);
}

void NpzOutput::finish() {
  ZipRecord directory;
  for (const Member& member : members_) {
    directory.add(uint32_t(0x02014b50)).add(kZip64Version).add(kZip64Version).add(uint16_t(0)).add(uint16_t(0));
    directory.add(uint16_t(0)).add(kFirstOfJanuary1980).add(member.check_sum).add(kAllOnes).add(kAllOnes);
    directory.add(static_cast<uint16_t>(member.name.size())).add(uint16_t(28)).add(uint16_t(0)).add(uint16_t(0));
    directory.add(uint16_t(0)).add(uint32_t(0)).add(kAllOnes).add(member.name);
    directory.add(kExtraZip64).add(uint16_t(24)).add(member.size).add(member.size).add(member.place);
  }
  const uint64_t count = members_.size(), size = directory.bytes().size();
  ZipRecord end;
  end.add(uint32_t(0x06064b50)).add(uint64_t(44)).add(kZip64Version).add(kZip64Version).add(uint32_t(0));
  end.add(uint32_t(0)).add(count).add(count).add(size).add(place_);
  end.add(uint32_t(0x07064b50)).add(uint32_t(0)).add(place_ + size).add(uint32_t(1));
  end.add(uint32_t(0x06054b50)).add(uint16_t(0)).add(uint16_t(0)).add(static_cast<uint16_t>(count));
  end.add(static_cast<uint16_t>(count)).add(kAllOnes).add(kAllOnes).add(uint16_t(0));
  out_ << directory.bytes() << end.bytes();
}

template void NpzOutput::write(const std::string&, std::span<const int32_t>);
template void NpzOutput::write(const std::string&, std::span<const int64_t>);
template void NpzOutput::write(const std::string&, std::span<const double>);
template void NpzOutput::write<int32_t>(const std::string&, size_t, const std::function<void(const UseBytes&)>&);
template void NpzOutput::write<double>(const std::string&, size_t, const std::function<void(const UseBytes&)>&);

}  // namespace viewpeel
