// SPDX-License-Identifier: Apache-2.0
#include "engine/render/renderer.h"

#include <algorithm>
#include <array>

#include "engine/render/gl_util.h"
#include "engine/render/visible.h"

namespace plumbline {
namespace {

/// Depth range [0, 1): near_m at 0, infinity at 1; Z becomes clip.w. Row v of the image is row v of
/// the texture, so nothing is flipped: a pixel centre (u, v) lies at window coordinates (u + 0.5, v
/// + 0.5).
Eigen::Matrix4f ClipFromCam(const PinholeCamera& camera, double near_m) {
  Eigen::Matrix4d clip_from_cam = Eigen::Matrix4d::Zero();
  clip_from_cam(0, 0) = 2.0 * camera.fx / camera.width;
  clip_from_cam(0, 2) = 2.0 * (camera.cx + 0.5) / camera.width - 1.0;
  clip_from_cam(1, 1) = 2.0 * camera.fy / camera.height;
  clip_from_cam(1, 2) = 2.0 * (camera.cy + 0.5) / camera.height - 1.0;
  clip_from_cam(2, 2) = 1.0;
  clip_from_cam(2, 3) = -2.0 * near_m;
  clip_from_cam(3, 2) = 1.0;
  return clip_from_cam.cast<float>();
}

/// Depth [m] and id of one layer with their depth buffer.
struct Layer {
  gl::Texture depth, id, z_buffer;
  gl::Framebuffer framebuffer;
};

struct MeshProgram {
  gl::Program program;
  GLint cam_from_object = -1, clip_from_cam = -1, id = -1, first_id = -1;
};

Result<MeshProgram> MakeMeshProgram(std::string_view fragment) {
  Result<gl::Program> program = gl::MakeProgram("shaders/likelihood/mesh.vert", fragment);
  if (!program.ok()) return program.error();
  MeshProgram mesh_program;
  mesh_program.program = std::move(*program);
  mesh_program.cam_from_object = gl::Uniform(mesh_program.program, "cam_from_object");
  mesh_program.clip_from_cam = gl::Uniform(mesh_program.program, "clip_from_cam");
  mesh_program.id = gl::Uniform(mesh_program.program, "id");
  mesh_program.first_id = gl::Uniform(mesh_program.program, "first_id");
  return mesh_program;
}

/// Those that may lie behind another, or before it: a second layer shows nothing else.
std::vector<VisibleInstance> Overlapping(std::span<const VisibleInstance> visible, cv::Rect& part) {
  std::vector<VisibleInstance> overlapping;
  part = {};
  for (const VisibleInstance& instance : visible) {
    const bool overlaps =
        std::any_of(visible.begin(), visible.end(), [&](const VisibleInstance& other) {
          return other.id != instance.id && !(other.part & instance.part).empty();
        });
    if (!overlaps) continue;
    part = part.empty() ? instance.part : (part | instance.part);
    overlapping.push_back(instance);
  }
  return overlapping;
}

class GlRenderer final : public Renderer {
 public:
  GlRenderer(RenderContext& context, MeshProgram first, MeshProgram second, gl::Program contour)
      : context_(context),
        first_(std::move(first)),
        second_(std::move(second)),
        contour_(std::move(contour)) {
    empty_vertex_array_ = gl::MakeVertexArray();
  }
  ~GlRenderer() override { context_.MakeCurrent(); }

  int AddMesh(const TriangleMesh& mesh) override;
  RenderedMaps Render(const PinholeCamera& camera, std::span<const RenderInstance> instances,
                      const RenderOptions& options) override;

 private:
  void Allocate(int width, int height);
  static Layer MakeLayer(int width, int height);
  void DrawLayer(const Layer& layer, const MeshProgram& program,
                 const Eigen::Matrix4f& clip_from_cam,
                 std::span<const VisibleInstance> visible) const;
  void DrawContour(const cv::Rect& part, double step_m) const;
  bool InShader(const RenderOptions& options) const {
    PLB_CHECK(!options.luminance) << "only the processor's renderer tells luminances";
    return options.contour_pass == ContourPass::kShader ||
           (options.contour_pass == ContourPass::kAuto && !context_.IsSoftware());
  }

