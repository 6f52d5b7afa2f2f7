// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "core/result.h"

namespace livegs {

// A buffered CSV writer for large files, such as dumps of kernels with a hundred million numbers. Cells are
// appended in order; end_row() ends a row.
class CsvFile {
 public:
  static Result<CsvFile> create(const std::filesystem::path& path, const char* header);

  CsvFile& text(std::string_view value);  // quoted only if necessary (RFC 4180)
  CsvFile& integer(uint64_t value);
  CsvFile& number(double value, int digits = 12);  // significant digits, as with printf's %g
  template <class Vector>
  CsvFile& vector(const Vector& v, int digits = 12) {
    return number(v[0], digits).number(v[1], digits).number(v[2], digits);
  }
  template <class Matrix>
  CsvFile& matrix(const Matrix& m, int digits = 12) {  // row by row
    for (int row = 0; row < 3; ++row) vector(m.row(row), digits);
    return *this;
  }
  void end_row();

  // Flushes and closes the file. Returns false if any write failed.
  bool close();

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  void begin_cell();
  void flush();

  std::unique_ptr<std::FILE, Closer> file_;
  std::string rows_;  // not yet written
  bool fresh_row_ = true;
};

}  // namespace livegs
