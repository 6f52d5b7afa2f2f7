// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>

#include "core/result.h"

namespace livegs::study {

// Doubles quotes, as gnuplot requires inside single quotes.
std::string gnuplot_text(const std::string& text);

// Draws an SVG of `width` by `height` pixels with the commands that `write` prints. Fails if gnuplot is not
// installed. Precondition: the path has no line break.
Result<void> draw_with_gnuplot(const std::filesystem::path& svg, size_t width, size_t height,
                               const std::function<void(std::FILE* out)>& write);

}  // namespace livegs::study
