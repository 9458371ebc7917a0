// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/network_process.h"

#include <chrono>
#include <cstdlib>
#include <thread>

#include <gmock/gmock.h>

#include "engine/base/files.h"
#include "tests/support/local_server.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using testing::HasSubstr;

class FetchingInTheWindow : public testing::Test {
 protected:
  FetchingInTheWindow() {
    setenv("XDG_DATA_HOME", folder_.path().c_str(), 1);
    for (int i = 0; i < 40000; ++i) content_ += std::to_string(i);
    static_cast<void>(WriteFileAtomically(folder_.path() / "truth", content_));
    network_ = {.name = "net",
                .about = "one",
                .url = {},
                .sha256 = Sha256OfFile(folder_.path() / "truth").value(),
                .bytes = content_.size(),
                .licence = {},
                .sidecar = "{}"};
  }
  ~FetchingInTheWindow() override { unsetenv("XDG_DATA_HOME"); }

  /// What is known of the network once `enough` says so; of nothing after ten seconds.
  template <typename Enough>
  static ListedDetector Await(const NetworkProcess& process, Enough enough) {
    for (int i = 0; i < 1000; ++i) {
      const auto view = process.View();
      if (view != nullptr && enough(view->detectors.front())) return view->detectors.front();
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    ADD_FAILURE() << "it never came";
    return {};
  }

  TemporaryFolder folder_;
  std::string content_;
  ListedNetwork network_;
};

TEST_F(FetchingInTheWindow, GivesAFileThatCanBeChosen) {
  const LocalServer server(content_);
  network_.url = server.url();
  NetworkProcess process({}, {network_});
  process.Look();
  EXPECT_EQ(Await(process, [](const auto&) { return true; }).file, "");
  process.Fetch("net");
  const ListedDetector fetched = Await(process, [](const auto& d) { return !d.file.empty(); });
  EXPECT_EQ(fetched.fetching, "");
  EXPECT_EQ(fetched.problem, "");
  EXPECT_EQ(ReadFile(fetched.file).value(), content_);
  process.Look();
  EXPECT_EQ(Await(process, [](const auto&) { return true; }).file, fetched.file);
}

TEST_F(FetchingInTheWindow, SaysWhyItFailedAndCanBeTriedAgain) {
  network_.url = "http://127.0.0.1:1/net.onnx";
  {
    NetworkProcess process({}, {network_});
    process.Fetch("net");
    const ListedDetector failed = Await(process, [](const auto& d) { return !d.problem.empty(); });
    EXPECT_THAT(failed.problem, HasSubstr("cannot reach"));
  }
  const LocalServer server(content_);
  network_.url = server.url();
  NetworkProcess process({}, {network_});
  process.StopFetching();  // nothing to stop, and no hindrance to what follows
  process.Fetch("net");
  Await(process, [](const auto& d) { return !d.file.empty(); });
}

}  // namespace
}  // namespace plumbline
