#version 460
// The shader writes the polygon's number from the vertex shader; the depth test keeps the nearest polygon of each
// pixel.
layout(location = 0) flat in uint seen;
layout(location = 0) out uint pixel;

void main() { pixel = seen; }
