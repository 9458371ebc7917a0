// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <memory>
#include <string>

#include "engine/base/result.h"

namespace plumbline {

/// A private X server without a screen (Xvfb), for machines without a display. It ends with this
/// object, or with the program.
class VirtualDisplay {
 public:
  /// Errors: kNotFound when Xvfb is not installed, kIo when it does not start within ten seconds.
  static Result<std::unique_ptr<VirtualDisplay>> Start(int width, int height);
  ~VirtualDisplay();
  VirtualDisplay(const VirtualDisplay&) = delete;
  VirtualDisplay& operator=(const VirtualDisplay&) = delete;

  /// For the environment variable DISPLAY.
  const std::string& name() const { return name_; }

 private:
  VirtualDisplay(pid_t process, std::string name) : process_(process), name_(std::move(name)) {}
  pid_t process_;
  std::string name_;
};

}  // namespace plumbline
