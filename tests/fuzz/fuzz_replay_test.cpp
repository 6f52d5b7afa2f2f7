// SPDX-License-Identifier: Apache-2.0
// Replay of the fuzz targets without libFuzzer: the committed corpus, the seeds, and truncations and bit
// flips of three seeds.
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>

#include "fuzz/fuzz_target.h"

namespace livegs::fuzz {

void PrintTo(const Target& target, std::ostream* out) { *out << target.name; }  // GoogleTest's name for it

namespace {

// Per seed. A longer seed is cut and flipped at even steps.
constexpr size_t kMaxTruncations = 512;
constexpr size_t kMaxFlips = 2048;

const std::filesystem::path kCorpus = std::filesystem::path(LIVEGS_TESTS_DIR) / "fuzz" / "corpus";

char current_input[512];  // printed if the process crashes

void name_input(const Target& target, const std::string& what, const char* change, size_t at) {
  std::snprintf(current_input, sizeof current_input, "%s: %s, %s %zu\n", target.name, what.c_str(), change,
                at);
}

constexpr int kFatal[] = {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL};
struct sigaction earlier[std::size(kFatal)];

void restore_handlers() {
  for (size_t i = 0; i < std::size(kFatal); ++i) ::sigaction(kFatal[i], &earlier[i], nullptr);
}
// The fault repeats on return, under the earlier handler: a sanitizer's report, or the end of the process.
void print_input(int) {
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, current_input, std::strlen(current_input));
  restore_handlers();
}

Bytes read_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

std::vector<std::filesystem::path> corpus_of(const std::string& target) {
  std::vector<std::filesystem::path> files;
  if (!std::filesystem::is_directory(kCorpus / target)) return files;
  for (const auto& entry : std::filesystem::directory_iterator(kCorpus / target))
    files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

void replay_changed(const Target& target, const Bytes& seed, const std::string& what) {
  const size_t cut_step = 1 + seed.size() / kMaxTruncations;
  for (size_t length = 0; length < seed.size(); length += cut_step) {
    name_input(target, what, "cut to bytes", length);
    const Bytes cut(seed.begin(), seed.begin() + static_cast<std::ptrdiff_t>(
                                                     length));  // its own memory, for the address sanitizer
    target.look_at(cut);
  }
  Bytes flipped = seed;
  const size_t flip_step =
      (1 + seed.size() * 8 / kMaxFlips) | 1;  // odd: each of the eight places in a byte has its turn
  for (size_t bit = 0; bit < seed.size() * 8; bit += flip_step) {
    const std::byte mask{static_cast<uint8_t>(1u << bit % 8)};
    name_input(target, what, "flipped bit", bit);
    flipped[bit / 8] ^= mask;
    target.look_at(flipped);
    flipped[bit / 8] ^= mask;
  }
}

class FuzzReplay : public ::testing::TestWithParam<Target> {
 protected:
  void SetUp() override {
    struct sigaction print = {};
    print.sa_handler = print_input;
    for (size_t i = 0; i < std::size(kFatal); ++i) ::sigaction(kFatal[i], &print, &earlier[i]);
  }
  void TearDown() override { restore_handlers(); }
};

TEST_P(FuzzReplay, CorpusSeedsAndSmallChanges) {
  const Target& target = GetParam();
  const auto files = corpus_of(target.name);
  EXPECT_FALSE(files.empty()) << kCorpus / target.name << " holds no file";
  for (const auto& path : files) {
    name_input(target, path.filename(), "whole", 0);
    const Bytes input = read_file(path);
    EXPECT_FALSE(input.empty()) << path;
    target.look_at(input);
  }
  const std::vector<Bytes> seeds = target.seeds();
  ASSERT_GE(seeds.size(), 3u);
  for (size_t i = 0; i < seeds.size(); ++i) {
    name_input(target, "seed " + std::to_string(i), "whole", 0);
    target.look_at(seeds[i]);
  }
  for (const size_t i : {size_t{0}, seeds.size() / 2, seeds.size() - 1})
    replay_changed(target, seeds[i], "seed " + std::to_string(i));
}

INSTANTIATE_TEST_SUITE_P(Targets, FuzzReplay, ::testing::ValuesIn(targets()),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(FuzzCorpus, EveryCorpusFolderHasATarget) {
  std::set<std::string> names;
  for (const Target& target : targets()) EXPECT_TRUE(names.insert(target.name).second) << target.name;
  for (const auto& entry : std::filesystem::directory_iterator(kCorpus))
    EXPECT_TRUE(names.contains(entry.path().filename())) << entry.path();
}

}  // namespace
}  // namespace livegs::fuzz
