// SPDX-License-Identifier: Apache-2.0
#include "system/support/program.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/inotify.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <sstream>

extern char** environ;

namespace livegs {
namespace {

constexpr int kPatience_ms = 90'000;

std::string text_of(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

}  // namespace

Program::Program(std::vector<std::string> words) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  const std::string out = folder_ / "out", err = folder_ / "err";
  for (const std::string& path : {out, err}) ::close(::open(path.c_str(), O_CREAT | O_WRONLY, 0600));
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), O_WRONLY, 0600);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err.c_str(), O_WRONLY, 0600);
  if (::posix_spawn(&process_, words[0].c_str(), &actions, nullptr, arguments.data(), environ) != 0)
    process_ = -1;
  posix_spawn_file_actions_destroy(&actions);
}

Program::~Program() {
  if (process_ <= 0) return;
  ::kill(process_, SIGKILL);
  ::waitpid(process_, nullptr, 0);
}

int Program::wait() {
  if (process_ <= 0) return exit_code_;
  const int handle = static_cast<int>(::syscall(SYS_pidfd_open, process_, 0));
  pollfd ended{handle, POLLIN, 0};
  const int ready = ::poll(&ended, 1, kPatience_ms);
  ::close(handle);
  if (ready != 1) return -1;
  int status = 0;
  ::waitpid(process_, &status, 0);
  process_ = -1;
  exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return exit_code_;
}

void Program::send(int signal_number) { ::kill(process_, signal_number); }

std::string Program::out() const { return text_of(folder_ / "out"); }
std::string Program::err() const { return text_of(folder_ / "err"); }

std::string Program::first_line() {
  std::string line;
  wait_for("out", [&](const std::string& text) {
    const size_t end = text.find('\n');
    if (end != std::string::npos) line = text.substr(0, end);
    return end != std::string::npos;
  });
  return line;
}

bool Program::says_often(const std::string& text, size_t times) {
  return wait_for("err", [&](const std::string& all) {
    size_t said = 0;
    for (size_t at = all.find(text); at != std::string::npos && said < times;
         at = all.find(text, at + text.size()))
      ++said;
    return said >= times;
  });
}

bool Program::wait_for(const std::string& name, const std::function<bool(const std::string&)>& enough) {
  const int watcher = ::inotify_init1(IN_CLOEXEC);
  ::inotify_add_watch(watcher, (folder_ / name).c_str(), IN_MODIFY);
  const int handle = static_cast<int>(::syscall(SYS_pidfd_open, process_, 0));
  bool found = false;
  for (bool ended = false;;) {
    found = enough(text_of(folder_ / name));
    if (found || ended) break;
    pollfd news[2] = {{watcher, POLLIN, 0}, {handle, POLLIN, 0}};
    if (::poll(news, 2, kPatience_ms) <= 0) break;
    ended = (news[1].revents & POLLIN) != 0;  // read again: output may precede the end
    char events[4096];
    if ((news[0].revents & POLLIN) != 0 && ::read(watcher, events, sizeof events) < 0) break;
  }
  ::close(handle);
  ::close(watcher);
  return found;
}

}  // namespace livegs
