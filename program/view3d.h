// Runs the program under its second name, view3d, in the place of View3D.
#pragma once

namespace viewpeel::program {

// Returns true where the program was called by that name.    In: name: argv[0]
bool isView3d(const char* name);

// Runs `view3d IN.vs3 OUT`: reads the scene, computes, writes OUT in the layout of its control line, and View3D.log in
// the current folder. Returns the exit status.
//   Throws: Error for bad input and outputs that cannot be written; the log says the same.
int runView3d(int argc, char** argv);

}  // namespace viewpeel::program
