#include "program/examples.h"

namespace viewpeel::program {

std::vector<Example> examplesOf(const std::string& command) {
  if (command == "viewpeel")
    return {{"Form factors between the named surfaces of a scene",
             "viewpeel compute office.obj --by surface -o office.csv"},
            {"A page for a browser", "viewpeel compute office.obj -o office.html"}};
  if (command == "compute")
    return {{"Every polygon, standard errors up to 1e-2", "viewpeel compute office.obj --tolerance 1e-2 -o office.csv"},
            {"A bound instead of an estimate, with probability 0.99",
             "viewpeel compute office.obj --by surface --epsilon 1e-2"},
            {"One pair only", "viewpeel compute office.obj --pair desk lamp"},
            {"In parts on two machines, which merge adds up",
             "viewpeel compute office.obj --directions 64 --part 1/2 --checkpoint a.h5"}};
  if (command == "plan")
    return {{"What a guarantee would cost", "viewpeel plan office.obj --by surface --epsilon 1e-3"}};
  if (command == "solve")
    return {{"Heat flows and temperatures, to 0.1 K",
             "viewpeel solve office.obj --materials office_materials.csv --tolerance 0.1K"}};
  if (command == "check") return {{"The processor's counts", "viewpeel check plates.obj --engine host --lattices 16"}};
  if (command == "merge") return {{"Add up two parts of a run", "viewpeel merge a.h5 b.h5 -o office.csv"}};
  if (command == "report") return {{"Look at a result", "viewpeel report office.h5 -o office.html"}};
  if (command == "completion")
    return {{"Completion in this shell, which is bash", "source <(viewpeel completion bash)"},
            {"The man page", "viewpeel completion man > viewpeel.1"}};
  return {};
}

}  // namespace viewpeel::program
