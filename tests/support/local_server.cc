// SPDX-License-Identifier: Apache-2.0
#include "tests/support/local_server.h"

#include <algorithm>
#include <array>
#include <cstdlib>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "engine/base/check.h"

namespace plumbline {

LocalServer::LocalServer(std::string content, Habits habits)
    : content_(std::move(content)), habits_(habits) {
  listener_ = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof(address);
  auto* any = reinterpret_cast<sockaddr*>(&address);
  PLB_CHECK(listener_ >= 0 && bind(listener_, any, length) == 0 && listen(listener_, 4) == 0 &&
            getsockname(listener_, any, &length) == 0);
  port_ = ntohs(address.sin_port);
  thread_ = std::thread([this] { Serve(); });
}

LocalServer::~LocalServer() {
  stop_ = true;
  thread_.join();
  close(listener_);
}

std::string LocalServer::url() const {
  return "http://127.0.0.1:" + std::to_string(port_) + "/net.onnx";
}

void LocalServer::Serve() {
  while (!stop_) {
    pollfd waiting{listener_, POLLIN, 0};
    constexpr int kPatience_ms = 20;
    if (poll(&waiting, 1, kPatience_ms) <= 0) continue;
    const int connection = accept(listener_, nullptr, nullptr);
    if (connection < 0) continue;
    Answer(connection);
    close(connection);
  }
}

void LocalServer::Answer(int connection) {
  std::string request;
  std::array<char, 2048> block{};
  while (request.find("\r\n\r\n") == std::string::npos) {
    const ssize_t got = read(connection, block.data(), block.size());
    if (got <= 0) return;
    request.append(block.data(), static_cast<std::size_t>(got));
  }
  std::size_t from = 0;
  const std::string range = "Range: bytes=";
  if (const std::size_t at = request.find(range); at != std::string::npos && habits_.knows_ranges)
    from = std::strtoul(request.c_str() + at + range.size(), nullptr, 10);
  std::string answer;
  if (habits_.status != 0) {
    answer = "HTTP/1.1 " + std::to_string(habits_.status) + " No\r\nContent-Length: 0\r\n\r\n";
  } else {
    const std::string all = std::to_string(content_.size());
    answer = from == 0
                 ? "HTTP/1.1 200 OK\r\n"
                 : "HTTP/1.1 206 Partial Content\r\nContent-Range: bytes " + std::to_string(from) +
                       "-" + std::to_string(content_.size() - 1) + "/" + all + "\r\n";
    answer += "Content-Length: " + std::to_string(content_.size() - from) +
              "\r\nConnection: close\r\n\r\n";
    const std::size_t left = content_.size() - from;
    const std::size_t sent = habits_.cut_after > 0 ? std::min(left, habits_.cut_after) : left;
    answer += content_.substr(from, sent);
    bytes_sent_ += sent;
  }
  for (std::size_t at = 0; at < answer.size();) {
    const ssize_t put = send(connection, answer.data() + at, answer.size() - at, MSG_NOSIGNAL);
    if (put <= 0) return;
    at += static_cast<std::size_t>(put);
  }
}

}  // namespace plumbline
