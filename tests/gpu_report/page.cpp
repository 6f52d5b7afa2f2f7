// SPDX-License-Identifier: GPL-3.0-or-later
#include "gpu_report/page.h"

#include <algorithm>

#include "core/text/format_text.h"

namespace livegs::gpu_report {
namespace {

// Goals for one million kernels and both eyes of a headset. A picture at 90 Hz has 11.1 ms.
constexpr size_t kGoalKernels = 1'000'000;
constexpr int kGoalWidth = 2064, kGoalHeight = 2208;  // pixels per eye
constexpr double kGoalPasses_ms = 2;                  // skin, project and sort
constexpr double kGoalDraw_ms = 3;
constexpr double kGoalShare = 0.6;         // of the bandwidth of a copy, in skin and in sort
constexpr double kGoalBytesAKernel = 256;  // of device memory, with three bands and two eyes

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

// Bytes of the pass by its time and the bandwidth; 0 if one of them is unknown.
double share(double bytes, double ms, const Report& report) {
  return report.copy && ms > 0 ? bytes / (1e-3 * ms) / report.copy->bytes_s : 0;
}

double a_kernel(double bytes, const TimesRow& row) { return bytes / static_cast<double>(row.kernels); }

struct PassRow {
  const char* name;
  double DeviceTimes::*ms;
  double PassBytes::*bytes;
};
constexpr PassRow kPasses[] = {{"skin", &DeviceTimes::skin_ms, &PassBytes::skin},
                               {"project", &DeviceTimes::project_ms, &PassBytes::project},
                               {"sort", &DeviceTimes::sort_ms, &PassBytes::sort},
                               {"draw", &DeviceTimes::draw_ms, &PassBytes::draw},
                               {"resolve", &DeviceTimes::resolve_ms, &PassBytes::resolve}};

// The bytes of draw and resolve are those of quads; tiles move as many as there are pairs.
bool has_share(const TimesRow& row, const PassRow& pass) {
  const bool drawn = pass.ms == &DeviceTimes::draw_ms || pass.ms == &DeviceTimes::resolve_ms;
  return row.method == DrawMethod::Quads || !drawn;
}

std::string parity_text(const std::optional<Parity>& parity) {
  if (!parity) return "Not run.\n";
  double ms = 0;
  for (const ParityRow& row : parity->rows) ms += row.ms;
  std::string text =
      format_text("**%s.** %d tests passed, %d failed, %d skipped in %.0f s, %s the validation layer.\n",
                  parity->passed() ? "Passed" : "Failed", parity->count("passed"), parity->count("failed"),
                  parity->count("skipped"), 1e-3 * ms, parity->validated ? "with" : "without");
  for (const ParityRow& row : parity->rows) {
    if (row.verdict == "failed") text += "- `" + row.suite + "." + row.test + "`: " + row.message + "\n";
  }
  return text;
}

std::string times_text(const Report& report) {
  std::string text =
      "Medians by the device's clock, ms. In parentheses: the share of the copy bandwidth, from the bytes "
      "that the "
      "pass has to read and write. Draw counts each pixel once, so overlapping splats lower its share. With "
      "tiles, draw is binning and resolve is blending. A "
      "share above 100 % means that the data fit into the caches. "
      "Frame: a whole "
      "picture by the host's clock, with the read-back of its pixels.\n\n";
  text +=
      "| kernels | eyes | size of an eye | drawn by | skin | project | sort | draw | resolve | frame |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n";
  for (const TimesRow& row : report.times) {
    text += format_text("| %zu | %d | %d x %d | %s |", row.kernels, row.eyes, row.width, row.height,
                        name_of(row.method));
    for (const PassRow& pass : kPasses) {
      const double ms = row.device.*pass.ms;
      if (has_share(row, pass))
        text += format_text(" %.3f (%.0f %%) |", ms, 100 * share(row.bytes.*pass.bytes, ms, report));
      else
        text += format_text(" %.3f |", ms);
    }
    text += format_text(" %.2f |\n", row.frame.median_ms);
  }
  return text;
}

// A goal with its figure. `figure` is empty if the run did not measure it.
struct Goal {
  std::string text, figure;
  bool met = false;
};

std::string goals_text(const Report& report) {
  const auto drawn_ms = [](const TimesRow& one) { return one.device.draw_ms + one.device.resolve_ms; };
  const TimesRow* row = nullptr;  // by the faster method
  for (const TimesRow& one : report.times) {
    if (one.kernels == kGoalKernels && one.eyes == 2 && (!row || drawn_ms(one) < drawn_ms(*row))) row = &one;
  }
  const bool clocked = row && row->device.total_ms() > 0;
  std::vector<Goal> goals{
      {format_text("skin, project and sort of %zu kernels for both eyes: at most %g ms", kGoalKernels,
                   kGoalPasses_ms),
       {}},
      {format_text("draw and resolve of the same at 2 x %d x %d: at most %g ms", kGoalWidth, kGoalHeight,
                   kGoalDraw_ms),
       {}},
      {format_text("skin: at least %.0f %% of the copy bandwidth", 100 * kGoalShare), {}},
      {format_text("sort: at least %.0f %% of the copy bandwidth", 100 * kGoalShare), {}},
      {format_text("device memory of a kernel, without pairs of tiles: at most %.0f bytes",
                   kGoalBytesAKernel),
       {}}};
  if (clocked) {
    const double passes_ms = row->device.skin_ms + row->device.project_ms + row->device.sort_ms;
    goals[0].figure = format_text("%.3f ms", passes_ms);
    goals[0].met = passes_ms <= kGoalPasses_ms;
  }
  if (clocked && row->width == kGoalWidth && row->height == kGoalHeight) {
    goals[1].figure = format_text("%.3f ms, by %s", drawn_ms(*row), name_of(row->method));
    goals[1].met = drawn_ms(*row) <= kGoalDraw_ms;
  }
  for (const int g : {2, 3}) {
    if (!clocked || !report.copy) continue;
    const double part = g == 2 ? share(row->bytes.skin, row->device.skin_ms, report)
                               : share(row->bytes.sort, row->device.sort_ms, report);
    goals[g].figure = format_text("%.0f %%", 100 * part);
    goals[g].met = part >= kGoalShare;
  }
  if (row) {
    goals[4].figure = format_text("%.1f bytes", row->memory_bytes_a_kernel);
    goals[4].met = row->memory_bytes_a_kernel <= kGoalBytesAKernel;
  }
  std::string text = "| goal | figure | verdict |\n|---|---|---|\n";
  for (const Goal& goal : goals)
    text += "| " + goal.text + " | " + goal.figure + " | " +
            (goal.figure.empty() ? "not measured"
             : goal.met          ? "met"
                                 : "**missed**") +
            " |\n";
  return text;
}

std::string counts_text(const Report& report) {
  std::string text =
      "Bytes that a pass has to read and write for a kernel, and the work of a whole picture. Each "
      "submission is one wait "
      "of the host. Barriers are those of memory.\n\n"
      "| kernels | eyes | drawn by | skin, B | project, B | sort, B | dispatches | barriers | submissions | "
      "uploaded, kB | "
      "device memory of a kernel, B |\n|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const TimesRow& row : report.times) {
    text += format_text("| %zu | %d | %s | %.1f | %.1f | %.1f | %llu | %llu | %llu | %.1f | %.1f |\n",
                        row.kernels, row.eyes, name_of(row.method), a_kernel(row.bytes.skin, row),
                        a_kernel(row.bytes.project, row), a_kernel(row.bytes.sort, row),
                        static_cast<unsigned long long>(row.whole.dispatches),
                        static_cast<unsigned long long>(row.whole.barriers),
                        static_cast<unsigned long long>(row.whole.submissions),
                        1e-3 * static_cast<double>(row.whole.uploaded_bytes), row.memory_bytes_a_kernel);
  }
  return text;
}

}  // namespace

