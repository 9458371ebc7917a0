// SPDX-License-Identifier: Apache-2.0
#pragma once

// For the sources of engine/render only.
#include <epoxy/gl.h>

#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "engine/base/result.h"
#include "engine/geometry/mesh.h"

namespace plumbline::gl {

/// Owns one GL name. Must be destroyed while its context is current.
template <void (*kDelete)(GLuint)>
class Handle {
 public:
  Handle() = default;
  explicit Handle(GLuint name) : name_(name) {}
  Handle(Handle&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }
  ~Handle() {
    if (name_ != 0) kDelete(name_);
  }
  GLuint get() const { return name_; }

 private:
  GLuint name_ = 0;
};

inline void DeleteBuffer(GLuint name) { glDeleteBuffers(1, &name); }
inline void DeleteTexture(GLuint name) { glDeleteTextures(1, &name); }
inline void DeleteFramebuffer(GLuint name) { glDeleteFramebuffers(1, &name); }
inline void DeleteVertexArray(GLuint name) { glDeleteVertexArrays(1, &name); }
inline void DeleteProgram(GLuint name) { glDeleteProgram(name); }

using Buffer = Handle<DeleteBuffer>;
using Texture = Handle<DeleteTexture>;
using Framebuffer = Handle<DeleteFramebuffer>;
using VertexArray = Handle<DeleteVertexArray>;
using Program = Handle<DeleteProgram>;

Buffer MakeBuffer();
VertexArray MakeVertexArray();
Framebuffer MakeFramebuffer();
/// An unfiltered 2-D texture without mipmaps, edges clamped.
Texture MakeTexture(GLenum internal_format, int width, int height, GLenum format, GLenum type,
                    const void* pixels = nullptr);

/// Compiles and links two embedded shaders. Errors: kUnsupported with the driver's message.
Result<Program> MakeProgram(std::string_view vertex_resource, std::string_view fragment_resource);
Result<Program> MakeComputeProgram(std::string_view resource);
GLint Uniform(const Program& program, const char* name);

/// A mesh in buffers of its own, positions at location 0.
struct UploadedMesh {
  VertexArray vertex_array;
  Buffer vertices, indices, colors;
  GLsizei index_count = 0;
};
UploadedMesh Upload(const TriangleMesh& mesh);

/// Makes the shaders of this module known to LoadResource.
void RegisterShaders();

/// Sets the state that our passes start from (no blending, culling or scissor; depth test and all
/// masks on) and on destruction puts back what was there, so that VTK and Dear ImGui in the same
/// context never notice.
class StateGuard {
 public:
  StateGuard();
  ~StateGuard();
  StateGuard(const StateGuard&) = delete;
  StateGuard& operator=(const StateGuard&) = delete;

 private:
  static constexpr std::array<GLenum, 9> kSwitches = {
      GL_BLEND,        GL_CULL_FACE,          GL_SCISSOR_TEST,
      GL_STENCIL_TEST, GL_DEPTH_TEST,         GL_FRAMEBUFFER_SRGB,
      GL_DITHER,       GL_RASTERIZER_DISCARD, GL_COLOR_LOGIC_OP};
  std::array<GLboolean, kSwitches.size()> enabled_{};
  std::array<GLint, 4> viewport_{}, scissor_{};
  std::array<GLboolean, 4> color_mask_{};
  std::array<GLint, 2> polygon_mode_{};
  std::array<GLfloat, 2> depth_range_{};
  std::array<GLint, 4> pack_{};
  GLboolean depth_mask_ = GL_TRUE;
  GLint depth_function_ = 0, program_ = 0, vertex_array_ = 0, array_buffer_ = 0,
        draw_framebuffer_ = 0, read_framebuffer_ = 0, active_texture_ = 0, pixel_pack_buffer_ = 0,
        pixel_unpack_buffer_ = 0;
  std::array<GLint, 4> textures_{};
};

}  // namespace plumbline::gl
