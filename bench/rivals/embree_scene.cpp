#include "bench/rivals/embree_scene.h"

#include <algorithm>

#include <fmt/format.h>

#include <viewpeel/error.h>

namespace viewpeel::bench {
namespace {

constexpr uint32_t kPacket = 8;

void fill(RTCRay& to, const Ray& from, uint32_t id) {
  to = {from.origin.x,
        from.origin.y,
        from.origin.z,
        from.near,
        from.direction.x,
        from.direction.y,
        from.direction.z,
        0,
        from.far,
        ~0u,
        id,
        0};
}

void fill(RTCRay8& to, uint32_t lane, const Ray& from, uint32_t id) {
  to.org_x[lane] = from.origin.x, to.org_y[lane] = from.origin.y, to.org_z[lane] = from.origin.z;
  to.dir_x[lane] = from.direction.x, to.dir_y[lane] = from.direction.y, to.dir_z[lane] = from.direction.z;
  to.tnear[lane] = from.near, to.tfar[lane] = from.far, to.time[lane] = 0, to.mask[lane] = ~0u, to.id[lane] = id,
  to.flags[lane] = 0;
}

// Fills packets with the rays and calls trace(first, valid, packet) for each. Lanes after the last ray hold copies that
// are not traced.
template <class Packet, class Fill, class TracePacket>
void inPackets(std::span<const Ray> rays, Fill fill_lane, TracePacket trace) {
  const auto count = static_cast<uint32_t>(rays.size());
  for (uint32_t first = 0; first < count; first += kPacket) {
    alignas(32) Packet packet;
    alignas(32) int valid[kPacket];
    for (uint32_t lane = 0; lane < kPacket; ++lane) {
      valid[lane] = first + lane < count ? -1 : 0;
      fill_lane(packet, lane, rays[std::min(first + lane, count - 1)], first + lane);
    }
    trace(first, valid, packet);
  }
}

bool isBlocked(float far) { return far < 0; }  // Embree sets tfar to minus infinity

}  // namespace

EmbreeScene::EmbreeScene(const Scene& scene) {
  device_ = rtcNewDevice(nullptr);
  if (!device_) throw Error(ErrorCode::device, "Embree makes no device; check its installation");
  if (!rtcGetDeviceProperty(device_, RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED))
    throw Error(ErrorCode::device, "Embree was built without filter functions; build it with them");
  scene_ = rtcNewScene(device_);
  rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_HIGH);
  rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);

  const bool quads = std::all_of(scene.polygons.begin(), scene.polygons.end(),
                                 [](const Polygon& polygon) { return polygon.corner_count == 4; });
  std::vector<uint32_t> indices;
  for (uint32_t index = 0; index < scene.polygons.size(); ++index) {
    const Polygon& polygon = scene.polygons[index];
    normals_.push_back((polygon.front_along_plane_normal ? 1.0 : -1.0) * scene.planes[polygon.plane].normal);
    for (uint32_t k = 2; k < polygon.corner_count && !quads; ++k) {
      for (uint32_t corner : {0u, k - 1, k}) indices.push_back(polygon.first_corner + corner);
      polygon_of_primitive_.push_back(index);
    }
    if (quads) {
      for (uint32_t corner = 0; corner < 4; ++corner) indices.push_back(polygon.first_corner + corner);
      polygon_of_primitive_.push_back(index);
    }
  }
  RTCGeometry geometry = rtcNewGeometry(device_, quads ? RTC_GEOMETRY_TYPE_QUAD : RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                               3 * sizeof(float), scene.corners.size()));
  for (size_t k = 0; k < scene.corners.size(); ++k)
    for (int axis = 0; axis < 3; ++axis) vertices[3 * k + axis] = static_cast<float>(scene.corners[k][axis]);
  const size_t corner_count = quads ? 4 : 3;
  auto* index_buffer = static_cast<uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, quads ? RTC_FORMAT_UINT4 : RTC_FORMAT_UINT3,
                              corner_count * sizeof(uint32_t), indices.size() / corner_count));
  std::copy(indices.begin(), indices.end(), index_buffer);
  rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene_);
  if (const RTCError error = rtcGetDeviceError(device_); error != RTC_ERROR_NONE)
    throw Error(ErrorCode::device, fmt::format("Embree fails with error {}; try a smaller scene", int(error)));
}

