#version 460
// This is peel.glsl, where blocked pairs are counted with scanlines. A shader of its own, since dead code takes a
// driver its time, too.
#extension GL_GOOGLE_include_directive : require
#include "peel.glsl"
#include "meetings.glsl"
#include "meet_spans.glsl"
