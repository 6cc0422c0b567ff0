// The host and the hemicube's shaders share these structs, as in shaders/shared.h.

// HemicubeDraw is one face of a hemicube: the pyramid that the eye sees through it. A side of the hemicube has only the
// part above the horizon, which up_scale and up_shift stretch over the whole face.
struct HemicubeDraw {
  uint64_t polygons;  // PolygonData[polygon_count]
  uint64_t corners;   // CornerData[]
  dvec3 eye;
  vec3 right, up, forward;   // unit vectors of the face; forward is its view axis
  float up_scale, up_shift;  // y of the face = up_scale y / depth - up_shift
};

struct HemicubeSum {
  uint64_t pixels;   // uint[image pixels]
  uint64_t weights;  // uint[cell pixels]
  uint64_t sums;     // uint[hemicubes x polygon_count]
  uint polygon_count;
  uint cell_width, cell_height, cells_per_row, image_width, hemicubes;
};
