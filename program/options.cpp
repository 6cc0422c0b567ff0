#include "program/options.h"

#include <cstdlib>

#include "threads.h"

namespace viewpeel::program {

void addSceneOptions(CLI::App* command, SceneOptions& options) {
  command
      ->add_option("--sheets", options.sheets,
                   "Coincident faces of this surface are a thin sheet, back to back, whatever lies around")
      ->type_name("NAME")
      ->allow_extra_args(false);
  command
      ->add_option("--solids", options.solids,
                   "Coincident faces of this surface are of touching solids, face to face, whatever lies around")
      ->type_name("NAME")
      ->allow_extra_args(false);
  command->add_option("--flip", options.flip, "Turn this surface or face over")
      ->type_name("NAME")
      ->allow_extra_args(false);
  command->add_flag("--fix-normals", options.fix_normals,
                    "Turn faces over that look another way than most of their shell, and shells whose backs are seen "
                    "instead of their fronts");
  addChoice<double>(command, "--units", options.unit_m,
                    {{"m", 1}, {"mm", 1e-3}, {"cm", 1e-2}, {"in", 0.0254}, {"ft", 0.3048}},
                    "Unit of length of the scene file. Form factors have none; areas and corners in results are in "
                    "metres");
  CLI::Option* zone = command->add_option("--zone", options.zones, "Of an EnergyPlus building take this zone alone")
                          ->type_name("NAME")
                          ->allow_extra_args(false);
  command
      ->add_flag("--outside", options.outside,
                 "Look at an EnergyPlus building from outside: surfaces outdoors and shading surfaces, in place of its "
                 "zones")
      ->excludes(zone);
  command
      ->add_option("--lod", options.lod,
                   "Of each object of a city model (CityJSON) take the highest level of detail up to this one")
      ->check([](const std::string& text) { return isNumber(text, 0, 10); })
      ->type_name("LEVEL");
}

void addGroupsOption(CLI::App* command, std::string& groups) {
  command
      ->add_option("--groups", groups,
                   "Of .stl and .ply: a .csv file that names faces, a line each: 12,wall or 12-40,wall")
      ->type_name("FILE");
}

CLI::Option* addUpOption(CLI::App* command, const std::function<void(const glm::dvec3& up)>& use,
                         const std::string& text) {
  const auto read = [use](const std::vector<double>& numbers) {
    const glm::dvec3 up{numbers[0], numbers[1], numbers[2]};
    const double length = std::sqrt(up.x * up.x + up.y * up.y + up.z * up.z);
    if (!std::isfinite(length) || !(length > 0))
      throw CLI::ValidationError("--up", "the direction has no length, or too much of it; give one like 0,0,1");
    use(up / length);
  };
  return command->add_option_function<std::vector<double>>("--up", read, text)
      ->delimiter(',')
      ->expected(3)
      ->type_name("X,Y,Z");
}

void addThreadsOption(CLI::App* command) {
  const auto limit = [](const uint32_t& threads) {
    limitThreads(threads);
    // Mesa's software device lavapipe reads this variable when it is opened.
    ::setenv("LP_NUM_THREADS", std::to_string(threads).c_str(), 1);
  };
  command
      ->add_option_function<uint32_t>("-j,--threads", limit,
                                      "Threads on the processor, at most; as many as it has cores for this program")
      ->type_name("N")
      ->transform(isWholeNumberFrom(1, 4096u));
}

}  // namespace viewpeel::program
