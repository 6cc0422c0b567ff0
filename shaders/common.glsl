#extension GL_EXT_buffer_reference2 : require
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require

#include "facing.h"
#include "shared.h"

// Shaders copy their push constants from `pushed` to `args` at the beginning of main. Where some invocations may have
// returned already, llvmpipe reads a push constant once per invocation, at every use.

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Directions { DirectionData at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Polygons { PolygonData at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Snapped { SnappedCorners at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Projected { ProjectedPolygon at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Layers { Layer at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Words { uint at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Commands { LayerCommands at; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer Outlines { Outline at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer Longs { uint64_t at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer Status { BatchStatus at; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer ListEntries { ListEntry at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer ActiveTiles { ActiveTile at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) buffer Covers { Cover at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Meetings { Meeting at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer UnfinishedTiles { UnfinishedTile at[]; };

// These functions pack and unpack the members of ProjectedPolygon that hold several values.
int64_t packDepthX(int64_t depth_x, int shift, bool front_up) {
  return depth_x << 6 | int64_t(shift << 1 | (front_up ? 1 : 0));
}
int64_t depthXOf(int64_t packed) { return packed >> 6; }
int depthShiftOf(uint packed_low) { return int(packed_low >> 1 & 31u); }
uint frontUpOf(uint packed_low) { return packed_low & 1u; }
int depthMaxOf(uint packed) { return int(packed & (1u << kTieShift) - 1u); }
uint placeAtTieOf(uint packed) { return packed >> kTieShift; }

// These functions pack and unpack Layer::polygon.
uint packLayerPolygon(uint polygon_index, uint front_up) { return (polygon_index + 1u) << 1 | (1u - front_up); }
uint layerPolygonOf(uint packed) { return packed >> 1; }  // index + 1, or 0
bool isFrontDown(uint packed) { return (packed & 1u) != 0u; }
