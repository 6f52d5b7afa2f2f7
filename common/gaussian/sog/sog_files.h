// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "gaussian/asset/bytes.h"

namespace livegs {

// The files of a SOG asset: members of a zip archive, or of a folder.
class SogFiles {
 public:
  explicit SogFiles(std::string_view name) : name_(name) {}
  virtual ~SogFiles() = default;

  // Rejects names that contain a path: files outside the asset are never opened.
  Result<std::vector<std::byte>> read(std::string_view file) const;

 protected:
  virtual Result<std::vector<std::byte>> read_plain_name(const std::string& file) const = 0;

  std::string name_;  // name of the asset in errors
};

// `zip` must outlive the result.
Result<std::unique_ptr<SogFiles>> open_sog_bundle(Bytes zip, std::string_view name);
// `index`: the meta.json, whose name may be in any letter case.
std::unique_ptr<SogFiles> open_sog_folder(const std::filesystem::path& index, std::string_view name);

// A zip archive with these files, stored without compression (WebP has its own), the same bytes each time.
struct NamedBytes {
  std::string name;
  std::vector<std::byte> bytes;
};
Result<std::vector<std::byte>> write_sog_bundle(const std::vector<NamedBytes>& files);

}  // namespace livegs
