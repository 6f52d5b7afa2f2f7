// SPDX-License-Identifier: Apache-2.0
#include "core/log.h"

#include "core/log_format.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <string>

namespace livegs {
namespace {

bool json = false;

// Escapes text for a JSON string. Bytes above ASCII are copied unchanged, even if the text is not valid
// UTF-8.
std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      char code[8];
      std::snprintf(code, sizeof code, "\\u%04x", c);
      out += code;
    } else {
      out += c;
    }
  }
  return out;
}

spdlog::logger& logger() {
  // Never destroyed: threads that outlive main may still log.
  static auto* instance = [] {
    auto* made = new spdlog::logger("livegs", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
    made->set_pattern("%H:%M:%S.%e %^%-5l%$ %v");
    made->set_level(spdlog::level::info);
    return made;
  }();
  return *instance;
}

void write(spdlog::level::level_enum level, const char* format, va_list arguments) {
  if (!logger().should_log(level)) return;
  va_list measured;
  va_copy(measured, arguments);
  const int length = std::vsnprintf(nullptr, 0, format, measured);
  va_end(measured);
  std::string text(length > 0 ? static_cast<size_t>(length) : 0, '\0');
  std::vsnprintf(text.data(), text.size() + 1, format, arguments);
  if (json) {
    text = escaped(text.c_str());
  } else {
    // Object and file names may contain line breaks or terminal control characters.
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
  }
  logger().log(level, spdlog::string_view_t(text.data(), text.size()));
}

}  // namespace

void log_as_json() {
  json = true;
  logger().set_pattern(R"({"time":"%Y-%m-%dT%H:%M:%S.%eZ","level":"%l","message":"%v"})",
                       spdlog::pattern_time_type::utc);
}

void set_log_level(LogLevel level) {
  constexpr spdlog::level::level_enum kLevels[] = {
      spdlog::level::debug, spdlog::level::info, spdlog::level::warn, spdlog::level::err, spdlog::level::off};
  logger().set_level(kLevels[static_cast<int>(level)]);
}

#define LIVEGS_LOG_FUNCTION(name, level_name)            \
  void name(const char* format, ...) {                   \
    va_list arguments;                                   \
    va_start(arguments, format);                         \
    write(spdlog::level::level_name, format, arguments); \
    va_end(arguments);                                   \
  }
LIVEGS_LOG_FUNCTION(log_debug, debug)
LIVEGS_LOG_FUNCTION(log_info, info)
LIVEGS_LOG_FUNCTION(log_warn, warn)
LIVEGS_LOG_FUNCTION(log_error, err)
#undef LIVEGS_LOG_FUNCTION

}  // namespace livegs