std::string device_csv(const DeviceFacts& device) {
  std::string text = "property,value\n";
  for (const auto& [property, value] : device.all) text += property + "," + csv_field(value) + "\n";
  return text;
}

std::string parity_csv(const Parity& parity) {
  std::string text = "suite,test,verdict,milliseconds\n";
  for (const ParityRow& row : parity.rows)
    text += format_text("%s,%s,%s,%.0f\n", csv_field(row.suite).c_str(), csv_field(row.test).c_str(),
                        row.verdict.c_str(), row.ms);
  return text;
}

std::string times_csv(const Report& report) {
  std::string text =
      "# " + report.device.name +
      "\nkernels,eyes,width,height,method,blend_bits,frames,skin_ms,skin_max_ms,skin_rigid_ms,skin_rigid_max_"
      "ms,"
      "upload_ms,upload_max_ms,project_ms,project_max_ms,sort_ms,sort_max_ms,draw_ms,draw_max_ms,"
      "device_skin_ms,device_project_ms,device_sort_ms,device_draw_ms,device_resolve_ms,"
      "bytes_a_kernel,bar_bytes,frame_ms,frame_max_ms,eyes_a_draw,submissions,dispatches,barriers,"
      "uploaded_bytes,copy_gb_s";
  for (const PassRow& pass : kPasses)
    text += format_text(",%s_bytes_a_kernel,%s_share", pass.name, pass.name);
  text += "\n";
  for (const TimesRow& row : report.times) {
    text += format_text("%zu,%d,%d,%d,%s,%d,%d", row.kernels, row.eyes, row.width, row.height,
                        name_of(row.method), row.blend_bits, row.frames);
    for (const Span* span : {&row.skin, &row.skin_rigid, &row.upload, &row.project, &row.sort, &row.draw})
      text += format_text(",%.2f,%.2f", span->median_ms, span->max_ms);
    for (const PassRow& pass : kPasses) text += format_text(",%.3f", row.device.*pass.ms);
    text += format_text(",%.1f,%.0f,%.2f,%.2f,%d,%llu,%llu,%llu,%llu,%.3g", row.memory_bytes_a_kernel,
                        kGoalBytesAKernel, row.frame.median_ms, row.frame.max_ms, row.whole.eyes_a_draw,
                        static_cast<unsigned long long>(row.whole.submissions),
                        static_cast<unsigned long long>(row.whole.dispatches),
                        static_cast<unsigned long long>(row.whole.barriers),
                        static_cast<unsigned long long>(row.whole.uploaded_bytes),
                        report.copy ? 1e-9 * report.copy->bytes_s : 0);
    for (const PassRow& pass : kPasses)
      text +=
          format_text(",%.1f,%.3f", a_kernel(row.bytes.*pass.bytes, row),
                      has_share(row, pass) ? share(row.bytes.*pass.bytes, row.device.*pass.ms, report) : 0.0);
    text += "\n";
  }
  return text;
}

std::string page(const Report& report) {
  const DeviceFacts& device = report.device;
  std::string text = "# GPU report: " + device.name + "\n\n";
  text += format_text("Driver %s, Vulkan %s, %.1f GB of device memory", device.driver.c_str(),
                      device.api_version.c_str(), 1e-9 * device.memory_bytes);
  if (report.copy)
    text += format_text(", %.0f GB/s in a copy of %.0f MB (reads and writes together)",
                        1e-9 * report.copy->bytes_s, 1e-6 * report.copy->buffer_bytes);
  text += ". All properties are in `device.csv`.\n\n## Parity\n\n" + parity_text(report.parity);
  if (!report.physics.empty()) text += "\n## Physics\n\n" + physics_text(report.physics, device.software);
  if (report.times.empty()) return text + "\n## Times\n\nNot run.\n";
  if (device.software) {
    text +=
        "\n## Counts\n\nThis is a software device. Its times say nothing about a GPU, so this page has "
        "counts only; the times are in "
        "`times.csv`. ";
    return text + counts_text(report);
  }
  return text + "\n## Times\n\n" + times_text(report) + "\n## Goals\n\n" + goals_text(report) +
         "\n## Counts\n\n" + counts_text(report);
}

}  // namespace livegs::gpu_report
