// SPDX-License-Identifier: Apache-2.0
#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "engine/render/renderer.h"

namespace plumbline {
namespace {

std::string DescribeCurrent() {
  const auto text = [](GLenum name) {
    const GLubyte* value = glGetString(name);
    return value == nullptr ? std::string("?") : std::string(reinterpret_cast<const char*>(value));
  };
  return text(GL_RENDERER) + ", OpenGL " + text(GL_VERSION);
}

class HeadlessContext final : public RenderContext {
 public:
  HeadlessContext(EGLDisplay display, EGLContext context) : display_(display), context_(context) {
    MakeCurrent();
    description_ = DescribeCurrent();
  }
  // The display is never terminated: other contexts of this process live on it.
  ~HeadlessContext() override {
    if (eglGetCurrentContext() == context_)
      eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
  }
  void MakeCurrent() override {
    if (eglGetCurrentContext() == context_) return;
    PLB_CHECK(eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE)
        << "the OpenGL context is in use by another thread";
  }
  std::string Description() const override { return description_; }

 private:
  EGLDisplay display_;
  EGLContext context_;
  std::string description_;
};

/// The window's context: whoever owns it keeps it current.
class AdoptedContext final : public RenderContext {
 public:
  AdoptedContext() : description_(DescribeCurrent()) {}
  void MakeCurrent() override {}
  std::string Description() const override { return description_; }

 private:
  std::string description_;
};

bool HasClientExtension(std::string_view name) {
  const char* all = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  return all != nullptr && std::string_view(all).find(name) != std::string_view::npos;
}

/// Every display that needs no screen: graphics cards first, then Mesa's surfaceless one.
std::vector<EGLDisplay> Displays() {
  std::vector<EGLDisplay> displays;
  if (HasClientExtension("EGL_EXT_device_enumeration") &&
      HasClientExtension("EGL_EXT_platform_device")) {
    // Not through epoxy's table, which aborts where it finds no provider before a display exists.
    const auto query =
        reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    if (query != nullptr &&
        query(static_cast<EGLint>(devices.size()), devices.data(), &count) == EGL_TRUE) {
      for (EGLint i = 0; i < count; ++i) {
        displays.push_back(eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT,
                                                    devices[static_cast<std::size_t>(i)], nullptr));
      }
    }
  }
  if (HasClientExtension("EGL_MESA_platform_surfaceless")) {
    displays.push_back(
        eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr));
  }
  return displays;
}

EGLContext MakeContext(EGLDisplay display) {
  EGLint major = 0, minor = 0;
  if (display == EGL_NO_DISPLAY || eglInitialize(display, &major, &minor) == EGL_FALSE)
    return EGL_NO_CONTEXT;
  if (eglBindAPI(EGL_OPENGL_API) == EGL_FALSE) return EGL_NO_CONTEXT;
  const std::array<EGLint, 5> wanted = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                        EGL_OPENGL_BIT, EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (eglChooseConfig(display, wanted.data(), &config, 1, &count) == EGL_FALSE || count == 0)
    return EGL_NO_CONTEXT;
  static constexpr std::array<std::array<EGLint, 2>, 4> kVersions = {
      {{4, 6}, {4, 5}, {4, 3}, {3, 3}}};
  for (const auto& version : kVersions) {
    const std::array<EGLint, 7> attributes = {EGL_CONTEXT_MAJOR_VERSION,
                                              version[0],
                                              EGL_CONTEXT_MINOR_VERSION,
                                              version[1],
                                              EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                              EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                              EGL_NONE};
    const EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, attributes.data());
    if (context != EGL_NO_CONTEXT) return context;
  }
  return EGL_NO_CONTEXT;
}

}  // namespace

bool RenderContext::IsSoftware() const {
  const std::string description = Description();
  return description.find("llvmpipe") != std::string::npos ||
         description.find("softpipe") != std::string::npos ||
         description.find("swrast") != std::string::npos;
}

Result<std::unique_ptr<RenderContext>> RenderContext::CreateHeadless() {
  std::unique_ptr<HeadlessContext> software;
  for (const EGLDisplay display : Displays()) {
    const EGLContext context = MakeContext(display);
    if (context == EGL_NO_CONTEXT) continue;
    if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) == EGL_FALSE) {
      eglDestroyContext(display, context);
      continue;
    }
    auto made = std::make_unique<HeadlessContext>(display, context);
    if (!made->IsSoftware()) return std::unique_ptr<RenderContext>(std::move(made));
    if (software == nullptr) software = std::move(made);
  }
  if (software == nullptr) {
    return Error{ErrorCode::kUnsupported,
                 "no OpenGL 3.3 without a display: EGL offers none; install Mesa (libegl1, "
                 "libgl1-mesa-dri) or a graphics driver"};
  }
  software->MakeCurrent();
  return std::unique_ptr<RenderContext>(std::move(software));
}

Result<std::unique_ptr<RenderContext>> RenderContext::AdoptCurrent() {
  if (epoxy_gl_version() < 33) {
    return Error{ErrorCode::kUnsupported,
                 "OpenGL 3.3 or later is needed; this context has " + DescribeCurrent()};
  }
  return std::unique_ptr<RenderContext>(std::make_unique<AdoptedContext>());
}

}  // namespace plumbline
