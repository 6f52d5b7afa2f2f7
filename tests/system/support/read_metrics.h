// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdlib>
#include <map>
#include <sstream>
#include <string>

namespace livegs {

// The metrics at http://127.0.0.1:PORT/metrics, by "name{labels}".
inline std::map<std::string, double> metrics_at(int port) {
  const int connection = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<uint16_t>(port));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  EXPECT_EQ(::connect(connection, reinterpret_cast<sockaddr*>(&to), sizeof to), 0);
  const std::string request = "GET /metrics HTTP/1.0\r\nHost: 127.0.0.1\r\n\r\n";
  EXPECT_EQ(::send(connection, request.data(), request.size(), MSG_NOSIGNAL),
            static_cast<ssize_t>(request.size()));
  std::string text;
  char piece[4096];
  for (ssize_t got = 0; (got = ::recv(connection, piece, sizeof piece, 0)) > 0;) text.append(piece, got);
  ::close(connection);
  std::map<std::string, double> values;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const size_t space = line.rfind(' ');
    if ((line.starts_with("livegs_") || line.starts_with("process_")) && space != std::string::npos)
      values[line.substr(0, space)] = std::stod(line.substr(space));
  }
  return values;
}

// The port in the line "metrics: http://127.0.0.1:PORT/metrics" of a log; 0 without one.
inline int metrics_port_in(const std::string& log) {
  const std::string url = "http://127.0.0.1:", path = "/metrics";
  const size_t end = log.find(path);
  const size_t begin = end == std::string::npos ? end : log.rfind(url, end);
  return begin == std::string::npos ? 0 : std::atoi(log.c_str() + begin + url.size());
}

}  // namespace livegs
