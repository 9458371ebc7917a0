// SPDX-License-Identifier: Apache-2.0
#include "engine/render/hypothesis_atlas.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "engine/render/gl_util.h"

namespace plumbline {
namespace {

/// As the shaders lay it out (std430).
struct GpuHypothesis {
  Eigen::Matrix4f tile_from_object;
  Eigen::Matrix4f cam_from_tile;
  float pixel = 0;  ///< Size of a tile's pixel at depth 1.
  float step_m = 0;
  float length_m = 0;  ///< Of a pixel at the depth of the mesh's centre.
  float unused = 0;
};
static_assert(sizeof(GpuHypothesis) == 144);

struct GpuScore {
  float agreement_m, visible_m, total_m, visible_samples;
  float whole[4], visible[4];
};
static_assert(sizeof(GpuScore) == 48);

struct AtlasMesh {
  gl::UploadedMesh buffers;
  Eigen::Vector3d center{0, 0, 0};
  double radius = 0;
};

/// A camera at the place of the real one that looks at the mesh's centre and holds its bounding
/// sphere with a margin of 6 pixels; at most 130 degrees wide when the camera is close. Upright in
/// the object's frame, like those of ViewpointModel.
GpuHypothesis Aim(const AtlasMesh& mesh, const AtlasHypothesis& hypothesis,
                  const AtlasOptions& options) {
  const Eigen::Isometry3d& cam_from_object = hypothesis.cam_from_object;
  const double radius = hypothesis.scale * mesh.radius;
  const Eigen::Vector3d center_in_cam = cam_from_object * (hypothesis.scale * mesh.center);
  const double distance = std::max(center_in_cam.norm(), 1e-6);
  const Eigen::Vector3d forward = center_in_cam / distance;
  Eigen::Vector3d right = forward.cross(cam_from_object.linear().col(2));
  if (right.norm() < 1e-3) right = forward.cross(cam_from_object.linear().col(0));
  right.normalize();
  Eigen::Isometry3d cam_from_tile = Eigen::Isometry3d::Identity();
  cam_from_tile.linear() << right, forward.cross(right), forward;
  const double sine = std::min(radius / distance, std::sin(65.0 * std::numbers::pi / 180.0));
  const double half_width = sine / std::sqrt(1.0 - sine * sine);
  GpuHypothesis aimed;
  aimed.cam_from_tile = cam_from_tile.matrix().cast<float>();
  aimed.tile_from_object =
      (cam_from_tile.inverse() * cam_from_object * Eigen::Scaling(hypothesis.scale))
          .matrix()
          .cast<float>();
  const double pixel = 2.0 * half_width / (options.tile_px - 12);
  aimed.pixel = static_cast<float>(pixel);
  aimed.step_m = static_cast<float>(std::min(options.contour_step_m, 0.3 * radius));
  aimed.length_m = static_cast<float>(pixel * distance);
  return aimed;
}

Box2 Clipped(const float* box, const PinholeCamera& camera) {
  if (box[2] < box[0]) return {};
  return Intersection({box[0], box[1], box[2], box[3]}, {0, 0, static_cast<float>(camera.width - 1),
                                                         static_cast<float>(camera.height - 1)});
}

class GlHypothesisAtlas final : public HypothesisAtlas {
 public:
  GlHypothesisAtlas(RenderContext& context, const AtlasOptions& options, gl::Program draw,
                    gl::Program score)
      : context_(context), options_(options), draw_(std::move(draw)), score_(std::move(score)) {
    Allocate();
  }
  ~GlHypothesisAtlas() override { context_.MakeCurrent(); }

  int AddMesh(const TriangleMesh& mesh) override;
  void Score(const AtlasView& view, std::span<const AtlasHypothesis> hypotheses,
             std::span<AtlasScore> scores) override;

 private:
  int capacity() const { return options_.tiles_per_row * options_.tiles_per_row; }
  void Allocate();
  void UploadView(const AtlasView& view);
  void ScoreBatch(const AtlasView& view, std::span<const AtlasHypothesis> hypotheses,
                  std::span<AtlasScore> scores);
  void Draw(std::span<const AtlasHypothesis> hypotheses, const AtlasView& view);
  void Reduce(const AtlasView& view, int count);

  RenderContext& context_;
  AtlasOptions options_;
  gl::Program draw_, score_;
  std::vector<AtlasMesh> meshes_;
  gl::Texture planes_, z_buffer_, hits_, occluder_;
  gl::Framebuffer framebuffer_;
  gl::Buffer hypothesis_buffer_, order_buffer_, score_buffer_;
};

void GlHypothesisAtlas::Allocate() {
  const gl::StateGuard guard;
  const int size = options_.tile_px * options_.tiles_per_row;
  planes_ = gl::MakeTexture(GL_RGBA32F, size, size, GL_RGBA, GL_FLOAT);
  z_buffer_ = gl::MakeTexture(GL_DEPTH_COMPONENT32F, size, size, GL_DEPTH_COMPONENT, GL_FLOAT);
  framebuffer_ = gl::MakeFramebuffer();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, planes_.get(), 0);
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, z_buffer_.get(), 0);
  PLB_CHECK(glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE)
      << size << " pixels square";
  hypothesis_buffer_ = gl::MakeBuffer();
  order_buffer_ = gl::MakeBuffer();
  score_buffer_ = gl::MakeBuffer();
}

