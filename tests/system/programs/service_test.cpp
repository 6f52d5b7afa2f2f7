// SPDX-License-Identifier: Apache-2.0
// Interfaces for operators: systemd notifications, Prometheus metrics, and JSON logs.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "system/programs/programs_fixture.h"
#include "system/support/read_metrics.h"

namespace livegs {
namespace {

constexpr int kPatience_ms = 60'000;

TEST_F(Programs, CountsForPrometheusAndLogsAsJson) {
  Program server(server_words({"--metrics", "0", "--log-format", "json"}));
  const std::string port = server.first_line();
  ASSERT_NE(port, "") << server.err();
  const std::string url = "http://127.0.0.1:";
  ASSERT_TRUE(server.says(url)) << server.err();  // the line may follow the port
  const std::string said = server.err();
  const int metrics_port = std::atoi(said.c_str() + said.find(url) + url.size());
  ASSERT_GT(metrics_port, 0) << said;
  Program client(client_words(port, {"--seconds", "0", "--no-video", "--every", "0"}));
  ASSERT_TRUE(server.says("streaming to")) << server.err();
  Program probe(client_words(port, {"--seconds", "1", "--no-video"}, "probe"));
  ASSERT_EQ(probe.wait(), 0) << probe.err();

  auto values = metrics_at(metrics_port);
  const auto clients = [&] {
    return std::count_if(values.begin(), values.end(), [](const auto& one) {
      return one.first.starts_with("livegs_client_frames_sent_total{");
    });
  };
  for (int i = 0; i < kPatience_ms / 20 && clients() > 1; ++i) {  // until the probe's metrics are removed
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    values = metrics_at(metrics_port);
  }
  const auto value = [&](const std::string& name) {
    const auto found = values.find(name);
    EXPECT_NE(found, values.end()) << name;
    return found == values.end() ? -1.0 : found->second;
  };
  EXPECT_EQ(value("livegs_serving"), 1);
  EXPECT_GT(value("process_resident_memory_bytes"), 1e7);
  EXPECT_GE(value("process_virtual_memory_bytes"), value("process_resident_memory_bytes"));
  const auto now_s = static_cast<double>(std::time(nullptr));
  EXPECT_LE(value("process_start_time_seconds"), now_s + 1);  // the kernel rounds its own start to a second
  EXPECT_GT(value("process_start_time_seconds"), now_s - 3600);
  EXPECT_GE(value("livegs_sessions_total"), 2);
  EXPECT_GT(value("livegs_ticks_total"), 10);
  EXPECT_EQ(value("livegs_tick_seconds_count"), value("livegs_ticks_total"));
  EXPECT_GT(value("livegs_tick_seconds_sum"), 0);
  EXPECT_GT(value("livegs_encode_seconds_count"), 0);
  EXPECT_GT(value("livegs_frame_bytes_sum"), 0);
  std::string label;
  for (const auto& [name, count] : values) {
    if (name.starts_with("livegs_client_frames_sent_total{") && count > 0)
      label = name.substr(name.find('{'));
  }
  ASSERT_NE(label, "");
  const std::string inside = label.substr(1, label.size() - 2);
  const double sent = value("livegs_client_frames_sent_total" + label);
  EXPECT_GT(value("livegs_client_bytes_total" + label), 0);
  EXPECT_LE(value("livegs_client_round_trip_seconds_count" + label), sent);
  EXPECT_GT(value("livegs_client_round_trip_seconds_count" + label), 0);
  EXPECT_GT(value("livegs_client_send_seconds_count" + label), 0);
  // A frame is written after its step and acknowledged after that.
  EXPECT_GE(value("livegs_client_staleness_seconds_sum" + label),
            value("livegs_client_round_trip_seconds_sum" + label));
  EXPECT_GT(value("livegs_client_staleness_seconds{" + inside + ",quantile=\"0.5\"}"), 0);
  // Frames for a suspended client are replaced by newer ones. The count never decreases.
  const std::string replaced = "livegs_client_frames_replaced_total" + label;
  double count_replaced = value(replaced);
  const double at_first = count_replaced;
  client.send(SIGSTOP);
  for (int i = 0; i < kPatience_ms / 20 && count_replaced < at_first + 1; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    const auto now = metrics_at(metrics_port);
    ASSERT_TRUE(now.contains(replaced));
    EXPECT_GE(now.at(replaced), count_replaced);
    count_replaced = now.at(replaced);
  }
  client.send(SIGCONT);
  EXPECT_GE(count_replaced, at_first + 1);
  EXPECT_GE(metrics_at(metrics_port)[replaced], count_replaced);

  server.send(SIGTERM);
  EXPECT_EQ(server.wait(), 0) << server.err();
  std::istringstream lines(server.err());
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    const auto parsed = nlohmann::json::parse(line, nullptr, false);
    ASSERT_TRUE(parsed.is_object()) << line;
    EXPECT_TRUE(parsed.contains("time") && parsed.contains("level") && parsed.contains("message")) << line;
  }
  EXPECT_GT(count, 3);
}

TEST_F(Programs, ReportsMetricsPortInUse) {
  const int taken = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(::bind(taken, reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
  ASSERT_EQ(::listen(taken, 1), 0);
  socklen_t size = sizeof at;
  ::getsockname(taken, reinterpret_cast<sockaddr*>(&at), &size);
  Program server(server_words({"--metrics", std::to_string(ntohs(at.sin_port))}));
  EXPECT_EQ(server.wait(), 1);
  EXPECT_NE(server.err().find("give another with --metrics PORT"), std::string::npos) << server.err();
  ::close(taken);
}

TEST_F(Programs, ServesMetricsOnAnyAddressOfTheMachine) {
  Program server(server_words({"--metrics", "0.0.0.0:0"}));
  ASSERT_NE(server.first_line(), "") << server.err();
  const std::string url = "http://0.0.0.0:";
  ASSERT_TRUE(server.says(url)) << server.err();
  const std::string said = server.err();
  const auto values = metrics_at(std::atoi(said.c_str() + said.find(url) + url.size()));
  EXPECT_EQ(values.count("livegs_serving"), 1u);
  for (const char* bad : {"65536", "0.0.0.0:", "0.0.0.0:port", ""}) {
    Program refused(server_words({"--metrics", bad}));
    EXPECT_EQ(refused.wait(), 2) << bad;
    EXPECT_NE(refused.err().find("--metrics: "), std::string::npos) << refused.err();
    EXPECT_NE(refused.err().find("give PORT or HOST:PORT"), std::string::npos) << refused.err();
  }
}

// The next datagram; empty if none arrives.
std::string next_notice(int socket) {
  pollfd news{socket, POLLIN, 0};
  char text[512];
  if (::poll(&news, 1, kPatience_ms) != 1) return "";
  const ssize_t size = ::recv(socket, text, sizeof text, 0);
  return {text, static_cast<size_t>(std::max<ssize_t>(size, 0))};
}

TEST_F(Programs, NotifiesSystemdOfReadyWatchdogAndStopping) {
  const int manager = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_un at{};
  at.sun_family = AF_UNIX;
  const std::string path = folder_ / "notify";
  ASSERT_LT(path.size(), sizeof at.sun_path);
  path.copy(at.sun_path, path.size());
  ASSERT_EQ(::bind(manager, reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
  ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
  ::setenv("WATCHDOG_USEC", "200000", 1);
  Program server(server_words());
  ::unsetenv("NOTIFY_SOCKET");
  ::unsetenv("WATCHDOG_USEC");
  EXPECT_EQ(next_notice(manager), "READY=1\nSTATUS=Serving boxes.scene.json");
  for (int i = 0; i < 3; ++i) EXPECT_EQ(next_notice(manager), "WATCHDOG=1");
  server.send(SIGTERM);
  std::string last = next_notice(manager);
  while (last == "WATCHDOG=1") last = next_notice(manager);
  EXPECT_EQ(last, "STOPPING=1");
  EXPECT_EQ(server.wait(), 0) << server.err();
  ::close(manager);
}

}  // namespace
}  // namespace livegs
