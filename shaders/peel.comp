#version 460
// This is peel.glsl for runs that count no blocked pairs, or count them by the pass meet.
#extension GL_GOOGLE_include_directive : require
#include "peel.glsl"

uint meetSpans(Tile tile, uint from, uint ups, uint span_count, inout uint blocks_done, inout bool cut) { return ups; }