int GlHypothesisAtlas::AddMesh(const TriangleMesh& mesh) {
  context_.MakeCurrent();
  const gl::StateGuard guard;
  AtlasMesh added;
  added.buffers = gl::Upload(mesh);
  added.center = BoundingBox(mesh).center().cast<double>();
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    added.radius = std::max(added.radius, (vertex.cast<double>() - added.center).norm());
  }
  meshes_.push_back(std::move(added));
  return static_cast<int>(meshes_.size()) - 1;
}

void GlHypothesisAtlas::UploadView(const AtlasView& view) {
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  // The 16 hits of a pixel are one texel of four words.
  hits_ = gl::MakeTexture(GL_RGBA32UI, view.camera.width, view.camera.height, GL_RGBA_INTEGER,
                          GL_UNSIGNED_INT, view.hits.data());
  if (view.occluder_depth.empty()) return;
  const cv::Mat depth =
      view.occluder_depth.isContinuous() ? view.occluder_depth : view.occluder_depth.clone();
  occluder_ = gl::MakeTexture(GL_R32F, depth.cols, depth.rows, GL_RED, GL_FLOAT, depth.data);
}

void GlHypothesisAtlas::Draw(std::span<const AtlasHypothesis> hypotheses, const AtlasView& view) {
  // By mesh, so that each mesh is one draw call.
  std::vector<GLuint> order(hypotheses.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](GLuint a, GLuint b) { return hypotheses[a].mesh < hypotheses[b].mesh; });
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, order_buffer_.get());
  glBufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(order.size() * sizeof(GLuint)),
               order.data(), GL_STREAM_DRAW);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, hypothesis_buffer_.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, order_buffer_.get());
  const int size = options_.tile_px * options_.tiles_per_row;
  glViewport(0, 0, size, size);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
  const std::array<GLfloat, 4> nothing{};
  const GLfloat far = 1.0f;
  glClearBufferfv(GL_COLOR, 0, nothing.data());
  glClearBufferfv(GL_DEPTH, 0, &far);
  glUseProgram(draw_.get());
  glUniform1i(gl::Uniform(draw_, "tile_px"), options_.tile_px);
  glUniform1i(gl::Uniform(draw_, "tiles_per_row"), options_.tiles_per_row);
  glUniform1f(gl::Uniform(draw_, "near_m"), static_cast<GLfloat>(0.2 * view.near_m));
  for (GLenum plane = 0; plane < 4; ++plane) glEnable(GL_CLIP_DISTANCE0 + plane);
  for (std::size_t begin = 0; begin < order.size();) {
    const int mesh = hypotheses[order[begin]].mesh;
    std::size_t end = begin;
    while (end < order.size() && hypotheses[order[end]].mesh == mesh) ++end;
    const gl::UploadedMesh& buffers = meshes_[static_cast<std::size_t>(mesh)].buffers;
    glUniform1ui(gl::Uniform(draw_, "first_instance"), static_cast<GLuint>(begin));
    glBindVertexArray(buffers.vertex_array.get());
    glDrawElementsInstanced(GL_TRIANGLES, buffers.index_count, GL_UNSIGNED_INT, nullptr,
                            static_cast<GLsizei>(end - begin));
    begin = end;
  }
  for (GLenum plane = 0; plane < 4; ++plane) glDisable(GL_CLIP_DISTANCE0 + plane);
}

void GlHypothesisAtlas::Reduce(const AtlasView& view, int count) {
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, score_buffer_.get());
  glBufferData(GL_SHADER_STORAGE_BUFFER,
               static_cast<GLsizeiptr>(count) * static_cast<GLsizeiptr>(sizeof(GpuScore)), nullptr,
               GL_STREAM_READ);
  glUseProgram(score_.get());
  const std::array<std::pair<const char*, GLuint>, 3> textures = {
      {{"planes", planes_.get()}, {"hits", hits_.get()}, {"occluder", occluder_.get()}}};
  for (GLuint unit = 0; unit < textures.size(); ++unit) {
    glActiveTexture(GL_TEXTURE0 + unit);
    glBindTexture(GL_TEXTURE_2D, textures[unit].second);
    glUniform1i(gl::Uniform(score_, textures[unit].first), static_cast<GLint>(unit));
  }
  glUniform1i(gl::Uniform(score_, "may_hide"), view.occluder_depth.empty() ? 0 : 1);
  glUniform1i(gl::Uniform(score_, "tile_px"), options_.tile_px);
  glUniform1i(gl::Uniform(score_, "tiles_per_row"), options_.tiles_per_row);
  glUniform4f(gl::Uniform(score_, "focal_and_centre"), static_cast<GLfloat>(view.camera.fx),
              static_cast<GLfloat>(view.camera.fy), static_cast<GLfloat>(view.camera.cx),
              static_cast<GLfloat>(view.camera.cy));
  glUniform1f(gl::Uniform(score_, "margin_m"), static_cast<GLfloat>(view.occlusion_margin_m));
  glUniform1f(gl::Uniform(score_, "near_m"), static_cast<GLfloat>(view.near_m));
  glUniform1f(gl::Uniform(score_, "chance"), static_cast<GLfloat>(view.chance));
  glUniform1f(gl::Uniform(score_, "inner_weight"), static_cast<GLfloat>(options_.inner_weight));
  glUniform1f(gl::Uniform(score_, "crease_cosine"),
              static_cast<GLfloat>(std::cos(options_.crease_angle_deg * std::numbers::pi / 180.0)));
  glUniform1f(gl::Uniform(score_, "mark_contrast"), static_cast<GLfloat>(options_.mark_contrast));
  glMemoryBarrier(GL_FRAMEBUFFER_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT);
  glDispatchCompute(static_cast<GLuint>(count), 1, 1);
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
}

