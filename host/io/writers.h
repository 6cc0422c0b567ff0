// There is one writer per format of results that is not text alone; write_form_factors.cpp chooses.
#pragma once
#include <ostream>

#include <viewpeel/write.h>

namespace viewpeel {

//   Throws: Error limit beyond 2^31 - 1 rows.
void writeNpz(const FormFactors& form_factors, std::ostream& out);

//   Throws: Error limit where memory is short: the file is made in memory.
void writeHdf5(const OutputContent& content, std::ostream& out);

// Writes a page of what writeHdf5 would write, and so takes the memory of both.
//   In: file: for messages    Throws: as writeHdf5 and writePage.
void writeHtml(const OutputContent& content, const std::filesystem::path& file, std::ostream& out);

// In: content: with a scene
void writeVtp(const OutputContent& content, std::ostream& out);

// Cost: 8 n^2 bytes, written row by row.
void writeVwf(const OutputContent& content, std::ostream& out);

}  // namespace viewpeel
