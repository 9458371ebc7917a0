// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core.hpp>

#include "engine/base/result.h"
#include "engine/geometry/mesh.h"
#include "engine/sensor/camera.h"

namespace plumbline {

/// An OpenGL context that the engine draws with: its own headless one (EGL without any display), or
/// the one that is current in this thread (the window's). Everything made with it must be used and
/// destroyed in one thread.
class RenderContext {
 public:
  virtual ~RenderContext() = default;
  /// Errors: kUnsupported when no EGL platform gives a core context (3.3 or later).
  static Result<std::unique_ptr<RenderContext>> CreateHeadless();
  /// Adopts the context that is current in the calling thread.
  static Result<std::unique_ptr<RenderContext>> AdoptCurrent();
  virtual void MakeCurrent() = 0;
  /// GL_RENDERER and GL_VERSION.
  virtual std::string Description() const = 0;
  /// OpenGL on the processor (Mesa's llvmpipe and its kin).
  bool IsSoftware() const;
};

/// A mesh to draw: which of the renderer's meshes, where, the number written into the id map (1 ..
/// 65535), and how many times as large as it is.
struct RenderInstance {
  int mesh = -1;
  Eigen::Isometry3d cam_from_object = Eigen::Isometry3d::Identity();
  int id = 0;
  double scale = 1;
};

constexpr std::uint8_t kUnknownLuminance8 = 255;

/// What one camera sees. Depth is Z in `cam` [m], 0 where there is nothing; id 0 where there is
/// nothing.
struct RenderedMaps {
  cv::Mat depth;         ///< CV_32F, nearest surface
  cv::Mat id;            ///< CV_16U, of the nearest surface
  cv::Mat second_depth;  ///< CV_32F, nearest surface of another id than the first; empty if not
                         ///< asked for
  cv::Mat second_id;     ///< CV_16U
  cv::Mat luminance;  ///< CV_8U, 0 .. 254 as 0 .. 1, of the nearest surface by the colours of its
                      ///< triangle's corners; kUnknownLuminance8 without. Empty if not asked for
  cv::Mat second_luminance;
  cv::Mat contour;  ///< CV_8U 255 on the contour (silhouette and depth discontinuities); empty if
                    ///< not asked for
};

/// Where contours are found; the pictures are the same. On software OpenGL the shader takes some 15
/// ms for a 640x480 image and the processor 1 ms, so kAuto uses the shader on graphics cards only.
enum class ContourPass { kAuto, kShader, kProcessor };

struct RenderOptions {
  bool second_layer = false;
  bool contour = false;
  ContourPass contour_pass = ContourPass::kAuto;
  double contour_step_m =
      0.04;  ///< A depth jump larger than this (and than the slope explains) is a contour.
  double near_m = 0.05;
  bool luminance = false;  ///< Only on the processor.
};

/// Renderer of depth, object id and contour, by OpenGL or on the processor. Exact for off-centre
/// principal points; triangles that cross the near plane are clipped; meshes are drawn two-sided,
/// and borders of open meshes inside a surface give no contour. Contour pixels lie on the near side
/// of a depth step, inside the object.
class Renderer {
 public:
  /// The context must outlive the renderer. Errors: kUnsupported (shaders do not compile: driver's
  /// message).
  static Result<std::unique_ptr<Renderer>> Create(RenderContext& context);
  /// Without OpenGL, in the calling thread: the same maps but for pixels whose centre lies within
  /// rounding of an edge, and the same on every machine. For small images and few triangles, which
  /// it draws faster than OpenGL hands them back. ContourPass is kProcessor, whatever is asked for.
  static std::unique_ptr<Renderer> CreateOnProcessor();
  virtual ~Renderer() = default;
  /// Uploads a mesh once; the handle is valid as long as the renderer.
  virtual int AddMesh(const TriangleMesh& mesh) = 0;
  /// Draws all instances with `camera` (image size camera.width x camera.height). Instances behind
  /// the camera or outside the image cost little and draw nothing.
  virtual RenderedMaps Render(const PinholeCamera& camera,
                              std::span<const RenderInstance> instances,
                              const RenderOptions& options) = 0;
};

/// The part of the image that may show what is within `bounds` of a mesh, `scale` times as large:
/// nothing if it cannot show and so changes no map, the whole image if it crosses the near plane.
std::optional<cv::Rect> ImagePart(const PinholeCamera& camera,
                                  const Eigen::Isometry3d& cam_from_object,
                                  const Eigen::AlignedBox3f& bounds, double scale, double near_m);

/// The same maps by an independent CPU rasteriser (Embree ray casting): slow, for tests and
/// machines without GL.
RenderedMaps RayCast(const PinholeCamera& camera, std::span<const TriangleMesh* const> meshes,
                     std::span<const RenderInstance> instances, const RenderOptions& options);

/// Contour of a depth and id map by the rule of Renderer: pixels on the near side of a depth step.
cv::Mat ContourOf(const cv::Mat& depth, const cv::Mat& id, double contour_step_m);

}  // namespace plumbline
