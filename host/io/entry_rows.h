// EntryRows reads nonzero form factors row by row, as writers of files need them.
#pragma once
#include <cstdint>
#include <functional>
#include <ostream>
#include <span>
#include <vector>

#include <fmt/format.h>

#include <viewpeel/form_factors.h>

namespace viewpeel {

// A RowEntry is a nonzero form factor F_ij in row i.
struct RowEntry {
  uint32_t i, j;  // j may be kEnvironment or kLeak
  Measured form_factor;
  size_t pair;  // index in FormFactors::entries(); F_ij and F_ji have the same
};

// EntryRows holds n rows of nonzero form factors. It stores 8 bytes a pair, and reads the values from the form factors.
class EntryRows {
 public:
  // In: form_factors: n ids; must live as long as the rows    Cost: O(pairs + n).
  explicit EntryRows(const FormFactors& form_factors);

  // Returns n.
  uint32_t count() const { return form_factors_.ids().count(); }
  // Returns the number of entries of row i. It is 0 for rows that were not requested.
  size_t countOf(uint32_t i) const {
    if (!form_factors_.ids().isRequested(i)) return 0;
    return mirrored_starts_[i + 1] - mirrored_starts_[i] + starts_[i + 1] - starts_[i];
  }
  // Calls use(RowEntry) for each nonzero entry of the requested rows, row by row.
  template <class Use>
  void forEach(const Use& use) const {
    for (uint32_t i = 0; i < count(); ++i) forEachOf(i, use);
  }
  // Calls use(RowEntry) for each entry of row i in the order of columns, and for environment and leak at the end.
  template <class Use>
  void forEachOf(uint32_t i, const Use& use) const {
    if (!form_factors_.ids().isRequested(i)) return;
    const double area = form_factors_.ids().areas[i];
    const auto call = [&](uint32_t j, size_t pair) {
      const Measured& exchange = form_factors_.entries()[pair].exchange_area;
      use(RowEntry{i, j, {exchange.value / area, exchange.standard_error / area}, pair});
    };
    for (size_t k = mirrored_starts_[i]; k < mirrored_starts_[i + 1]; ++k)
      call(form_factors_.entries()[mirrored_[k]].i, mirrored_[k]);
    for (size_t pair = starts_[i]; pair < starts_[i + 1]; ++pair) call(form_factors_.entries()[pair].j, pair);
  }
  // Returns where each row of the file begins among the entries between rows: int64_t[rows + 1]. Rows without an id are
  // empty.    Throws: Error limit beyond 2^31 - 1 rows.
  std::vector<int64_t> startsOfRows() const;
  // Returns the interval of an entry's form factor, where a guarantee gives intervals.
  Interval intervalOf(const RowEntry& entry) const {
    const double area = form_factors_.ids().areas[entry.i];
    const Interval& exchange = form_factors_.intervals()[entry.pair];
    return {exchange.lower / area, exchange.upper / area};
  }

 private:
  const FormFactors& form_factors_;
  std::vector<size_t> starts_;           // [n + 1]; first pair (i, j) of row i, i <= j
  std::vector<size_t> mirrored_starts_;  // [n + 1]; first of row i in mirrored_
  std::vector<size_t> mirrored_;         // pairs (j, i) of row i, j < i
};

// Makes bytes of rows on all threads, and uses them in the order of the rows.
//   In: make(first, end, bytes): appends the bytes of rows first to end - 1; threads call it at the same time
void makeRows(const EntryRows& rows, const std::function<void(uint32_t, uint32_t, fmt::memory_buffer&)>& make,
              const std::function<void(std::span<const char>)>& use);

// Makes bytes of each nonzero entry of the requested rows on all threads, and uses them in the order of the rows.
//   In: make(entry, bytes): appends to the bytes; threads call it at the same time    Cost: O(pairs).
template <class Make>
void makeEntries(const EntryRows& rows, const Make& make, const std::function<void(std::span<const char>)>& use) {
  const auto makeOfRows = [&](uint32_t first, uint32_t end, fmt::memory_buffer& bytes) {
    for (uint32_t row = first; row < end; ++row)
      rows.forEachOf(row, [&](const RowEntry& entry) { make(entry, bytes); });
  };
  makeRows(rows, makeOfRows, use);
}

// Makes the bytes of a column as makeEntries(): a value of type T for each entry between rows.
template <class T, class ValueOf>
void makeColumn(const EntryRows& rows, const ValueOf& valueOf, const std::function<void(std::span<const char>)>& use) {
  const auto make = [&](const RowEntry& entry, fmt::memory_buffer& bytes) {
    if (entry.j >= kEnvironment) return;
    const T value = static_cast<T>(valueOf(entry));
    const char* const first = reinterpret_cast<const char*>(&value);
    bytes.append(first, first + sizeof value);
  };
  makeEntries(rows, make, use);
}

// Writes a text for each nonzero entry of the requested rows, row by row. All threads make the texts.
//   In: print(entry, text): appends to the text; threads call it at the same time
template <class Print>
void printEntries(const EntryRows& rows, std::ostream& out, const Print& print) {
  makeEntries(rows, print,
              [&](std::span<const char> text) { out.write(text.data(), static_cast<std::streamsize>(text.size())); });
}

}  // namespace viewpeel
