// Meshes as users have them, through the program: what it says on stderr, and rows that keep their numbers.
#include "tests/support/program.h"

namespace viewpeel {
namespace {

const std::string kFacet = "facet normal 0 0 0\nouter loop\nvertex ";

std::string facet(const std::string& a, const std::string& b, const std::string& c) {
  return kFacet + a + "\nvertex " + b + "\nvertex " + c + "\nendloop\nendfacet\n";
}

// Rows and columns of the matrix are the file's facets, with and without a checkpoint between.
TEST_F(Program, AFacetWithoutAreaHasAnEmptyRow) {
  const std::string lower = facet("0 0 0", "1 0 0", "1 1 0"), upper = facet("0 0 1", "1 1 1", "1 0 1"), gone = facet("0 0 0", "0.5 0.5 0", "1 1 0");
  std::ofstream(file("d.stl")) << "solid a\n" << lower << gone << upper << "endsolid\n";
  std::ofstream(file("whole.stl")) << "solid a\n" << lower << upper << "endsolid\n";
  const std::string lattice = " --directions 50 --resolution 16 --replicates 2 --closed-forms off --quiet ";
  const Result r = run("compute " + file("d.stl") + lattice + "-o " + file("d.mtx") + " -o " + file("d.csv") + " --checkpoint " + file("d.h5"));
  EXPECT_EQ(r.status, 0);
  EXPECT_EQ(r.output, "viewpeel: warning: " + file("d.stl") + ":9: 1 face dropped: zero area; its row stays, empty, and later numbers do not shift\n");
  EXPECT_EQ(run("compute " + file("whole.stl") + lattice + "-o " + file("whole.csv")).output, "");
  const std::string matrix = readFile(file("d.mtx"));
  for (const char* part : {"\n% 2 0 0 a[2]\n", "\n3 3 2\n", "\n1 3 0.", "\n3 1 0.", " a[3]\n"}) EXPECT_NE(matrix.find(part), std::string::npos) << part << "\n" << matrix;
  std::string whole = readFile(file("whole.csv"));
  for (size_t at; (at = whole.find("a[2]")) != std::string::npos;) whole.replace(at, 4, "a[3]");
  EXPECT_EQ(readFile(file("d.csv")), whole);
  EXPECT_EQ(run("merge " + file("d.h5") + " --quiet -o " + file("merged.mtx")).output, "");
  EXPECT_EQ(readFile(file("merged.mtx")), matrix);
  std::ofstream(file("same.stl")) << "solid a\n" << lower << lower << upper << "endsolid\n";
  const Result twice = run("compute " + file("same.stl") + lattice + "-o " + file("same.mtx"));
  EXPECT_EQ(twice.output, "viewpeel: warning: " + file("same.stl") +
                              ": 1 face is there already, facing alike: a[2] (line 9) is a[1] (line 2) again; it is left out and its row stays, empty; remove it from the file\n");
  EXPECT_EQ(readFile(file("same.mtx")), matrix);
}

TEST_F(Program, NamesThatCollideAreSaidInOneLine) {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
  std::ofstream(file("names.obj")) << corners << "o a\nf 1 2 3\nf 1 3 4\no a[1]\nf 3 2 1\n";
  const Result r = run("compute " + file("names.obj") + " --directions 10");
  EXPECT_EQ(r.status, 2);
  EXPECT_EQ(r.output, "viewpeel: " + file("names.obj") + ":9: a surface is called 'a[1]', as face 1 of surface 'a' is in the results; rename one of the two\n");
}

// Scenes that nothing is wrong with: not a word.
TEST_F(Program, CleanScenesAreQuiet) {
  for (const char* scene : {"office", "street", "cube", "plates", "past_edge"})
    EXPECT_EQ(run(std::string("compute " VIEWPEEL_SCENES "/") + scene + ".obj --directions 20 --resolution 32 --replicates 2 --quiet").output, "") << scene;
}

}  // namespace
}  // namespace viewpeel