void GlHypothesisAtlas::ScoreBatch(const AtlasView& view,
                                   std::span<const AtlasHypothesis> hypotheses,
                                   std::span<AtlasScore> scores) {
  std::vector<GpuHypothesis> aimed;
  for (const AtlasHypothesis& hypothesis : hypotheses) {
    PLB_CHECK(hypothesis.mesh >= 0 && static_cast<std::size_t>(hypothesis.mesh) < meshes_.size())
        << "no mesh " << hypothesis.mesh;
    aimed.push_back(Aim(meshes_[static_cast<std::size_t>(hypothesis.mesh)], hypothesis, options_));
  }
  glBindBuffer(GL_SHADER_STORAGE_BUFFER, hypothesis_buffer_.get());
  glBufferData(GL_SHADER_STORAGE_BUFFER,
               static_cast<GLsizeiptr>(aimed.size() * sizeof(GpuHypothesis)), aimed.data(),
               GL_STREAM_DRAW);
  Draw(hypotheses, view);
  Reduce(view, static_cast<int>(hypotheses.size()));
  std::vector<GpuScore> sums(hypotheses.size());
  glGetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0,
                     static_cast<GLsizeiptr>(sums.size() * sizeof(GpuScore)), sums.data());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    AtlasScore& score = scores[i];
    score.agreement_m = sums[i].agreement_m;
    score.visible_m = sums[i].visible_m;
    score.total_m = sums[i].total_m;
    score.visible_samples = static_cast<int>(sums[i].visible_samples);
    score.whole_box = Clipped(sums[i].whole, view.camera);
    score.visible_box = Clipped(sums[i].visible, view.camera);
  }
}

void GlHypothesisAtlas::Score(const AtlasView& view, std::span<const AtlasHypothesis> hypotheses,
                              std::span<AtlasScore> scores) {
  PLB_CHECK(scores.size() == hypotheses.size());
  PLB_CHECK(view.hits.size() == static_cast<std::size_t>(view.camera.width) *
                                    static_cast<std::size_t>(view.camera.height) * 16)
      << "16 hits for each pixel of the camera's image";
  PLB_CHECK(view.occluder_depth.empty() || view.occluder_depth.type() == CV_32F);
  if (hypotheses.empty()) return;
  context_.MakeCurrent();
  const gl::StateGuard guard;
  UploadView(view);
  const auto batch = static_cast<std::size_t>(capacity());
  for (std::size_t begin = 0; begin < hypotheses.size(); begin += batch) {
    const std::size_t count = std::min(batch, hypotheses.size() - begin);
    ScoreBatch(view, hypotheses.subspan(begin, count), scores.subspan(begin, count));
  }
  for (GLuint binding = 0; binding < 3; ++binding)
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, 0);
}

}  // namespace

Result<std::unique_ptr<HypothesisAtlas>> HypothesisAtlas::Create(RenderContext& context,
                                                                 const AtlasOptions& options) {
  PLB_CHECK(options.tile_px >= 32 && options.tile_px % 16 == 0 && options.tiles_per_row >= 1);
  gl::RegisterShaders();
  context.MakeCurrent();
  if (epoxy_gl_version() < 43) {
    return Error{ErrorCode::kUnsupported,
                 "scoring rendered hypotheses needs OpenGL 4.3 (compute shaders); this is " +
                     context.Description()};
  }
  Result<gl::Program> draw =
      gl::MakeProgram("shaders/likelihood/atlas.vert", "shaders/likelihood/atlas.frag");
  if (!draw.ok()) return draw.error();
  Result<gl::Program> score = gl::MakeComputeProgram("shaders/likelihood/atlas_score.comp");
  if (!score.ok()) return score.error();
  return std::unique_ptr<HypothesisAtlas>(
      std::make_unique<GlHypothesisAtlas>(context, options, std::move(*draw), std::move(*score)));
}

}  // namespace plumbline
