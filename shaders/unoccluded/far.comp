#version 460
// One invocation integrates one pair by a product Gauss rule:
//   A_i F_ij = int_i int_j (n_j . (x - y)) (n_i . (y - x)) / (pi |y - x|^4) dy dx, over points x of i and y of j with
//   unit normals n.
//   In: shapes, pairs, list: indices of pairs     Out: areas
#extension GL_GOOGLE_include_directive : require
#include "unoccluded.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint kPoints = 2u;
layout(push_constant, scalar) uniform Args { FarArgs pushed; };
FarArgs args;

// Returns the coefficients (f, f_u, f_v, f_uv) of the function f + f_u u + f_v v + f_uv u v on the square.
//   In: at: its values at the corners, in the order of ShapeData::corners
dvec4 bilinear(dvec4 at) {
  return 0.25LF * dvec4(at.x + at.y + at.z + at.w, at.y + at.z - at.x - at.w, at.z + at.w - at.x - at.y,
                        at.x + at.z - at.y - at.w);
}

// A Patch is a polygon as functions of the square's coordinates u and v (see ShapeData), about the polygon's middle.
struct Patch {
  dvec3 along_u, along_v, along_uv;  // a point is u along_u + v along_v + u v along_uv
  dvec4 depth;                       // depth over the other polygon's plane, as `bilinear` returns it
  dvec3 density;                     // ShapeData::density, density_u, density_v
};

Patch patchOf(ShapeData shape, dvec4 depths) {
  Patch made;
  made.along_u = 0.25LF * ((shape.corners[1] - shape.corners[0]) + (shape.corners[2] - shape.corners[3]));
  made.along_v = 0.25LF * ((shape.corners[3] - shape.corners[0]) + (shape.corners[2] - shape.corners[1]));
  made.along_uv = 0.25LF * ((shape.corners[0] - shape.corners[1]) + (shape.corners[2] - shape.corners[3]));
  made.depth = bilinear(depths);
  made.density = dvec3(shape.density, shape.density_u, shape.density_v);
  return made;
}

// Returns a point of the rule about the patch's middle and, in w, its weight times the area per du dv times its depth.
dvec4 pointOf(Patch on, double u, double v, double weight) {
  double density = on.density.x + on.density.y * u + on.density.z * v;
  double depth = on.depth.x + on.depth.y * u + on.depth.z * v + on.depth.w * (u * v);
  return dvec4(u * on.along_u + v * (on.along_v + u * on.along_uv), weight * density * depth);
}

void main() {
  args = pushed;
  uint entry = gl_GlobalInvocationID.x;
  if (entry >= Work(args.work).at.count) return;
  uint pair = Words(args.list).at[entry];
  Sides sides = loadSides(args.pairs, pair);
  Patch a = patchOf(sides.a, depthsOf(sides.a, sides.b, sides.normal_b)),
        b = patchOf(sides.b, depthsOf(sides.b, sides.a, sides.normal_a));
  dvec3 between = meanCorner(sides.b) - meanCorner(sides.a);

  dvec4 points_b[kPoints * kPoints];
  [[unroll]] for (uint i = 0u; i < kPoints; ++i) [[unroll]] for (uint j = 0u; j < kPoints; ++j) {
    points_b[i * kPoints + j] = pointOf(b, args.nodes[i], args.nodes[j], args.weights[i] * args.weights[j]);
    points_b[i * kPoints + j].xyz += between;
  }
  double sum = 0.0LF;
  [[dont_unroll]] for (uint i = 0u; i < kPoints; ++i) {
    // Node i is selected here, because software devices are slow at indexing args.nodes by a loop's variable.
    double node = args.nodes[0], weight = args.weights[0];
    [[unroll]] for (uint k = 1u; k < kPoints; ++k) {
      node = i == k ? args.nodes[k] : node;
      weight = i == k ? args.weights[k] : weight;
    }
    [[unroll]] for (uint j = 0u; j < kPoints; ++j) {
      dvec4 x = pointOf(a, node, args.nodes[j], weight * args.weights[j]);
      double inner = 0.0LF;
      [[unroll]] for (uint m = 0u; m < kPoints * kPoints; ++m) {
        dvec3 d = points_b[m].xyz - x.xyz;
        double square = d.x * d.x + d.y * d.y + d.z * d.z;
        inner += points_b[m].w / (square * square);
      }
      sum += x.w * inner;
    }
  }
  Doubles(args.areas).at[pair] = sum / kPi;
}
