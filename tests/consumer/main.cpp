#include <cstdio>

#include <viewpeel/compute.h>
#include <viewpeel/write.h>

int main(int, char** arguments) {
  const viewpeel::Scene scene = viewpeel::loadScene(arguments[1]);
  const viewpeel::Result result = viewpeel::computeFormFactors(scene);
  viewpeel::writeFormFactors(result.form_factors, arguments[2]);
  std::printf("%s", viewpeel::optionsOf(result.plan).c_str());
}
