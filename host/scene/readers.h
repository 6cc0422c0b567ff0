// Each format has a reader. Readers are written here, not taken from libraries, because coordinates are read in double,
// errors name their line, and truncated files are refused. The caller checks that the file exists.
#pragma once
#include <cmath>

#include <viewpeel/scene.h>

namespace viewpeel {

// Reads Wavefront OBJ.    Throws: Error bad_input naming file and line.
InputScene readObj(const std::filesystem::path& file);

// Reads STL, text and binary; every solid is a surface.
//   Throws: Error bad_input naming the file, and the line where it is text.
InputScene readStl(const std::filesystem::path& file);

// Reads PLY, text and binary of either byte order, as one surface with the file's name.
//   Throws: Error bad_input naming the file, and the line where it is text.
InputScene readPly(const std::filesystem::path& file);

// Reads View3D's input. It has the file's surfaces, and merged ones as one (read_vs3.h).
//   Throws: Error bad_input naming file and line.
InputScene readVs3(const std::filesystem::path& file);

// Reads the radiating faces of a CalculiX deck. Each is a surface, "ELEMENT.R<face>", in the order of CalculiX's rows
// (ccx_deck.h).
//   Throws: Error bad_input naming file and line.
InputScene readInp(const std::filesystem::path& file);

// Reads Gmsh's meshes, 2.2 and 4.1, text and binary. Physical groups of surfaces are surfaces.
//   Throws: Error bad_input naming the file, and the line where it is text.
InputScene readMsh(const std::filesystem::path& file);

// Read the polygons of VTK's XML PolyData, and the faces of its UnstructuredGrid. A cell array names surfaces.
//   Throws: Error bad_input naming the file.
InputScene readVtp(const std::filesystem::path& file);
InputScene readVtu(const std::filesystem::path& file);

// Reads the patches of an OpenFOAM case that are in the group viewFactorWall. Coarse faces are surfaces, in OpenFOAM's
// order (foam_case.h).
//   In: folder: the case, or CASE/constant/REGION    Throws: Error bad_input naming file and line.
InputScene readFoam(const std::filesystem::path& folder);

// Reads the surfaces of an EnergyPlus building's zones, IDF or epJSON, seen from within (energyplus.h). Windows are cut
// out of their walls.
//   In: zones: names, in any case of letters; empty: all zones
//   Throws: Error bad_input, naming file and line (in epJSON the object); bad_usage for an absent zone.
InputScene readEnergyPlusZones(const std::filesystem::path& file, const std::vector<std::string>& zones = {});
// Reads a building seen from outside: surfaces outdoors, and shading surfaces, which have two sides. Other surfaces
// only block.
//   Throws: as readEnergyPlusZones; bad_input for shading surfaces described by lengths, and where nothing is outdoors.
InputScene readEnergyPlusOutside(const std::filesystem::path& file);

// Reads the polygons of city models: CityJSON, or a sequence of its features, one a line. Polygons of an object that
// have one semantic type are a surface, "OBJECT/RoofSurface". Without a type the object is one.
//   In: most_detail: each object has its highest level of detail that is at most this; the levels of buildings, bridges
//     and tunnels below 1, which are footprints, are passed over
//   Throws: Error bad_input, naming the file, and the object or the line.
InputScene readCityJson(const std::filesystem::path& file, double most_detail = INFINITY);
InputScene readCityJsonSequence(const std::filesystem::path& file, double most_detail = INFINITY);

// Reads the triangles of glTF 2.0, .gltf or .glb, in the scene's coordinates. Nodes are surfaces.
//   Throws: Error bad_input naming the file.
InputScene readGltf(const std::filesystem::path& file);

}  // namespace viewpeel
