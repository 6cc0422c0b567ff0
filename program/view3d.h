// Under its second name, view3d, the program reads and writes the files of View3D.
#pragma once

namespace viewpeel::program {

// Returns whether the program was called as view3d.    In: name: argv[0]
bool isView3d(const char* name);

// Runs `view3d IN.vs3 OUT`: reads the scene, computes, and writes OUT in the layout that its control line names.
// View3D.log goes to the current folder. Returns the exit status.
//   Throws: Error for bad input and outputs that cannot be written; the log has the same message.
int runView3d(int argc, char** argv);

}  // namespace viewpeel::program
