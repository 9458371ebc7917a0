// SPDX-License-Identifier: Apache-2.0
#pragma once

// Embree 3 (Debian 12, Ubuntu 22.04) and 4 (Debian 13, Ubuntu 24.04): what they say differently,
// said once. Include it in .cc files only.

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace plumbline {

#if RTC_VERSION_MAJOR >= 4

using RayContext = RTCRayQueryContext;

inline void InitRayContext(RayContext& context) { rtcInitRayQueryContext(&context); }

/// Sets `ray` to the nearest hit.
inline void TraceRay(RTCScene scene, RayContext& context, RTCRayHit& ray) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context;
  rtcIntersect1(scene, &ray, &arguments);
}

/// The same for four rays that stay close together.
inline void TraceRays4(RTCScene scene, RayContext& context, RTCRayHit4& rays) {
  alignas(16) constexpr int kAll[4] = {-1, -1, -1, -1};
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  arguments.context = &context;
  rtcIntersect4(kAll, scene, &rays, &arguments);
}

/// Sets `ray.tfar` to minus infinity if anything is hit.
inline void TraceShadowRay(RTCScene scene, RayContext& context, RTCRay& ray) {
  RTCOccludedArguments arguments;
  rtcInitOccludedArguments(&arguments);
  arguments.context = &context;
  rtcOccluded1(scene, &ray, &arguments);
}

#else

using RayContext = RTCIntersectContext;

inline void InitRayContext(RayContext& context) { rtcInitIntersectContext(&context); }

/// Sets `ray` to the nearest hit.
inline void TraceRay(RTCScene scene, RayContext& context, RTCRayHit& ray) {
  rtcIntersect1(scene, &context, &ray);
}

/// The same for four rays that stay close together.
inline void TraceRays4(RTCScene scene, RayContext& context, RTCRayHit4& rays) {
  alignas(16) constexpr int kAll[4] = {-1, -1, -1, -1};
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect4(kAll, scene, &context, &rays);
}

/// Sets `ray.tfar` to minus infinity if anything is hit.
inline void TraceShadowRay(RTCScene scene, RayContext& context, RTCRay& ray) {
  rtcOccluded1(scene, &context, &ray);
}

#endif

}  // namespace plumbline
