#version 460
// The shader writes the nearest polygon of a pixel.
layout(location = 0) flat in uint seen;
layout(location = 0) out uint pixel;

void main() { pixel = seen; }
