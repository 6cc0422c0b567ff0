#version 460
// This is peel.glsl for runs that count blocked pairs with scanlines. It is a shader of its own, because drivers take
// time to compile code even where it is never run.
#extension GL_GOOGLE_include_directive : require
#include "peel.glsl"
#include "meetings.glsl"
#include "meet_spans.glsl"
