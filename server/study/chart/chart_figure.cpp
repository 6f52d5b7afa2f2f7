// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/chart/chart_figure.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "study/chart/chart_words.h"
#include "study/chart/gnuplot.h"

namespace livegs::study {
namespace {

// Colours of Okabe and Ito, which are distinguishable with colour blindness. Shade and symbol show the width
// of `cells`.
struct Style {
  const char* prefix;  // prefix of the curve's label
  const char* colour;
  int dash, symbol;
  double line;
};
constexpr Style kStyles[] = {
    {"cells, 12.5 mm", "#0072B2", 1, 9, 1.2},
    {"cells, 25 mm", "#0072B2", 1, 7, 2.6},
    {"cells, 50 mm", "#0072B2", 1, 5, 1.2},
    {"cells, 100 mm", "#0072B2", 1, 13, 1.2},
    {"cells uncompensated", "#E69F00", 2, 6, 1.4},
    {"cells BDF1 uncompensated", "#999999", 4, 4, 1.4},
    {"cells BDF1", "#009E73", 2, 8, 1.4},
    {"livegs-v1 steady", "#CC79A7", 1, 10, 1.6},
    {"livegs-v1", "#D55E00", 1, 11, 1.6},
    {"livegs", "#0072B2", 1, 7, 2.6},
    {"bullet", "#000000", 1, 12, 1.6},
    {"ode quick", "#E69F00", 1, 6, 1.4},
    {"ode", "#D55E00", 2, 8, 1.4},
};

Style style_of(const std::string& label) {
  for (const Style& style : kStyles) {
    if (label.rfind(style.prefix, 0) == 0) return style;
  }
  return {"", "#444444", 3, 1, 1.0};
}

struct Range {
  double low, high;

