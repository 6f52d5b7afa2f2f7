// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/simulate/csv_file.h"

#include <charconv>

#include "core/file.h"
#include "core/written_files.h"

namespace livegs {
namespace {

constexpr size_t kBuffer = 1 << 20;

}  // namespace

Result<CsvFile> CsvFile::create(const std::filesystem::path& path, const char* header) {
  CsvFile csv;
  csv.file_.reset(std::fopen(path.c_str(), "w"));
  if (!csv.file_) return file_error(path, "cannot be written");
  note_written(path);
  csv.rows_.reserve(kBuffer + (kBuffer >> 4));
  csv.rows_ += header;
  csv.rows_ += '\n';
  return csv;
}

void CsvFile::begin_cell() {
  if (!fresh_row_) rows_ += ',';
  fresh_row_ = false;
}

CsvFile& CsvFile::text(std::string_view value) {
  begin_cell();
  if (value.find_first_of(",\"\n") == std::string_view::npos) {
    rows_ += value;
    return *this;
  }
  rows_ += '"';
  for (const char letter : value) {
    if (letter == '"') rows_ += '"';
    rows_ += letter;
  }
  rows_ += '"';
  return *this;
}

CsvFile& CsvFile::integer(uint64_t value) {
  begin_cell();
  char digits[24];
  const auto end = std::to_chars(digits, digits + sizeof digits, value);
  rows_.append(digits, end.ptr);
  return *this;
}

CsvFile& CsvFile::number(double value, int digits) {
  begin_cell();
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, digits);
  rows_.append(text, end.ptr);
  return *this;
}

void CsvFile::end_row() {
  rows_ += '\n';
  fresh_row_ = true;
  if (rows_.size() >= kBuffer) flush();
}

void CsvFile::flush() {
  std::fwrite(rows_.data(), 1, rows_.size(), file_.get());
  rows_.clear();
}

bool CsvFile::close() {
  if (!file_) return true;
  flush();
  std::FILE* raw = file_.release();
  const bool fine = std::ferror(raw) == 0;
  return std::fclose(raw) == 0 && fine;
}

}  // namespace livegs
