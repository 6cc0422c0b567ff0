// There is one writer per format of results that is not text alone; write_form_factors.cpp chooses.
#pragma once
#include <ostream>

#include <viewpeel/write.h>

namespace viewpeel {

// The same as the public writeCsv, with a column that marks guesses.
void writeCsv(const OutputContent& content, std::ostream& out);

// A line for each row of the file, empty rows too: `row,name,area,environment,...`.
void writeRows(const OutputContent& content, std::ostream& out);

//   Throws: Error limit beyond 2^31 - 1 rows.
void writeNpz(const FormFactors& form_factors, std::ostream& out);

//   Throws: Error limit where memory is short: the file is made in memory.
void writeHdf5(const OutputContent& content, std::ostream& out);

// Writes one JSON object: parameters, rows and form factors.
void writeJson(const OutputContent& content, std::ostream& out);
// Writes `"rows": [...], "form_factors": {...}`, the members of an object (docs/formats.md).
void writeJsonMembers(const OutputContent& content, std::ostream& out);

// Writes a page of what writeHdf5 would write, and so takes the memory of both.
//   In: file: for messages    Throws: as writeHdf5 and writePage.
void writeHtml(const OutputContent& content, const std::filesystem::path& file, std::ostream& out);

// In: content: with a scene
void writeVtp(const OutputContent& content, std::ostream& out);

// Cost: 8 n^2 bytes, written row by row.
void writeVwf(const OutputContent& content, std::ostream& out);

// Elmer's view factors, text or a stream of bytes.    Throws: Error limit beyond 2^31 - 1 rows.
void writeElmer(const FormFactors& form_factors, bool is_binary, std::ostream& out);

// A block of MOOSE's input.    Cost: O(n^2).
void writeMoose(const FormFactors& form_factors, std::ostream& out);
// Refuses names that MOOSE could not tell apart.    Throws: Error bad_usage.
void checkMooseRows(const std::filesystem::path& file, const Ids& ids);

// SYRTHES's form factors, for a run on one rank.
void writeSyrthes(const FormFactors& form_factors, std::ostream& out);

// EnergyPlus's view factors: an object for each zone; of a building seen from outside its surroundings.
//   In: content: with the scene of a building
//   Throws: Error bad_usage where rows are not the building's surfaces.
void writeEnergyPlus(const OutputContent& content, bool as_json, std::ostream& out);
// EnergyPlus's surroundings: for each surface outdoors that sees another one its view factors to these, to the sky and
// to the ground, and the object that gives them to the surface.
//   In: scene: an EnergyPlus building seen from outside    Error: of sky and ground that of divideEnvironment.
//   Throws: as writeEnergyPlus.
void writeSurroundings(const FormFactors& form_factors, const Scene& scene, bool as_json, std::ostream& out);
// Refuses rows that are not surfaces; another scene than a building, or a file that is the building itself.
//   Throws: Error bad_usage.
void checkEnergyPlusRows(const std::filesystem::path& file, const Ids& ids);
void requireBuilding(const std::filesystem::path& file, const Scene* scene);

// An OpenFOAM case has view factors in six files of each rank.
//   In: folder: as for readFoam    Throws: Error bad_input where the case cannot be read.
std::vector<std::filesystem::path> foamFilesOf(const std::filesystem::path& folder);
// Refuses rows that are not the case's coarse faces, in their order.    Throws: Error bad_usage.
void checkFoamRows(const std::filesystem::path& folder, const Ids& ids);
void writeFoam(const OutputContent& content, const std::filesystem::path& folder);

}  // namespace viewpeel
