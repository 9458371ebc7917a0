// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "engine/dataset/sequence.h"
#include "tests/support/test_data.h"

namespace plumbline {

/// Samples of public data sets, which data_set_samples.py writes. What it says of images, depth and
/// poses is repeated here.
class DataSetSample : public testing::Test {
 protected:
  /// Runs the script; skips the test where there is no Python.
  /// @param interpreter  As python3.
  void Write(const std::string& layout, const std::string& more = "",
             const std::string& interpreter = "python3");

  /// The sequence at a path below the sample's folder, which must open.
  std::shared_ptr<const Sequence> Open(const std::string& path);

  /// Why the path does not open.
  std::string WhyNot(const std::string& path);

  std::filesystem::path folder() const { return folder_.path(); }

 private:
  TemporaryFolder folder_;
};

/// The camera of frame i.
Eigen::Isometry3d SamplePose(double i);

/// That the frame's image and depth are those of frame i of the sample, at pixels spread over it.
void ExpectSampleImage(const Sequence& sequence, int frame, int i);
void ExpectSampleDepth(const Sequence& sequence, int frame, int i);

}  // namespace plumbline
