// Each format of results has a writer here; write_form_factors.cpp chooses one by the file's name.
#pragma once
#include <ostream>

#include <viewpeel/write.h>

namespace viewpeel {

// Writes the same as the public writeCsv, with a column that marks guesses.
void writeCsv(const OutputContent& content, std::ostream& out);

// Writes a line for each row of the file, empty rows included: `row,name,area,environment,...`.
void writeRows(const OutputContent& content, std::ostream& out);

// Writes the .npz of SciPy.    Throws: Error limit beyond 2^31 - 1 rows.
void writeNpz(const FormFactors& form_factors, std::ostream& out);

// Writes a .h5. Its matrices are read from the form factors as they are written; the rest is made in memory.
//   Throws: Error limit where memory is short.
void writeHdf5(const OutputContent& content, std::ostream& out);

// Writes one JSON object: parameters, rows and form factors.
void writeJson(const OutputContent& content, std::ostream& out);
// Writes two members of an object, `"rows": [...], "form_factors": {...}` (docs/formats.md).
void writeJsonMembers(const OutputContent& content, std::ostream& out);

// Writes a page that shows the .h5 that writeHdf5 would write. It takes the memory of both.
//   In: file: for messages    Throws: as writeHdf5 and writePage.
void writeHtml(const OutputContent& content, const std::filesystem::path& file, std::ostream& out);

// Writes polygons with values for ParaView.    In: content: with a scene
void writeVtp(const OutputContent& content, std::ostream& out);

// Writes CalculiX's view factors.    Cost: 8 n^2 bytes, written row by row.
void writeVwf(const OutputContent& content, std::ostream& out);

// Writes Elmer's view factors, as text or as a stream of bytes.    Throws: Error limit beyond 2^31 - 1 rows.
void writeElmer(const FormFactors& form_factors, bool is_binary, std::ostream& out);

// Writes a block of MOOSE's input.    Cost: O(n^2).
void writeMoose(const FormFactors& form_factors, std::ostream& out);
// Refuses names that MOOSE could not tell apart.    Throws: Error bad_usage.
void checkMooseRows(const std::filesystem::path& file, const Ids& ids);

// Writes SYRTHES's form factors, for a run on one rank.
void writeSyrthes(const FormFactors& form_factors, std::ostream& out);

// Writes EnergyPlus's view factors: an object for each zone, or the surroundings of a building seen from outside.
//   In: content: with the scene of a building
//   Throws: Error bad_usage where rows are not the building's surfaces.
void writeEnergyPlus(const OutputContent& content, bool as_json, std::ostream& out);
// Writes EnergyPlus's surroundings. Each surface outdoors that sees another one gets its view factors to other
// surfaces, sky and ground, and an object that assigns them to it.
//   In: scene: an EnergyPlus building seen from outside    Error: for sky and ground as in divideEnvironment.
//   Throws: as writeEnergyPlus.
void writeSurroundings(const FormFactors& form_factors, const Scene& scene, bool as_json, std::ostream& out);
// Refuse rows that are not surfaces, a scene that is no building, and a file that is the building itself.
//   Throws: Error bad_usage.
void checkEnergyPlusRows(const std::filesystem::path& file, const Ids& ids);
void requireBuilding(const std::filesystem::path& file, const Scene* scene);

// Returns the files of an OpenFOAM case that hold view factors: six for each rank.
//   In: folder: as for readFoam    Throws: Error bad_input where the case cannot be read.
std::vector<std::filesystem::path> foamFilesOf(const std::filesystem::path& folder);
// Refuses rows that are not the case's coarse faces, in their order.    Throws: Error bad_usage.
void checkFoamRows(const std::filesystem::path& folder, const Ids& ids);
void writeFoam(const OutputContent& content, const std::filesystem::path& folder);

}  // namespace viewpeel