  RenderContext& context_;
  MeshProgram first_, second_;
  gl::Program contour_;
  gl::VertexArray empty_vertex_array_;
  std::vector<gl::UploadedMesh> meshes_;
  std::vector<Eigen::AlignedBox3f> bounds_of_mesh_;
  int width_ = 0, height_ = 0;
  Layer first_layer_, second_layer_;
  gl::Texture contour_texture_;
  gl::Framebuffer contour_framebuffer_;
};

int GlRenderer::AddMesh(const TriangleMesh& mesh) {
  context_.MakeCurrent();
  const gl::StateGuard guard;
  meshes_.push_back(gl::Upload(mesh));
  bounds_of_mesh_.push_back(BoundingBox(mesh));
  return static_cast<int>(meshes_.size()) - 1;
}

Layer GlRenderer::MakeLayer(int width, int height) {
  Layer layer;
  layer.depth = gl::MakeTexture(GL_R32F, width, height, GL_RED, GL_FLOAT);
  layer.id = gl::MakeTexture(GL_R16UI, width, height, GL_RED_INTEGER, GL_UNSIGNED_SHORT);
  layer.z_buffer =
      gl::MakeTexture(GL_DEPTH_COMPONENT32F, width, height, GL_DEPTH_COMPONENT, GL_FLOAT);
  layer.framebuffer = gl::MakeFramebuffer();
  glBindFramebuffer(GL_FRAMEBUFFER, layer.framebuffer.get());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, layer.depth.get(), 0);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT1, GL_TEXTURE_2D, layer.id.get(), 0);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, layer.z_buffer.get(),
                         0);
  const std::array<GLenum, 2> targets = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
  glDrawBuffers(2, targets.data());
  PLB_CHECK(glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE)
      << width << "x" << height;
  return layer;
}

void GlRenderer::Allocate(int width, int height) {
  if (width == width_ && height == height_) return;
  first_layer_ = MakeLayer(width, height);
  second_layer_ = MakeLayer(width, height);
  contour_texture_ = gl::MakeTexture(GL_R8, width, height, GL_RED, GL_UNSIGNED_BYTE);
  contour_framebuffer_ = gl::MakeFramebuffer();
  glBindFramebuffer(GL_FRAMEBUFFER, contour_framebuffer_.get());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D,
                         contour_texture_.get(), 0);
  PLB_CHECK(glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE)
      << width << "x" << height;
  width_ = width;
  height_ = height;
}

void GlRenderer::DrawLayer(const Layer& layer, const MeshProgram& program,
                           const Eigen::Matrix4f& clip_from_cam,
                           std::span<const VisibleInstance> visible) const {
  glBindFramebuffer(GL_FRAMEBUFFER, layer.framebuffer.get());
  const std::array<GLfloat, 4> no_depth{};
  const std::array<GLuint, 4> no_id{};
  const GLfloat far = 1.0f;
  glClearBufferfv(GL_COLOR, 0, no_depth.data());
  glClearBufferuiv(GL_COLOR, 1, no_id.data());
  glClearBufferfv(GL_DEPTH, 0, &far);
  glUseProgram(program.program.get());
  glUniformMatrix4fv(program.clip_from_cam, 1, GL_FALSE, clip_from_cam.data());
  if (program.first_id >= 0) {
    glBindTexture(GL_TEXTURE_2D, first_layer_.id.get());
    glUniform1i(program.first_id, 0);
  }
  for (const VisibleInstance& instance : visible) {
    const gl::UploadedMesh& mesh = meshes_[instance.mesh];
    glUniformMatrix4fv(program.cam_from_object, 1, GL_FALSE, instance.cam_from_mesh.data());
    glUniform1ui(program.id, static_cast<GLuint>(instance.id));
    glBindVertexArray(mesh.vertex_array.get());
    glDrawElements(GL_TRIANGLES, mesh.index_count, GL_UNSIGNED_INT, nullptr);
  }
}

