#include "io/npz_file.h"

#include <bit>
#include <type_traits>

#include <boost/crc.hpp>
#include <fmt/format.h>

namespace viewpeel {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are little-endian and copied as they are");

constexpr uint32_t kAllOnes = 0xFFFFFFFFu;  // marks a size or offset that the extra field holds in 64 bits
constexpr uint16_t kZip64Version = 45, kExtraZip64 = 1;
constexpr uint16_t kFirstOfJanuary1980 = 0x21;  // the first day that zip can express, for files without a time

// A Record collects the bytes of a record of a zip, little-endian.
class Record {
 public:
  template <class T>
  Record& add(T value) {
    for (size_t k = 0; k < sizeof value; ++k) bytes_ += static_cast<char>(value >> (8 * k));
    return *this;
  }
  Record& add(const std::string& text) {
    bytes_ += text;
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

// Returns the header of a .npy file: magic, version, length, and a dictionary padded to a multiple of 64 bytes.
std::string npyHead(const std::string& type, const std::string& shape) {
  std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", type, shape);
  text.append((64 - (10 + text.size() + 1) % 64) % 64, ' ');
  text += '\n';
  return std::string("\x93NUMPY\x01\x00", 8) + Record().add(static_cast<uint16_t>(text.size())).bytes() + text;
}

}  // namespace

template <class T>
void NpzOutput::write(const std::string& name, std::span<const T> values) {
  const char* type = std::is_same_v<T, int32_t> ? "<i4" : std::is_same_v<T, int64_t> ? "<i8" : "<f8";
  add(name, npyHead(type, fmt::format("({},)", values.size())),
      {reinterpret_cast<const char*>(values.data()), values.size_bytes()});
}

void NpzOutput::writeText(const std::string& name, const std::string& text) {
  add(name, npyHead(fmt::format("|S{}", text.size()), "()"), {text.data(), text.size()});
}

void NpzOutput::add(const std::string& name, const std::string& head, std::span<const char> data) {
  boost::crc_32_type sum;
  sum.process_bytes(head.data(), head.size());
  sum.process_bytes(data.data(), data.size());
  const Member member{name + ".npy", sum.checksum(), head.size() + data.size(), place_};
  Record record;
  record.add(uint32_t(0x04034b50)).add(kZip64Version).add(uint16_t(0)).add(uint16_t(0)).add(uint16_t(0));
  record.add(kFirstOfJanuary1980).add(member.check_sum).add(kAllOnes).add(kAllOnes);
  record.add(static_cast<uint16_t>(member.name.size())).add(uint16_t(20)).add(member.name);
  record.add(kExtraZip64).add(uint16_t(16)).add(member.size).add(member.size);
  out_ << record.bytes() << head;
  out_.write(data.data(), static_cast<std::streamsize>(data.size()));
  place_ += record.bytes().size() + member.size;
  members_.push_back(member);
}

void NpzOutput::finish() {
  Record directory;
  for (const Member& member : members_) {
    directory.add(uint32_t(0x02014b50)).add(kZip64Version).add(kZip64Version).add(uint16_t(0)).add(uint16_t(0));
    directory.add(uint16_t(0)).add(kFirstOfJanuary1980).add(member.check_sum).add(kAllOnes).add(kAllOnes);
    directory.add(static_cast<uint16_t>(member.name.size())).add(uint16_t(28)).add(uint16_t(0)).add(uint16_t(0));
    directory.add(uint16_t(0)).add(uint32_t(0)).add(kAllOnes).add(member.name);
    directory.add(kExtraZip64).add(uint16_t(24)).add(member.size).add(member.size).add(member.place);
  }
  const uint64_t count = members_.size(), size = directory.bytes().size();
  Record end;
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

}  // namespace viewpeel
