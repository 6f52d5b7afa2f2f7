// SPDX-License-Identifier: GPL-3.0-or-later
// livegs-gpu-report: tests the Vulkan passes against their references on this machine's device, then measures
// them, and writes device.csv, parity.csv, physics.csv, times.csv and report.md.
#include <cctype>
#include <cstdio>
#include <filesystem>

#include "bench/support/arguments.h"
#include "core/file.h"
#include "core/require_processor.h"
#include "core/text/help_format.h"
#include "gpu_report/page.h"
#include "splat/passes/key_sorter.h"

namespace livegs::gpu_report {
namespace {

// Pixels per eye: of a current headset, and of a picture that a software device draws within a second.
constexpr int kHeadsetWidth = 2064, kHeadsetHeight = 2208, kSoftwareWidth = 640, kSoftwareHeight = 480;
constexpr int kMaxSide_px = 16384;
constexpr size_t kMinKernels = 1000;  // fewer do not fill a shell of lattice cells

struct Options {
  std::string output, size, filter;
  std::vector<size_t> kernels, nodes;
  bool parity_only = false, no_parity = false, no_validation = false;
};

int stop(const std::string& line) {
  std::fprintf(stderr, "livegs-gpu-report: %s\n", line.c_str());
  return 1;
}

// Letters, digits, points and single hyphens: "llvmpipe (LLVM 15.0.6, 256 bits)" is
// llvmpipe-LLVM-15.0.6-256-bits.
std::string safe_name(const std::string& name) {
  std::string safe;
  for (const char c : name) {
    const bool kept = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.';
    if (kept) {
      safe += c;
    } else if (!safe.empty() && safe.back() != '-') {
      safe += '-';
    }
  }
  while (!safe.empty() && safe.back() == '-') safe.pop_back();
  return safe;
}

// WxH; an empty text if both sides are valid.
std::string read_size(const std::string& text, int& width, int& height) {
  char end = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &end) != 2 || width < 1 || height < 1 ||
      width > kMaxSide_px || height > kMaxSide_px)
    return "\"" + text + "\" is not WxH with sides from 1 to " + std::to_string(kMaxSide_px);
  return {};
}

Options read_options(int argc, char** argv) {
  Options options;
  CLI::App app(
      "Tests the passes of the Vulkan renderer against their references on the device of this machine, then "
      "measures them. Writes device.csv, parity.csv, physics.csv, times.csv and the page report.md. The exit "
      "code is "
      "1 if a test fails.",
      "livegs-gpu-report");
  app.formatter(std::make_shared<HelpFormatter>());
  app.add_option("--output,-o", options.output, "Folder of the files (default: gpu-report-DEVICE)")
      ->type_name("DIR");
  app.add_option(
         "--kernels", options.kernels,
         "Numbers of kernels to measure (default: 50000,200000,1000000,6000000; on a software device 50000)")
      ->delimiter(',')
      ->check(CLI::Range(kMinKernels, size_t{KeySorter::kMaxKeys}))
      ->type_name("N,...");
  app.add_option("--nodes", options.nodes,
                 "Numbers of nodes of elastic bodies to measure (default: 1000,8000,64000,1000000; on a "
                 "software device 1000,8000)")
      ->delimiter(',')
      ->check(CLI::Range(size_t{8}, size_t{4'000'000}))
      ->type_name("N,...");
  app.add_option("--size", options.size, "Pixels per eye (default: 2064x2208; on a software device 640x480)")
      ->check(CLI::Validator(
          [](const std::string& text) {
            int width = 0, height = 0;
            return read_size(text, width, height);
          },
          ""))
      ->type_name("WxH");
  auto* only = app.add_flag("--parity-only", options.parity_only, "Run the tests without measurements");
  app.add_flag("--no-parity", options.no_parity, "Run the measurements without tests")->excludes(only);
  app.add_flag("--no-validation", options.no_validation, "Test without the validation layer");
  app.add_option("--filter", options.filter, "Tests to run, as a pattern of GoogleTest (default: all)")
      ->type_name("PATTERN");
  bench::read_arguments(app, argc, argv);
  return options;
}

Result<void> write(const std::filesystem::path& folder, const char* name, const std::string& text) {
  return write_file_atomically(folder / name, text);
}

