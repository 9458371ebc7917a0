// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "tests/support/test_data.h"

namespace plumbline {

/// A folder in which `plumbline annotate` runs as a script runs it.
class AnnotateCommand : public testing::Test {
 protected:
  void Write(const std::string& name, const std::string& text) const {
    std::filesystem::create_directories((folder_.path() / name).parent_path());
    ASSERT_TRUE(WriteFileAtomically(folder_.path() / name, text).ok());
  }
  /// The exit code.
  int Run(const std::string& arguments) const {
    const std::string command = "cd '" + folder_.path().string() + "' && '" +
                                ProgramFile().string() + "' annotate " + arguments +
                                " > out.txt 2>&1";
    return WEXITSTATUS(std::system(command.c_str()));
  }
  std::string Output() const { return ReadFile(folder_.path() / "out.txt").value(); }
  nlohmann::json Json(const std::string& name) const {
    return ReadJson(folder_.path() / name).value();
  }

  TemporaryFolder folder_;
};

}  // namespace plumbline