  double clamp(double value) const { return std::isfinite(value) ? std::clamp(value, low, high) : high; }
};
constexpr Range kPercentRange{1e-5, 20.0};

// The range of drawn errors, including the bar and at most four decades below it.
Range error_range(const Panel& panel) {
  Range range{panel.bar, panel.bar};
  for (const Curve& curve : panel.curves) {
    for (const CurvePoint& point : curve.points) {
      if (!std::isfinite(point.error)) continue;
      range.low = std::min(range.low, point.error);
      range.high = std::max(range.high, point.error);
    }
  }
  return {0.5 * std::max(range.low, 1e-4 * panel.bar), 4.0 * range.high};
}

std::string axis_text(const Panel& panel) {
  if (panel.unit == "relative" || panel.unit == "absolute") return "error of " + spaced(panel.quantity);
  return spaced(panel.quantity) + " (" + panel.unit + ")";
}

std::string bar_text(const Panel& panel) { return "bar: " + error_text(panel.bar, panel.unit); }

void plot_panel(std::FILE* out, const Figure& figure, size_t index, const Range& costs) {
  const Panel& panel = figure.panels[index];
  const size_t count = figure.panels.size();
  const Range errors = figure.same_axis ? kPercentRange : error_range(panel);
  const double left = 0.07, right = 0.985, gap = figure.same_axis ? 0.02 : 0.08;
  const double width = (right - left - gap * static_cast<double>(count - 1)) / static_cast<double>(count);
  const double from = left + static_cast<double>(index) * (width + gap);
  std::fprintf(out, "set lmargin at screen %.4f\nset rmargin at screen %.4f\n", from, from + width);
  std::fprintf(out, "set title '%s' offset 0,-0.6\n", panel.title.c_str());
  if (index == 0 || !figure.same_axis) {
    std::fprintf(out, "set format y '10^{%%T}'\nset ylabel '%s'%s\n", axis_text(panel).c_str(),
                 figure.same_axis ? "" : " offset 1,0");
  } else {
    std::fprintf(out, "set format y ''\nunset ylabel\n");
  }
  std::fprintf(out, "set xrange [%g:%g]\nset yrange [%g:%g]\n", costs.low, costs.high, errors.low / 1.6,
               errors.high * 1.6);
  for (size_t c = 0; c < panel.curves.size(); ++c) {
    std::fprintf(out, "$c%zu << EOD\n", c);
    for (const CurvePoint& point : panel.curves[c].points) {
      const char* apart = std::isfinite(point.error) ? "" : "\n";  // gnuplot leaves a gap at an empty line
      std::fprintf(out, "%s%g %g %d\n%s", apart, point.cost_ms, errors.clamp(point.error), point.substeps,
                   apart);
    }
    std::fprintf(out, "EOD\n");
  }
  if (panel.chosen) {
    std::fprintf(out, "$chosen << EOD\n%g %g\nEOD\n", panel.chosen->cost_ms,
                 errors.clamp(panel.chosen->error));
  }
  std::fprintf(out, "plot %g with lines dt 3 lw 1.2 lc rgb '#444444'", panel.bar);
  for (size_t c = 0; c < panel.curves.size(); ++c) {
    const Style style = style_of(panel.curves[c].label);
    std::fprintf(out, ", $c%zu with linespoints lc rgb '%s' dt %d pt %d ps 0.55 lw %.1f", c, style.colour,
                 style.dash, style.symbol, style.line);
    if (c == 0)
      std::fprintf(out, ", $c0 using 1:2:3 with labels offset 0,0.7 font ',8' tc rgb '%s'", style.colour);
  }
  if (panel.chosen) std::fprintf(out, ", $chosen with points pt 3 ps 1.3 lw 2.4 lc rgb '#B00020'");
  std::fprintf(out, "\n");
}

// A strip without axes with the names of the curves.
void plot_key(std::FILE* out, const Figure& figure) {
  const Panel& panel = figure.panels.front();
  std::fprintf(
      out,
      "set lmargin at screen 0.02\nset rmargin at screen 0.98\nset tmargin at screen 0.165\n"
      "set bmargin at screen 0.0\nunset title\nunset xlabel\nunset ylabel\nunset tics\nunset border\n"
      "unset grid\nunset logscale\nset xrange [0:1]\nset yrange [0:1]\n"
      "set key inside center center vertical maxrows 4 Left reverse samplen 3 spacing 1.1 width 1 font "
      "',10.5'\nplot ");
  for (const Curve& curve : panel.curves) {
    const Style style = style_of(curve.label);
    std::fprintf(out, "NaN with linespoints lc rgb '%s' dt %d pt %d ps 0.6 lw %.1f title '%s', ",
                 style.colour, style.dash, style.symbol, style.line, curve.label.c_str());
  }
  if (panel.chosen) {
    std::fprintf(out, "NaN with points pt 3 ps 1.3 lw 2.4 lc rgb '#B00020' title 'chosen by the program', ");
  }
  std::fprintf(out, "NaN with lines dt 3 lw 1.2 lc rgb '#444444' title '%s'\n",
               figure.same_axis ? bar_text(panel).c_str() : "bar");
}

void plot_figure(std::FILE* out, const Figure& figure, const Range& costs) {
  std::fprintf(out,
               "set multiplot\nset logscale xy\nset grid xtics ytics lc rgb '#e4e4e4'\nunset key\n"
               "set tmargin at screen 0.825\nset bmargin at screen 0.285\nset tics font ',10'\n"
               "set format x '10^{%%T}'\nset xlabel 'ms of CPU per simulated second' offset 0,0.4\n");
  std::fprintf(out, "set label 1 '%s' at screen 0.02,0.965 font ',14' noenhanced\n",
               gnuplot_text(figure.title).c_str());
  std::fprintf(out, "set label 2 '%s' at screen 0.02,0.925 font ',10' tc rgb '#555555'\n",
               gnuplot_text(figure.settings).c_str());
  std::fprintf(out, "set label 3 '%s' at screen 0.02,0.893 font ',10' tc rgb '#555555'\n",
               gnuplot_text(figure.note).c_str());
  for (size_t i = 0; i < figure.panels.size(); ++i) {
    plot_panel(out, figure, i, costs);
    std::fprintf(out, "unset label 1\nunset label 2\nunset label 3\n");
  }
  plot_key(out, figure);
  std::fprintf(out, "unset multiplot\n");
}

}  // namespace

Figure elastic_figure(const ChartScene& scene, std::vector<Panel> panels) {
  char settings[256];
  std::snprintf(settings, sizeof settings,
                "density 1000 kg/m^3, nu %g, 60 Hz; each curve from few to many substeps per frame, "
                "numbered on the thick curve",
                scene.poisson_ratio);
  const std::string quantity = panels.empty() ? "" : spaced(panels.front().quantity);
  return {scene.title + ", " + quantity, settings, std::move(panels), true};
}

Result<void> draw_figure(const Figure& figure, const std::filesystem::path& svg) {
  const std::vector<Panel>& panels = figure.panels;
  if (panels.empty()) return {};
  Range costs{1e300, 0.0};
  for (const Panel& panel : panels) {
    for (const Curve& curve : panel.curves) {
      for (const CurvePoint& point : curve.points) {
        costs.low = std::min(costs.low, 0.6 * point.cost_ms);
        costs.high = std::max(costs.high, 1.7 * point.cost_ms);
      }
    }
  }
  const size_t width = std::max<size_t>(860, (figure.same_axis ? 260 : 200) + 290 * panels.size());
  return draw_with_gnuplot(svg, width, 520, [&](std::FILE* out) { plot_figure(out, figure, costs); });
}

}  // namespace livegs::study
