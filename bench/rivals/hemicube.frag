#version 460
// The shader writes the polygon that the vertex shader named; the depth test leaves the nearest one of each pixel.
layout(location = 0) flat in uint seen;
layout(location = 0) out uint pixel;

void main() { pixel = seen; }
