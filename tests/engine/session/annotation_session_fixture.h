// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <numbers>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "engine/models/mesh_file.h"
#include "engine/session/annotation_session.h"
#include "tests/support/annotation_walk.h"
#include "tests/support/test_data.h"

namespace plumbline {

inline std::string DocumentToJsonText(const AnnotationProject& project) {
  return DocumentToJson(project.document()).dump();
}

/// A session on the small scan of MakeAnnotationScene, whose jobs run at once.
class AnnotationSessionTest : public testing::Test {
 protected:
  /// Tilted by 20 degrees and shifted, so that nothing is right by accident.
  static Eigen::Isometry3d ScanFromLevel() {
    return Eigen::Translation3d(0.3, -0.2, 0.7) *
           Eigen::AngleAxisd(20 * std::numbers::pi / 180, Eigen::Vector3d(1, 0.5, 0).normalized());
  }

  std::unique_ptr<AnnotationSession> Open(std::filesystem::path path = {}) {
    AnnotationChoice choice;
    choice.sequence = sequence_;
    choice.path = path.empty() ? scene_.scan : std::move(path);
    choice.annotator = "Ada";
    auto session = AnnotationSession::Open(
        choice, [this] { return seconds_ += tick_s_; }, 0);
    EXPECT_TRUE(session.ok()) << session.error().message;
    RunJobs(**session);
    return std::move(*session);
  }

  static void RunJobs(AnnotationSession& session) {
    while (auto job = session.TakeJob()) {
      const auto update =
          job->run({}, [&](AnnotationSession::Update emitted) { emitted(session); });
      update(session);
    }
  }
  static void Do(AnnotationSession& session, const AnnotationCommand& command) {
    session.Apply(command);
    RunJobs(session);
  }
  /// With the floor found, and the armchair placed and accepted.
  std::unique_ptr<AnnotationSession> WithArmchair() {
    auto session = Open();
    Do(*session, FindFloorCommand{scene_.scan_from_armchair * Eigen::Vector3d(0.5, 0.5, 0)});
    Do(*session, AcceptProposalCommand{});
    Do(*session,
       PlaceModelCommand{"armchair", scene_.scan_from_armchair * Eigen::Vector3d(0.1, 0.08, 0.4)});
    Do(*session, AcceptProposalCommand{});
    return session;
  }

  /// Takes what was seen of the armchair below a height out of the scan's file.
  void ForgetArmchair(double below_m) const {
    const TriangleMesh scan = ReadMesh(scene_.scan).value();
    TriangleMesh seen;
    for (std::size_t i = 0; i < scan.vertices.size(); ++i) {
      const Eigen::Vector3d at =
          scene_.scan_from_armchair.inverse() * scan.vertices[i].cast<double>();
      if (at.head<2>().norm() < 0.7 && at.z() > 0.01 && at.z() < below_m) continue;
      seen.vertices.push_back(scan.vertices[i]);
      seen.normals.push_back(scan.normals[i]);
    }
    ASSERT_TRUE(WritePly(scene_.scan, seen).ok());
  }

  TemporaryFolder folder_;
  AnnotationScene scene_ = MakeAnnotationScene(folder_.path(), ScanFromLevel());
  double seconds_ = 0, tick_s_ = 2;  ///< The session's clock, and by how much it goes on when read.
  std::filesystem::path sequence_;
};

}  // namespace plumbline
