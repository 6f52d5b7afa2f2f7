// SPDX-License-Identifier: Apache-2.0
#include "gaussian/sog/sog_files.h"

#include <zip.h>

#include <algorithm>

#include "core/file.h"
#include "core/text/shown_text.h"
#include "gaussian/asset/decoded_asset.h"
#include "gaussian/asset/file_below.h"

namespace livegs {
namespace {

struct CloseZip {
  void operator()(zip_t* zip) const { zip_discard(zip); }
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};

class Bundle : public SogFiles {
 public:
  Bundle(std::unique_ptr<zip_t, CloseZip> zip, uint64_t bytes, std::string_view name)
      : SogFiles(name), zip_(std::move(zip)), bytes_(bytes) {}

 protected:
  Result<std::vector<std::byte>> read_plain_name(const std::string& file) const override {
    const std::string prefix = name_ + ": ";
    zip_stat_t stat;
    zip_stat_init(&stat);
    if (zip_stat(zip_.get(), file.c_str(), 0, &stat) != 0 || !(stat.valid & ZIP_STAT_SIZE)) {
      return invalid_data(prefix + "the archive has no file " + file);
    }
    if (stat.size > kMaxCompressionRatio * bytes_)
      return invalid_data(prefix + "file " + file + " is larger than the archive can hold");
    const std::unique_ptr<zip_file_t, CloseZip> entry(zip_fopen_index(zip_.get(), stat.index, 0));
    if (!entry)
      return invalid_data(prefix + "file " + file + " of the archive cannot be read (" +
                          zip_strerror(zip_.get()) + ")");
    std::vector<std::byte> bytes(stat.size);
    size_t done = 0;
    while (done < bytes.size()) {
      const zip_int64_t got = zip_fread(entry.get(), bytes.data() + done, bytes.size() - done);
      if (got <= 0) return invalid_data(prefix + "file " + file + " of the archive is damaged or truncated");
      done += static_cast<size_t>(got);
    }
    // libzip verifies the checksum when the end is read.
    std::byte beyond;
    if (zip_fread(entry.get(), &beyond, 1) != 0)
      return invalid_data(prefix + "file " + file + " of the archive is damaged");
    return bytes;
  }

 private:
  std::unique_ptr<zip_t, CloseZip> zip_;
  uint64_t bytes_;
};

class Folder : public SogFiles {
 public:
  Folder(const std::filesystem::path& index, std::string_view name)
      : SogFiles(name), folder_(index.parent_path()), index_(index.filename()) {}

 protected:
  Result<std::vector<std::byte>> read_plain_name(const std::string& file) const override {
    return read_file(folder_ / (file == "meta.json" ? index_ : std::filesystem::path(file)));
  }

 private:
  std::filesystem::path folder_, index_;
};

}  // namespace

Result<std::vector<std::byte>> SogFiles::read(std::string_view file) const {
  const std::string name(file);
  if (name == "." || name.find('/') != name.npos || !is_file_below(name))
    return invalid_data(name_ + ": meta.json: " + quoted_name(name) + " is not a plain file name");
  return read_plain_name(name);
}

Result<std::unique_ptr<SogFiles>> open_sog_bundle(Bytes zip, std::string_view name) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* source = zip_source_buffer_create(zip.data(), zip.size(), 0, &error);
  std::unique_ptr<zip_t, CloseZip> archive(source ? zip_open_from_source(source, ZIP_RDONLY, &error)
                                                  : nullptr);
  if (!archive) {
    const std::string reason = zip_error_strerror(&error);
    zip_error_fini(&error);
    if (source) zip_source_free(source);
    return invalid_data(std::string(name) + ": is not a readable zip archive (" + reason + ")");
  }
  zip_error_fini(&error);
  return std::unique_ptr<SogFiles>(std::make_unique<Bundle>(std::move(archive), zip.size(), name));
}

std::unique_ptr<SogFiles> open_sog_folder(const std::filesystem::path& index, std::string_view name) {
  return std::make_unique<Folder>(index, name);
}

Result<std::vector<std::byte>> write_sog_bundle(const std::vector<NamedBytes>& files) {
  const auto fail = [](const char* reason) {
    return invalid_argument(std::string("sog: the archive cannot be written (") + reason + ")");
  };
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* const source = zip_source_buffer_create(nullptr, 0, 0, &error);
  zip_t* const opened = source ? zip_open_from_source(source, ZIP_CREATE | ZIP_TRUNCATE, &error) : nullptr;
  if (!opened) {
    if (source) zip_source_free(source);
    const Error failed = fail(zip_error_strerror(&error));
    zip_error_fini(&error);
    return failed;
  }
  zip_error_fini(&error);
  zip_source_keep(source);  // read below, after the archive is closed
  const std::unique_ptr<zip_source_t, decltype(&zip_source_free)> kept(source, &zip_source_free);
  std::unique_ptr<zip_t, CloseZip> archive(opened);
  constexpr zip_uint16_t kDosDate = 1 << 5 | 1;  // 1 January 1980
  for (const NamedBytes& file : files) {
    zip_source_t* const content = zip_source_buffer(archive.get(), file.bytes.data(), file.bytes.size(), 0);
    const zip_int64_t index =
        content ? zip_file_add(archive.get(), file.name.c_str(), content, ZIP_FL_ENC_UTF_8) : -1;
    if (index < 0) {
      if (content) zip_source_free(content);
      return fail(zip_strerror(archive.get()));
    }
    const auto entry = static_cast<zip_uint64_t>(index);
    if (zip_set_file_compression(archive.get(), entry, ZIP_CM_STORE, 0) != 0 ||
        zip_file_set_dostime(archive.get(), entry, 0, kDosDate, 0) != 0)
      return fail(zip_strerror(archive.get()));
  }
  if (zip_close(archive.get()) != 0) return fail(zip_strerror(archive.get()));
  archive.release();
  zip_stat_t stat;
  zip_stat_init(&stat);
  if (zip_source_stat(source, &stat) != 0 || !(stat.valid & ZIP_STAT_SIZE) || zip_source_open(source) != 0)
    return fail("the written bytes cannot be read");
  std::vector<std::byte> bytes(stat.size);
  const zip_int64_t got = zip_source_read(source, bytes.data(), bytes.size());
  zip_source_close(source);
  if (got != static_cast<zip_int64_t>(bytes.size())) return fail("the written bytes cannot be read");
  return bytes;
}

}  // namespace livegs