Result<void> run(const Options& options, bool& passed) {
  auto device = VulkanDevice::create();
  if (!device) return device.error();
  Report report;
  report.device = device_facts(**device);
  const std::filesystem::path folder =
      options.output.empty() ? "gpu-report-" + safe_name(report.device.name) : options.output;
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed)
    return Error{ErrorCode::InvalidArgument, "--output: " + folder.string() + " cannot be made (" +
                                                 failed.message() + "); choose another folder"};
  if (auto done = write(folder, "device.csv", device_csv(report.device)); !done) return done;
  std::fprintf(stderr, "gpu-report: %s, driver %s\n", report.device.name.c_str(),
               report.device.driver.c_str());

  if (!options.no_parity) {
    bool validation = !options.no_validation;
    if (validation) {
      VulkanDeviceOptions validated_device;
      validated_device.validation = true;
      if (const auto validated = VulkanDevice::create(validated_device); !validated) {
        std::fprintf(stderr, "gpu-report: %s; parity runs without it\n", validated.error().message.c_str());
        validation = false;
      }
    }
    report.parity = run_parity(options.filter, validation);
    passed = report.parity->passed();
    if (auto done = write(folder, "parity.csv", parity_csv(*report.parity)); !done) return done;
    if (auto done = write(folder, "report.md", page(report)); !done) return done;
  }
  if (!options.parity_only) {
    std::vector<size_t> nodes = options.nodes;
    if (nodes.empty())
      nodes = report.device.software ? std::vector<size_t>{1000, 8000}
                                     : std::vector<size_t>{1000, 8000, 64'000, 1'000'000};
    Result<void> physics_written;
    auto physics = measure_physics(*device, nodes, [&](const PhysicsRow& row) {
      report.physics.push_back(row);
      if (physics_written)
        physics_written = write(folder, "physics.csv", physics_csv(report.device.name, report.physics));
      if (physics_written) physics_written = write(folder, "report.md", page(report));
    });
    if (!physics) return physics;
    if (!physics_written) return physics_written;
    TimesOptions times{options.kernels, report.device.software ? kSoftwareWidth : kHeadsetWidth,
                       report.device.software ? kSoftwareHeight : kHeadsetHeight};
    if (times.kernels.empty())
      times.kernels = report.device.software ? std::vector<size_t>{50'000}
                                             : std::vector<size_t>{50'000, 200'000, 1'000'000, 6'000'000};
    if (!options.size.empty()) (void)read_size(options.size, times.width, times.height);
    if (auto copy = copy_bandwidth(*device)) {
      report.copy = *copy;
      std::fprintf(stderr, "gpu-report: copy: %.1f GB/s\n", 1e-9 * copy->bytes_s);
    } else {
      std::fprintf(stderr, "gpu-report: copy: %s; the report has no shares of bandwidth\n",
                   copy.error().message.c_str());
    }
    // The files are written after each row, so that an interrupted run leaves the rows measured so far.
    Result<void> written;
    auto measured = measure_times(*device, times, [&](const TimesRow& row) {
      report.times.push_back(row);
      if (written) written = write(folder, "times.csv", times_csv(report));
      if (written) written = write(folder, "report.md", page(report));
    });
    if (!measured) return measured;
    if (!written) return written;
    if (report.times.empty())
      return Error{ErrorCode::TooLarge,
                   "times: no number of kernels could be measured; choose smaller --kernels"};
  }
  std::fprintf(stderr, "gpu-report: %s written\n", (folder / "report.md").string().c_str());
  if (!passed)
    return Error{ErrorCode::Internal, report.parity->count("failed") > 0
                                          ? "parity: " + std::to_string(report.parity->count("failed")) +
                                                " tests failed; see " + (folder / "report.md").string()
                                          : "parity: no test ran; check --filter and that the device works"};
  return {};
}

}  // namespace
}  // namespace livegs::gpu_report

int main(int argc, char** argv) {
  livegs::require_processor();
  const auto options = livegs::gpu_report::read_options(argc, argv);
  bool passed = true;
  const auto done = livegs::gpu_report::run(options, passed);
  return done ? 0 : livegs::gpu_report::stop(done.error().message);
}