EmbreeScene::~EmbreeScene() {
  if (scene_) rtcReleaseScene(scene_);
  if (device_) rtcReleaseDevice(device_);
}

void EmbreeScene::findFirst(Trace trace, RTCIntersectContext& context, std::span<const Ray> rays,
                            std::span<uint32_t> hit) const {
  const auto count = static_cast<uint32_t>(rays.size());
  const auto polygonHit = [&](uint32_t geometry, uint32_t primitive) {
    return geometry == RTC_INVALID_GEOMETRY_ID ? UINT32_MAX : polygon_of_primitive_[primitive];
  };
  if (trace == Trace::single) {
    for (uint32_t k = 0; k < count; ++k) {
      RTCRayHit ray;
      fill(ray.ray, rays[k], k);
      ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      rtcIntersect1(scene_, &context, &ray);
      hit[k] = polygonHit(ray.hit.geomID, ray.hit.primID);
    }
  } else if (trace == Trace::packets_of_8) {
    const auto fillLane = [](RTCRayHit8& packet, uint32_t lane, const Ray& ray, uint32_t id) {
      fill(packet.ray, lane, ray, id);
      packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    };
    inPackets<RTCRayHit8>(rays, fillLane, [&](uint32_t first, const int* valid, RTCRayHit8& packet) {
      rtcIntersect8(valid, scene_, &context, &packet);
      for (uint32_t lane = 0; lane < kPacket && first + lane < count; ++lane)
        hit[first + lane] = polygonHit(packet.hit.geomID[lane], packet.hit.primID[lane]);
    });
  } else {
    alignas(64) RTCRayHit stream[kRayGroup];
    for (uint32_t k = 0; k < count; ++k) {
      fill(stream[k].ray, rays[k], k);
      stream[k].hit.geomID = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect1M(scene_, &context, stream, count, sizeof(RTCRayHit));
    for (uint32_t k = 0; k < count; ++k) hit[k] = polygonHit(stream[k].hit.geomID, stream[k].hit.primID);
  }
}

void EmbreeScene::findBlocked(Trace trace, RTCIntersectContext& context, std::span<const Ray> rays,
                              std::span<bool> blocked) const {
  const auto count = static_cast<uint32_t>(rays.size());
  if (trace == Trace::single) {
    for (uint32_t k = 0; k < count; ++k) {
      RTCRay ray;
      fill(ray, rays[k], k);
      rtcOccluded1(scene_, &context, &ray);
      blocked[k] = isBlocked(ray.tfar);
    }
  } else if (trace == Trace::packets_of_8) {
    const auto fillLane = [](RTCRay8& packet, uint32_t lane, const Ray& ray, uint32_t id) {
      fill(packet, lane, ray, id);
    };
    inPackets<RTCRay8>(rays, fillLane, [&](uint32_t first, const int* valid, RTCRay8& packet) {
      rtcOccluded8(valid, scene_, &context, &packet);
      for (uint32_t lane = 0; lane < kPacket && first + lane < count; ++lane)
        blocked[first + lane] = isBlocked(packet.tfar[lane]);
    });
  } else {
    alignas(64) RTCRay stream[kRayGroup];
    for (uint32_t k = 0; k < count; ++k) fill(stream[k], rays[k], k);
    rtcOccluded1M(scene_, &context, stream, count, sizeof(RTCRay));
    for (uint32_t k = 0; k < count; ++k) blocked[k] = isBlocked(stream[k].tfar);
  }
}

std::string embreeVersion() { return RTC_VERSION_STRING; }

}  // namespace viewpeel::bench
