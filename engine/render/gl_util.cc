// SPDX-License-Identifier: Apache-2.0
#include "engine/render/gl_util.h"

#include <initializer_list>
#include <mutex>

#include "engine/base/resources.h"

void RegisterResources_plumbline_render();  // made by cmake/Embed.cmake

namespace plumbline::gl {
namespace {

constexpr std::array<GLenum, 4> kPack = {GL_PACK_ALIGNMENT, GL_PACK_ROW_LENGTH, GL_PACK_SKIP_ROWS,
                                         GL_PACK_SKIP_PIXELS};

Result<GLuint> Compile(GLenum kind, std::string_view resource) {
  Result<std::string> text = LoadResource(resource);
  if (!text.ok()) return text.error();
  const GLuint shader = glCreateShader(kind);
  const char* source = text->c_str();
  glShaderSource(shader, 1, &source, nullptr);
  glCompileShader(shader);
  GLint compiled = GL_FALSE;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled == GL_TRUE) return shader;
  std::string log(4096, '\0');
  GLsizei length = 0;
  glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), &length, log.data());
  glDeleteShader(shader);
  log.resize(static_cast<std::size_t>(length));
  return Error{ErrorCode::kUnsupported,
               "the graphics driver refuses the shader '" + std::string(resource) + "': " + log};
}

/// Takes the shaders over.
Result<Program> Link(std::initializer_list<GLuint> shaders, std::string_view resource) {
  Program program(glCreateProgram());
  for (const GLuint shader : shaders) glAttachShader(program.get(), shader);
  glLinkProgram(program.get());
  for (const GLuint shader : shaders) glDeleteShader(shader);
  GLint linked = GL_FALSE;
  glGetProgramiv(program.get(), GL_LINK_STATUS, &linked);
  if (linked == GL_TRUE) return program;
  std::string log(4096, '\0');
  GLsizei length = 0;
  glGetProgramInfoLog(program.get(), static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  return Error{ErrorCode::kUnsupported,
               "the graphics driver cannot link '" + std::string(resource) + "': " + log};
}

void Enable(GLenum what, bool on) { on ? glEnable(what) : glDisable(what); }

}  // namespace

Buffer MakeBuffer() {
  GLuint name = 0;
  glGenBuffers(1, &name);
  return Buffer(name);
}

VertexArray MakeVertexArray() {
  GLuint name = 0;
  glGenVertexArrays(1, &name);
  return VertexArray(name);
}

Framebuffer MakeFramebuffer() {
  GLuint name = 0;
  glGenFramebuffers(1, &name);
  return Framebuffer(name);
}

Texture MakeTexture(GLenum internal_format, int width, int height, GLenum format, GLenum type,
                    const void* pixels) {
  GLuint name = 0;
  glGenTextures(1, &name);
  glBindTexture(GL_TEXTURE_2D, name);
  glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(internal_format), width, height, 0, format,
               type, pixels);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return Texture(name);
}

Result<Program> MakeProgram(std::string_view vertex_resource, std::string_view fragment_resource) {
  const Result<GLuint> vertex = Compile(GL_VERTEX_SHADER, vertex_resource);
  if (!vertex.ok()) return vertex.error();
  const Result<GLuint> fragment = Compile(GL_FRAGMENT_SHADER, fragment_resource);
  if (!fragment.ok()) {
    glDeleteShader(*vertex);
    return fragment.error();
  }
  return Link({*vertex, *fragment}, fragment_resource);
}

Result<Program> MakeComputeProgram(std::string_view resource) {
  const Result<GLuint> shader = Compile(GL_COMPUTE_SHADER, resource);
  if (!shader.ok()) return shader.error();
  return Link({*shader}, resource);
}

