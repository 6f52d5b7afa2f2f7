// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/run/explain_page.h"

#include <algorithm>
#include <cmath>

#include "analysis/division/part_places.h"
#include "analysis/estimate/physics_values.h"
#include "core/text/format_text.h"
#include "core/text/shown_text.h"

namespace livegs {
namespace {

// The policy forbids scripts and external content, in case an escape is missed.
constexpr const char* kHead = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; img-src data:; style-src 'unsafe-inline'">
<meta name="viewport" content="width=device-width">
<style>
body { font: 15px/1.45 system-ui, sans-serif; color: #222; max-width: 70em; margin: 2em auto; padding: 0 1em; }
h1 { font-size: 1.5em; margin-bottom: 0; } h2 { font-size: 1.15em; margin-top: 2em; }
table { border-collapse: collapse; } td, th { text-align: left; padding: .2em .8em .2em 0; vertical-align: top; }
td.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
tr + tr td { border-top: 1px solid #ddd; }
pre { background: #f4f4f2; padding: .8em; overflow-x: auto; white-space: pre-wrap; overflow-wrap: anywhere; }
figure { display: inline-block; margin: 0 1em 1em 0; } figure img { max-width: 24em; max-height: 24em; border: 1px solid #ccc; }
figcaption { color: #555; } .verdict { font-weight: 600; } .off { color: #777; }
.bar { position: relative; width: 12em; height: .7em; background: #eee; } .bar span { position: absolute; top: 0; bottom: 0; }
</style>
)";

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      case '\'':
        result += "&#39;";
        break;
      default:
        result += static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t' ? ' ' : c;
    }
  }
  return result;
}

std::string base64(std::string_view bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t three = 0;
    for (size_t k = 0; k < 3; ++k) {
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    }
    for (size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[three >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

// Formats four digits, without an exponent where readable.
std::string number(double value) {
  if (std::abs(value) < 1e4 || std::abs(value) >= 1e7) return format_text("%.4g", value);
  const double step = std::pow(10, std::floor(std::log10(std::abs(value))) - 3);
  return format_text("%.0f", std::round(value / step) * step);
}

// Compares two ranges on a logarithmic scale; grey before, blue after.
std::string range_bar(const v1::EstimatedValue& before, const v1::EstimatedValue& after) {
  if (!(before.low() > 0) || !(after.low() > 0)) return "";
  const double low = std::log(std::min(before.low(), after.low())),
               high = std::log(std::max(before.high(), after.high()));
  if (!(high > low)) return "";
  const auto span = [&](const v1::EstimatedValue& value, const char* colour) {
    const double left = 100 * (std::log(value.low()) - low) / (high - low);
    const double width = std::max(1.0, 100 * (std::log(value.high()) - std::log(value.low())) / (high - low));
    return "<span style=\"left:" + number(left) + "%;width:" + number(width) + "%;background:" + colour +
           "\"></span>";
  };
  return "<div class=\"bar\">" + span(before, "#bbb") + span(after, "#3b7dd8aa") + "</div>";
}

std::string size_text(const ObjectFacts& facts) {
  const Eigen::Vector3d& size = facts.mesh.size_m;
  return number(size.x()) + " x " + number(size.y()) + " x " + number(size.z()) + " m, " +
         (facts.scale_known ? "measured" : "the scale is a guess");
}

struct Shown {
  const char* title;
  const char* unit;
  double factor;
};
Shown shown(std::string_view name) {
  if (name == "mass_kg") return {"mass", "g", 1e3};
  if (name == "youngs_modulus_pa") return {"Young's modulus E", "MPa", 1e-6};
  if (name == "poisson_ratio") return {"Poisson ratio", "", 1};
  if (name == "structure_coefficient") return {"structure coefficient s", "", 1};
  if (name == "deformation_resistance") return {"deformation resistance d_R, of s E", "", 1};
  if (name == "plasticity") return {"plasticity", "", 1};
  if (name == "damping") return {"damping", "", 1};
  if (name == "friction") return {"friction", "", 1};
  if (name == "restitution") return {"restitution", "", 1};
  if (name == "wall_thickness_m") return {"wall thickness", "mm", 1e3};
  return {"break impulse", "N s", 1};
}

// With `before`, the table also has the previous values and the changes of ranges.
std::string value_table(const v1::PhysicalParameters& now, const v1::PhysicalParameters* before) {
  std::string html = "<table>\n<tr><th></th><th>value</th><th>90 % range</th>";
  if (before) html += "<th>before (grey), now (blue)</th><th>before</th>";
  html += "<th>source</th><th>reason</th></tr>\n";
  for (const PhysicsValue& value : physics_values()) {
    if (!(now.*value.has)()) continue;
    const v1::EstimatedValue& after = (now.*value.get)();
    const auto [title, unit, factor] = shown(value.name);
    html += "<tr><td>" + std::string(title) + "</td><td class=\"n\">" + number(after.best() * factor) + " " +
            unit + "</td><td class=\"n\">" + number(after.low() * factor) + " to " +
            number(after.high() * factor) + "</td>";
    if (before) {
      const v1::EstimatedValue& was = (before->*value.get)();
      html += "<td>" + range_bar(was, after) + "</td><td class=\"n off\">" + number(was.best() * factor) +
              "</td>";
    }
    html += "<td>" + std::string(source_name(after.source())) + "</td><td>" + escaped(after.reason()) +
            "</td></tr>\n";
  }
  return html + "</table>\n";
}

// Formats an enumerator as words: OPEN_SHELL as "open shell".
std::string word(std::string name) {
  for (char& c : name) c = c == '_' ? ' ' : static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return escaped(name);
}

std::string parts_text(const v1::PhysicalParameters& now) {
  if (now.parts().empty()) return "";
  std::string text =
      "<br>Parts (" + std::string(source_name(now.parts_source())) + "): " + escaped(now.parts_reason());
  for (int i = 0; i < now.parts_size(); ++i) {
    const Eigen::Vector3f rgb = 255.0f * part_rgb(static_cast<size_t>(i));
    text += format_text("<br><span style=\"background:rgb(%.0f,%.0f,%.0f)\">&emsp;</span> ", rgb.x(), rgb.y(),
                        rgb.z()) +
            escaped(part_line(now.parts(i)));
  }
  return text;
}

std::string figure(const AnalysisImage& image) {
  const bool known = image.media_type == "image/png" || image.media_type == "image/jpeg";
  if (!known) return "";
  return "<figure><img src=\"data:" + image.media_type + ";base64," + base64(image.bytes) + "\" alt=\"" +
         escaped(image.caption) + "\"><figcaption>" + escaped(image.caption) + "</figcaption></figure>\n";
}

// Lists each view once: its camera, then its pictures.
std::string view_section(const AnalysisUpdate& update, std::span<const TargetView> views) {
  std::string html;
  const auto add = [&](const std::string& camera, std::span<const AnalysisImage> images) {
    html += "<div class=\"view\">\n";
    for (const AnalysisImage& image : images) html += figure(image);
    if (!camera.empty()) html += "<p class=\"off\">Seen " + escaped(camera) + ".</p>\n";
    html += "</div>\n";
  };
  for (const TargetView& view : views) {
    std::vector<AnalysisImage> images = view.images;
    images.push_back(view.mask);
    add(view.camera, images);
  }
  if (views.empty()) {
    for (const AnalysisTurn& turn : update.turns) {
      if (!turn.question.images.empty()) add("", turn.question.images);
    }
  }
  return html;
}

std::string turn_section(const AnalysisTurn& turn, size_t index) {
  std::string html = "<h2>Turn " + std::to_string(index + 1) +
                     (turn.repair.empty() ? ": the question" : ": a repair") + "</h2>\n";
  if (!turn.repair.empty()) html += "<p>Sent to the model:</p><pre>" + escaped(turn.repair) + "</pre>\n";
  if (!turn.question.slots.empty()) {
    html += "<table>\n";
    for (const auto& [slot, value] : turn.question.slots) {
      html += "<tr><td>" + escaped(slot) + "</td><td>" + escaped(value) + "</td></tr>\n";
    }
    html += "</table>\n";
  }
  if (!turn.answer.transcript.empty()) {
    html +=
        "<details><summary>The prompt and the exchange, as they were sent (pictures left "
        "out)</summary><pre>" +
        escaped(turn.answer.transcript) + "</pre></details>\n";
  }
  for (const std::string& warning : turn.answer.warnings) html += "<p>" + escaped(warning) + "</p>\n";
  html += "<p>Answer of " + escaped(turn.answer.model) + ", as received:</p><pre>" +
          escaped(turn.answer.json) + "</pre>\n";
  html += turn.error.empty() ? "<p>The gate accepted its form.</p>\n"
                             : "<p>The gate refused it: " + escaped(turn.error) + "</p>\n";
  return html;
}

}  // namespace

std::string explain_page(const AnalysisTarget& target, const AnalysisUpdate& update,
                         std::span<const TargetView> views) {
  const v1::PhysicalParameters& now = update.parameters;
  const std::string name = escaped(shown_text(target.facts->name, 80));
  std::string html = kHead;
  html += "<title>" + name + "</title></head><body>\n<h1>" + name + "</h1>\n";
  html += "<p>" + size_text(*target.facts) + ". Taken for " + escaped(now.label()) + " of " +
          escaped(now.material()) + format_text(", confidence %.2f.</p>\n", now.confidence());
  const Verdict verdict = update.judgement.verdict;
  html +=
      "<p class=\"verdict\">" +
      std::string(verdict == Verdict::Accepted ? "The model's answer was accepted."
                  : verdict == Verdict::NeedsReview
                      ? "The model's answer needs review; the object keeps its values."
                  : update.turns.empty() ? "No model was queried; the object keeps its values."
                                         : "The model's answer was refused; the object keeps its values.") +
      "</p>\n";
  if (!update.judgement.message.empty()) html += "<p>" + escaped(update.judgement.message) + "</p>\n";
  html += view_section(update, views);
  const bool asked = !update.turns.empty();
  html += "<h2>Values</h2>\n" + value_table(now, asked ? &target.offline : nullptr);
  html += "<p>Behaviour: " + word(v1::Physics::Behavior_Name(now.behavior())) + "; " +
          escaped(now.behavior_reason()) + "<br>Fill: " + word(v1::Physics::Fill_Name(now.fill())) + "; " +
          escaped(now.fill_reason()) + "<br>Fragile: " + (now.fragile() ? "yes" : "no") + parts_text(now) +
          "</p>\n";
  if (verdict == Verdict::NeedsReview) {
    html += "<h2>The proposal</h2>\n" + value_table(update.judgement.proposal, &target.offline);
  }
  if (asked) {
    html += "<h2>What the gate did</h2>\n<ul>\n";
    for (const std::string& change : update.judgement.changes) html += "<li>" + escaped(change) + "</li>\n";
    if (update.judgement.changes.empty()) html += "<li>nothing</li>\n";
    html += "</ul>\n";
  }
  if (!update.judgement.remarks.empty()) {
    html += "<h2>What else the model said</h2>\n<ul>\n";
    for (const std::string& remark : update.judgement.remarks) html += "<li>" + escaped(remark) + "</li>\n";
    html += "</ul>\n";
  }
  for (size_t i = 0; i < update.turns.size(); ++i) html += turn_section(update.turns[i], i);
  const v1::AnalysisRecord& record = update.record;
  if (asked) {
    html += "<h2>Where it came from</h2>\n<table>\n";
    const std::pair<const char*, std::string> rows[] = {
        {"model", record.model()},
        {"endpoint", record.endpoint()},
        {"prompt", record.prompt_version()},
        {"views", record.views() > 0 ? std::to_string(record.views()) : "none: the model takes no pictures"},
        {"tokens", std::to_string(record.prompt_tokens()) + " in, " +
                       std::to_string(record.completion_tokens()) + " out"},
        {"cost", record.cost_usd() > 0 ? number(record.cost_usd()) + " USD" : "unknown"},
        {"wall time", update.cached ? "from the cache" : number(record.wall_s()) + " s"},
        {"question", record.question_hash()},
        {"answer", record.answer_hash()}};
    for (const auto& [title, text] : rows) {
      html += "<tr><td>" + std::string(title) + "</td><td>" + escaped(text) + "</td></tr>\n";
    }
    html += "</table>\n";
  }
  return html + "</body></html>\n";
}

}  // namespace livegs
