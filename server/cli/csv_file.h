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

// A CSV file that is written row by row, as fast as the numbers can be formatted: a dump of kernels has a
// hundred million of them. Cells follow one another; end_row() ends a row.
class CsvFile {
 public:
  static Result<CsvFile> create(const std::filesystem::path& path, const char* header);

  CsvFile& text(std::string_view value);  // quoted only when it must be (RFC 4180)
  CsvFile& integer(uint64_t value);
  CsvFile& number(double value, int digits = 12);  // significant digits, as printf's %g writes them
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

  // Whether everything reached the disk.
  bool close();

 private:
  struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  void begin_cell();
  void flush();

  std::unique_ptr<std::FILE, Closer> file_;
  std::string rows_;  // not written yet
  bool fresh_row_ = true;
};

}  // namespace livegs