void GlRenderer::DrawContour(const cv::Rect& part, double step_m) const {
  glBindFramebuffer(GL_FRAMEBUFFER, contour_framebuffer_.get());
  glUseProgram(contour_.get());
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_SCISSOR_TEST);
  glScissor(part.x, part.y, part.width, part.height);
  glActiveTexture(GL_TEXTURE1);
  glBindTexture(GL_TEXTURE_2D, first_layer_.id.get());
  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D, first_layer_.depth.get());
  glUniform1i(gl::Uniform(contour_, "depth_m"), 0);
  glUniform1i(gl::Uniform(contour_, "pixel_id"), 1);
  glUniform1f(gl::Uniform(contour_, "step_m"), static_cast<GLfloat>(step_m));
  glUniform2i(gl::Uniform(contour_, "size"), width_, height_);
  glBindVertexArray(empty_vertex_array_.get());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDisable(GL_SCISSOR_TEST);
  glEnable(GL_DEPTH_TEST);
}

/// Reads `part` of an attachment of the bound framebuffer; the rest of the map is 0.
cv::Mat ReadBack(const cv::Size& size, const cv::Rect& part, int mat_type, GLenum attachment,
                 GLenum format, GLenum type) {
  cv::Mat map(size, mat_type, cv::Scalar(0));
  if (part.empty()) return map;
  glReadBuffer(attachment);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glPixelStorei(GL_PACK_ROW_LENGTH, size.width);
  glPixelStorei(GL_PACK_SKIP_ROWS, 0);
  glPixelStorei(GL_PACK_SKIP_PIXELS, 0);
  glReadPixels(part.x, part.y, part.width, part.height, format, type,
               map.ptr(part.y) + part.x * map.elemSize());
  return map;
}

RenderedMaps GlRenderer::Render(const PinholeCamera& camera,
                                std::span<const RenderInstance> instances,
                                const RenderOptions& options) {
  PLB_CHECK(camera.width > 0 && camera.height > 0) << "the camera has no image size";
  PLB_CHECK(options.near_m > 0) << "near_m must be positive";
  context_.MakeCurrent();
  const gl::StateGuard guard;
  Allocate(camera.width, camera.height);
  glViewport(0, 0, width_, height_);
  cv::Rect part;
  const std::vector<VisibleInstance> visible =
      FindVisible(camera, instances, bounds_of_mesh_, options.near_m, part);
  const Eigen::Matrix4f clip_from_cam = ClipFromCam(camera, options.near_m);
  const cv::Size size(width_, height_);

  RenderedMaps maps;
  DrawLayer(first_layer_, first_, clip_from_cam, visible);
  maps.depth = ReadBack(size, part, CV_32F, GL_COLOR_ATTACHMENT0, GL_RED, GL_FLOAT);
  maps.id = ReadBack(size, part, CV_16U, GL_COLOR_ATTACHMENT1, GL_RED_INTEGER, GL_UNSIGNED_SHORT);
  if (options.contour && !InShader(options)) {
    maps.contour = ContourOf(maps.depth, maps.id, options.contour_step_m);
  } else if (options.contour) {
    if (!part.empty()) DrawContour(part, options.contour_step_m);
    glBindFramebuffer(GL_FRAMEBUFFER, contour_framebuffer_.get());
    maps.contour = ReadBack(size, part, CV_8U, GL_COLOR_ATTACHMENT0, GL_RED, GL_UNSIGNED_BYTE);
  }
  if (options.second_layer) {
    DrawLayer(second_layer_, second_, clip_from_cam, Overlapping(visible, part));
    maps.second_depth = ReadBack(size, part, CV_32F, GL_COLOR_ATTACHMENT0, GL_RED, GL_FLOAT);
    maps.second_id =
        ReadBack(size, part, CV_16U, GL_COLOR_ATTACHMENT1, GL_RED_INTEGER, GL_UNSIGNED_SHORT);
  }
  return maps;
}

}  // namespace

Result<std::unique_ptr<Renderer>> Renderer::Create(RenderContext& context) {
  gl::RegisterShaders();
  context.MakeCurrent();
  Result<MeshProgram> first = MakeMeshProgram("shaders/likelihood/depth_id.frag");
  if (!first.ok()) return first.error();
  Result<MeshProgram> second = MakeMeshProgram("shaders/likelihood/second_layer.frag");
  if (!second.ok()) return second.error();
  Result<gl::Program> contour =
      gl::MakeProgram("shaders/likelihood/fullscreen.vert", "shaders/likelihood/contour.frag");
  if (!contour.ok()) return contour.error();
  return std::unique_ptr<Renderer>(std::make_unique<GlRenderer>(
      context, std::move(*first), std::move(*second), std::move(*contour)));
}

}  // namespace plumbline
