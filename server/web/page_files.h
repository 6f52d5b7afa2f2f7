// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string_view>

namespace livegs {

// A file of the page, compressed when the server was built.
struct PageFile {
  std::string_view
      path;  // with a hash of the content ("/page.0123456789abcdef.js") if another file refers to it
  std::string_view name;  // "/page.js"
  std::string_view content_type;
  std::string_view etag;  // quoted hash of the content
  std::string_view bytes, gzip, brotli;
  bool named_by_content() const { return path != name; }
};

// Content security policy of the page. A server adds the origins that may embed the page (frame-ancestors).
inline constexpr std::string_view kPagePolicy =
    "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; connect-src 'self'; img-src 'self' data:; "
    "style-src 'self'; worker-src 'self'; base-uri 'none'; form-action 'none'";

// All files of client/web/page, and the generated livegs.wasm, fields.js and native_shaders.js. The table is
// generated at build time (embed_page.cmake).
std::span<const PageFile> page_files();

// The file of a request path; "/" is /index.html. Null: none.
const PageFile* find_page_file(std::string_view path);

}  // namespace livegs
