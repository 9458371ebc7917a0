// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <string>
#include <thread>

namespace plumbline {

/// An HTTP server of one file, on this machine only, for as long as it lives.
class LocalServer {
 public:
  struct Habits {
    bool knows_ranges = true;
    std::size_t cut_after = 0;  ///< Bytes of each answer after which the connection ends; 0: never.
    int status = 0;             ///< Answers with this instead, if not 0.
  };
  LocalServer(std::string content, Habits habits);
  explicit LocalServer(std::string content) : LocalServer(std::move(content), Habits()) {}
  ~LocalServer();
  LocalServer(const LocalServer&) = delete;
  LocalServer& operator=(const LocalServer&) = delete;

  std::string url() const;
  std::size_t bytes_sent() const { return bytes_sent_; }

 private:
  void Serve();
  void Answer(int connection);

  std::string content_;
  Habits habits_;
  int listener_ = -1, port_ = 0;
  std::atomic<bool> stop_ = false;
  std::atomic<std::size_t> bytes_sent_ = 0;
  std::thread thread_;
};

}  // namespace plumbline