UploadedMesh Upload(const TriangleMesh& mesh) {
  UploadedMesh uploaded;
  uploaded.index_count = static_cast<GLsizei>(3 * mesh.triangles.size());
  uploaded.vertex_array = MakeVertexArray();
  uploaded.vertices = MakeBuffer();
  uploaded.indices = MakeBuffer();
  glBindVertexArray(uploaded.vertex_array.get());
  glBindBuffer(GL_ARRAY_BUFFER, uploaded.vertices.get());
  glBufferData(GL_ARRAY_BUFFER,
               static_cast<GLsizeiptr>(mesh.vertices.size() * sizeof(Eigen::Vector3f)),
               mesh.vertices.data(), GL_STATIC_DRAW);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, uploaded.indices.get());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER,
               static_cast<GLsizeiptr>(mesh.triangles.size() * sizeof(Eigen::Vector3i)),
               mesh.triangles.data(), GL_STATIC_DRAW);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(Eigen::Vector3f), nullptr);
  glEnableVertexAttribArray(0);
  if (!mesh.colors.empty()) {
    uploaded.colors = MakeBuffer();
    glBindBuffer(GL_ARRAY_BUFFER, uploaded.colors.get());
    glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(3 * mesh.colors.size()),
                 mesh.colors.data(), GL_STATIC_DRAW);
    glVertexAttribPointer(1, 3, GL_UNSIGNED_BYTE, GL_TRUE, 3, nullptr);
    glEnableVertexAttribArray(1);
  }
  return uploaded;
}

void RegisterShaders() {
  static std::once_flag registered;
  std::call_once(registered, RegisterResources_plumbline_render);
}

GLint Uniform(const Program& program, const char* name) {
  return glGetUniformLocation(program.get(), name);
}

StateGuard::StateGuard() {
  for (std::size_t i = 0; i < kSwitches.size(); ++i) {
    enabled_[i] = glIsEnabled(kSwitches[i]);
    Enable(kSwitches[i], kSwitches[i] == GL_DEPTH_TEST);
  }
  glGetIntegerv(GL_VIEWPORT, viewport_.data());
  glGetIntegerv(GL_SCISSOR_BOX, scissor_.data());
  glGetBooleanv(GL_COLOR_WRITEMASK, color_mask_.data());
  glGetIntegerv(GL_POLYGON_MODE, polygon_mode_.data());
  glGetFloatv(GL_DEPTH_RANGE, depth_range_.data());
  for (std::size_t i = 0; i < kPack.size(); ++i) glGetIntegerv(kPack[i], &pack_[i]);
  glGetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask_);
  glGetIntegerv(GL_DEPTH_FUNC, &depth_function_);
  glGetIntegerv(GL_CURRENT_PROGRAM, &program_);
  glGetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertex_array_);
  glGetIntegerv(GL_ARRAY_BUFFER_BINDING, &array_buffer_);
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw_framebuffer_);
  glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &read_framebuffer_);
  glGetIntegerv(GL_PIXEL_PACK_BUFFER_BINDING, &pixel_pack_buffer_);
  glGetIntegerv(GL_PIXEL_UNPACK_BUFFER_BINDING, &pixel_unpack_buffer_);
  glGetIntegerv(GL_ACTIVE_TEXTURE, &active_texture_);
  for (std::size_t i = 0; i < textures_.size(); ++i) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(i));
    glGetIntegerv(GL_TEXTURE_BINDING_2D, &textures_[i]);
  }
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
  glDepthRange(0.0, 1.0);
  glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  glActiveTexture(GL_TEXTURE0);
}

StateGuard::~StateGuard() {
  for (std::size_t i = 0; i < textures_.size(); ++i) {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(i));
    glBindTexture(GL_TEXTURE_2D, static_cast<GLuint>(textures_[i]));
  }
  glActiveTexture(static_cast<GLenum>(active_texture_));
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(draw_framebuffer_));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(read_framebuffer_));
  glBindBuffer(GL_PIXEL_PACK_BUFFER, static_cast<GLuint>(pixel_pack_buffer_));
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, static_cast<GLuint>(pixel_unpack_buffer_));
  glUseProgram(static_cast<GLuint>(program_));
  glBindVertexArray(static_cast<GLuint>(vertex_array_));
  glBindBuffer(GL_ARRAY_BUFFER, static_cast<GLuint>(array_buffer_));
  for (std::size_t i = 0; i < kPack.size(); ++i) glPixelStorei(kPack[i], pack_[i]);
  glDepthRange(depth_range_[0], depth_range_[1]);
  glPolygonMode(GL_FRONT_AND_BACK, static_cast<GLenum>(polygon_mode_[0]));
  glDepthFunc(static_cast<GLenum>(depth_function_));
  glDepthMask(depth_mask_);
  glColorMask(color_mask_[0], color_mask_[1], color_mask_[2], color_mask_[3]);
  glScissor(scissor_[0], scissor_[1], scissor_[2], scissor_[3]);
  glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
  for (std::size_t i = 0; i < kSwitches.size(); ++i) Enable(kSwitches[i], enabled_[i] == GL_TRUE);
}

}  // namespace plumbline::gl
